"""Result of planning: a verified plan, or the reason why there is none."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from trajopt.errors import PlanningFailed
from trajopt.native import native_cores
from trajopt.problem import Problem
from trajopt.retime import Retimed
from trajopt.solvers import SolveResult
from trajopt.trajectory import Path, Trajectory
from trajopt.verify import Certificate


class Status(Enum):
    """How planning ended; each value says what it means and what to try."""

    SOLVED = "the judge verified the motion"
    START_IN_COLLISION = "the start is in collision: move it, or allow that contact"
    START_OUT_OF_LIMITS = "the start is outside a joint limit: move it inside first"
    START_BREAKS_CONSTRAINT = "the start breaks a path constraint: widen it, or start elsewhere"
    GOAL_IN_COLLISION = "the goal is in collision: move it, or allow that contact"
    GOAL_OUT_OF_LIMITS = "the goal is outside a joint limit: choose another"
    GOAL_BREAKS_CONSTRAINT = "the goal breaks a path constraint: widen it, or choose another goal"
    NO_INVERSE_KINEMATICS = (
        "no configuration found that reaches the goal: move it nearer or widen its tolerance"
    )
    NO_WAYPOINT = "no configuration found for a waypoint: move it or widen its tolerance"
    STUCK = (
        "the solver stopped where constraints do not hold: a local minimum, which another goal "
        "configuration, a smaller margin or waypoints may avoid"
    )
    METHOD_CANNOT = "the method cannot do what is asked: choose another"
    NO_TIMING = "no speed along the path keeps the limits: a joint cannot hold its load there"
    NOT_VERIFIED = "the judge refused the timed motion: a larger margin or more knots may help"


@dataclass(frozen=True, eq=False)
class Plan:
    """A motion that was verified.

    Attributes:
        problem: What was asked.
        path: The path, without time.
        trajectory: The motion.
        certificate: The judge's verdict on it.
    """

    problem: Problem
    path: Path
    trajectory: Trajectory
    certificate: Certificate


@dataclass(frozen=True, eq=False)
class Result:
    """What planning returned.

    Attributes:
        problem: What was asked.
        status: How it ended.
        message: The particulars: which pair, which joint, by how much.
        path: The solver's path, if it got so far.
        solve: The solver's result, if it got so far.
        trajectory: The motion, verified or not, if it got so far.
        timed: What retiming tells of it; None where the method decided on time itself.
        certificate: The judge's verdict, if it got so far.
        counts: Exact numbers of the work done: distance calls, forward kinematics, QP solves, ...
        cpu_seconds: Process time of each stage [s].
        goal_name: Of a goal set: the goal that was reached; `problem` has that goal alone.
    """

    problem: Problem
    status: Status
    message: str
    path: Path | None
    solve: SolveResult | None
    trajectory: Trajectory | None
    timed: Retimed | None
    certificate: Certificate | None
    counts: Mapping[str, int]
    cpu_seconds: Mapping[str, float]
    goal_name: str = ""

    @property
    def verified(self) -> bool:
        """Whether there is a plan and the judge verified it."""
        return self.status is Status.SOLVED

    def require(self) -> Plan:
        """Return the plan.

        Raises:
            PlanningFailed: If there is none; carries this result.
        """
        if self.path is None or self.trajectory is None or self.certificate is None or not self.verified:
            raise PlanningFailed(self.explain(), self)
        return Plan(self.problem, self.path, self.trajectory, self.certificate)

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold; the points are those of the motion, if any."""
        trajectory = self.trajectory
        motion: dict[str, object] = {"joint_names": list(self.problem.reduced.joint_names), "points": []}
        if trajectory is not None:
            motion = trajectory.as_dict()
        return {
            "status": self.status.name,
            "verified": self.verified,
            "message": self.explain(),
            "name": self.problem.name,
            "goal_name": self.goal_name,
            **motion,
            "certificate": None if self.certificate is None else self.certificate.as_dict(),
            "counts": dict(self.counts),
            "native_cores": list(native_cores()),
            "qp_backends": [] if self.solve is None else list(self.solve.qp_backends),
            "cpu_seconds": {**self.cpu_seconds, "total": sum(self.cpu_seconds.values())},
            "path_length": None if self.path is None else self.path.length,
            "duration": None if trajectory is None else trajectory.duration,
        }

    def explain(self) -> str:
        """Say how planning ended, with the particulars, in a sentence or two."""
        text = f"{self.status.name}: {self.status.value}"
        if self.goal_name:
            text += f", at the goal {self.goal_name!r}"
        return f"{text} ({self.message})" if self.message else text
