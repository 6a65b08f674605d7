"""Outcomes as a suite may bring them: solved, refused, broken and not as expected."""

from dataclasses import replace

from trajopt.lab.suite import RunOutcome
from trajopt.planning.result import Status
from trajopt.verify import Check, CheckKind, Evidence

HELD = Check(
    name="goal: axis",
    subject="tip <of> the arm",
    value=0.05,
    bound=0.1,
    unit="rad",
    time=1.25,
    slack=0.05,
    evidence=Evidence.PROVEN,
    holds=True,
    detail="",
)
CLEAR = replace(
    HELD,
    name="clearance",
    kind=CheckKind.CLEARANCE,
    subject="hand - post",
    value=0.0123,
    bound=0.0,
    unit="m",
    time=0.5,
)
BROKEN = replace(
    HELD,
    name="path: position",
    subject="tip",
    value=0.3,
    unit="m",
    time=0.75,
    evidence=Evidence.SAMPLED,
    holds=False,
)
UNBOUNDED = replace(
    HELD,
    name="torque",
    subject="",
    value=None,
    bound=None,
    unit="Nm",
    time=None,
    evidence=Evidence.UNPROVEN,
)

GOOD = RunOutcome(
    problem="past a post",
    solver="sqp",
    expected=Status.SOLVED,
    status=Status.SOLVED,
    message="",
    constraints=(CLEAR, HELD, UNBOUNDED),
    setup_seconds=0.01,
    cpu_seconds=0.5,
    duration=1.5,
)
FALSE = replace(GOOD, problem="false success", draw=3, constraints=(CLEAR, BROKEN))
REFUSED = replace(
    GOOD,
    problem="too far",
    expected=Status.NO_INVERSE_KINEMATICS,
    status=Status.NO_INVERSE_KINEMATICS,
    message="misses by 1 < 2",
    constraints=(),
    duration=None,
)
FAILED = replace(REFUSED, problem="should be solved", expected=Status.SOLVED)
ALL = (GOOD, FALSE, REFUSED, FAILED)
