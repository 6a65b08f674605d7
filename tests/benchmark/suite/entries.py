"""Entries as a suite may bring them: solved, refused, broken and not as expected."""

from dataclasses import replace

from trajopt.benchmark import Entry
from trajopt.benchmark.entry import Held
from trajopt.planning.result import Status

HELD = Held("goal: axis", "tip <of> the arm", 0.05, 0.1, "rad", 1.25, "proven", True)
CLEAR = Held("clearance", "hand - post", 0.0123, 0.0, "m", 0.5, "proven", True)
BROKEN = Held("path: position", "tip", 0.3, 0.1, "m", 0.75, "sampled", False)
UNBOUNDED = Held("torque", "", None, None, "Nm", None, "unproven", True)

GOOD = Entry(
    problem="past a post",
    draw=0,
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
