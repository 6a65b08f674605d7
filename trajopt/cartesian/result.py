"""What following a curve returns: how far it got, why it stopped, and the motion with its certificate."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from trajopt.errors import PlanningFailed
from trajopt.model.requirements import FollowsCurve
from trajopt.model.trajectory import Path, Trajectory
from trajopt.planning.result import Plan
from trajopt.problem import Problem
from trajopt.retime import Retimed
from trajopt.verify import Certificate


class Cause(Enum):
    """Why a curve is not followed to its end; each value says what to try."""

    START_OFF_CURVE = "the start is not at the beginning of the curve: move there first, or begin anywhere"
    START_IN_COLLISION = "the start is in collision: move it, or allow that contact"
    START_OUT_OF_LIMITS = "the start is outside a joint limit: move it inside first"
    NO_START = "no configuration reaches the beginning of the curve: move the curve"
    COLLISION = "the arm comes too near something: move it, free the spin, or allow a deviation"
    JOINT_LIMIT = "a joint is at its limit: begin in another branch, free the spin, or move the curve"
    OUT_OF_REACH = "the arm is stretched or folded as far as it goes: move the curve"
    BRANCH_JUMP = (
        "the curve goes on in another branch only, and a joint would have to jump there: begin in that branch"
    )
    NO_TIMING = "no speed along the path keeps the limits: a joint cannot hold its load there"
    NOT_VERIFIED = "the judge refused the timed motion"


@dataclass(frozen=True, kw_only=True)
class Stop:
    """Where and why following ended before the end of the curve.

    Attributes:
        cause: The kind of reason.
        at: How far along the curve [m].
        pose: Number, from 0, of the last pose that was reached, of those the curve was made from.
        message: The particulars: which joint and limit, which pair, which jump.
        joint: The joint at its limit, or the one that would jump; none for other causes.
        pair: The two links or objects that come too near each other; none for other causes.
        amount: What is missing: clearance [m], the limit [rad | m], the jump [rad | m]; 0 where unknown.
    """

    cause: Cause
    at: float
    pose: int
    message: str
    joint: str | None = None
    pair: tuple[str, str] | None = None
    amount: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Followed:
    """How far a curve is followed, and the motion.

    Attributes:
        problem: The motion as a problem: its start, its end, and the curve up to where it got. It goes with
            the motion to `simulate`, `view` and `store`.
        required: The whole curve, as it was asked for.
        fraction: Part of what was asked for that is followed; judged where there is a verified motion.
        stop: Why not more; None if the whole curve is followed.
        around: What was gone around inside the tube, where the curve is blocked; None if nothing was.
        path: Knots of the joints; None if not even the beginning could be done.
        timed: The motion.
        certificate: The judge's verdict on it.
        counts: Exact numbers of the work done.
        cpu_seconds: Process time of each stage [s].
    """

    problem: Problem
    required: FollowsCurve
    fraction: float
    stop: Stop | None
    around: Stop | None
    path: Path | None
    timed: Retimed | None
    certificate: Certificate | None
    counts: Mapping[str, int]
    cpu_seconds: Mapping[str, float]

    @property
    def trajectory(self) -> Trajectory | None:
        """The motion over the part that is followed, if there is any."""
        return None if self.timed is None else self.timed.trajectory

    @property
    def verified(self) -> bool:
        """Whether the motion over the part that is followed is proven."""
        return self.certificate is not None and self.certificate.verified

    @property
    def complete(self) -> bool:
        """Whether the whole curve is followed, and that is proven."""
        return self.verified and self.stop is None

    @property
    def deviation(self) -> float:
        """Largest distance from the curve, as the judge measured it [m]; infinite without a motion."""
        return self._measured("path: curve position")

    @property
    def turn(self) -> float:
        """Largest angle from the curve's orientation, as the judge measured it [rad]; 0 where it is free."""
        return self._measured("path: curve rotation", default=0.0)

    def _measured(self, name: str, default: float = float("inf")) -> float:
        if self.certificate is None:
            return float("inf")
        found = [check.value for check in self.certificate.checks if check.name == name]
        return next((value for value in found if value is not None), default)

    def require(self, fraction: float = 1.0) -> Plan:
        """Return the plan if so much of the curve is followed.

        Args:
            fraction: Least part of the curve.

        Raises:
            PlanningFailed: If less is followed, or it is not proven; carries this result.
        """
        if (
            self.path is None
            or self.trajectory is None
            or self.certificate is None
            or not self.verified
            or self.fraction < fraction
        ):
            raise PlanningFailed(self.explain(), self)
        return Plan(self.problem, self.path, self.trajectory, self.certificate)

    def explain(self) -> str:
        """Say how far the curve is followed and why not farther, in a sentence or two."""
        got = f"{self.fraction:.2%} of {self.required.curve.length:.4g} m followed"
        if self.verified:
            turn = f" and {self.turn:.3g} rad" if self.turn > 0.0 else ""
            got += f", proven, within {self.deviation * 1000.0:.3g} mm{turn}"
        if self.around is not None:
            got += f", around what blocks it {self.around.at:.4f} m along the curve ({self.around.message})"
        if self.stop is None:
            return got
        after = f"after pose {self.stop.pose}, {self.stop.at:.4f} m along the curve"
        return f"{got}. {self.stop.cause.name} {after}: {self.stop.cause.value} ({self.stop.message})"

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold; `store.read_trajectory` reads the motion back."""
        trajectory, stop = self.trajectory, self.stop
        motion: dict[str, object] = {"joint_names": list(self.problem.reduced.joint_names), "points": []}
        if trajectory is not None:
            motion = trajectory.as_dict()
        return {
            "verified": self.verified,
            "complete": self.complete,
            "fraction": self.fraction,
            "message": self.explain(),
            "stop": stop
            and {
                "cause": stop.cause.name,
                "at": stop.at,
                "pose": stop.pose,
                "joint": stop.joint,
                "pair": None if stop.pair is None else list(stop.pair),
                "amount": stop.amount,
                "message": stop.message,
            },
            "deviation": None if self.certificate is None else self.deviation,
            **motion,
            "certificate": None if self.certificate is None else self.certificate.as_dict(),
            "counts": dict(self.counts),
            "cpu_seconds": dict(self.cpu_seconds),
            "duration": None if trajectory is None else trajectory.duration,
        }
