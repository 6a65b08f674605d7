"""Outcomes as a comparison may bring them."""

from dataclasses import replace

from trajopt.lab.suite import IterationRecord, RunOutcome
from trajopt.planning.status import Certainty, Status

FAST = RunOutcome(
    problem="past a post",
    solver="sqp",
    expected=Status.SOLVED,
    status=Status.SOLVED,
    message="",
    attempts=1,
    cpu_seconds=0.1,
    iterations=2,
    cost=1.0,
    duration=2.0,
    path_length=3.0,
    clearance=0.0123,
    violations={},
    history=(IterationRecord(0.05, 1, 0.9, 0.2), IterationRecord(0.1, 1, 1.0, 0.0)),
    tip=((0.0, 0.0, 0.0), (0.5, 0.2, 0.1), (1.0, 0.0, 0.0)),
)
SLOW = replace(FAST, solver="chomp", cpu_seconds=0.4, cost=1.5, duration=2.2, path_length=3.3)
EASY = replace(FAST, problem="box/1", cpu_seconds=0.2)
FAILED = replace(
    EASY, solver="chomp", status=Status.STUCK, message="stuck <here>", cpu_seconds=1.0, attempts=6,
    duration=None, clearance=None, violations={"clearance": 0.04}, tip=(),
)  # fmt: skip
REFUSED = replace(
    FAILED, problem="too far", solver="sqp", expected=Status.NO_INVERSE_KINEMATICS,
    status=Status.NO_INVERSE_KINEMATICS, cost=None, path_length=None, violations={}, history=(),
)  # fmt: skip
REFUSED_TOO = replace(REFUSED, solver="chomp")
UNASKABLE = replace(
    REFUSED, problem="box/2", expected=Status.SOLVED, status=Status.GOAL_IN_COLLISION,
    certainty=Certainty.PROVEN,
)  # fmt: skip
UNASKABLE_TOO = replace(UNASKABLE, solver="chomp")
ALL = (FAST, SLOW, EASY, FAILED, REFUSED, REFUSED_TOO, UNASKABLE, UNASKABLE_TOO)
