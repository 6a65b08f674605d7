"""Result of following a curve."""

from collections.abc import Mapping
from dataclasses import dataclass

from trajopt.planning.budget import Stop
from trajopt.planning.result import Plan, Result, SavedResult
from trajopt.planning.status import Certainty, OutcomeSummary, Status
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FollowsCurve
from trajopt.tasks.sequence import StageTime
from trajopt.timing import Retimed
from trajopt.values.errors import PlanningFailed
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_degrees, in_length
from trajopt.values.trajectory import Path, Trajectory
from trajopt.verify import Certificate, CheckKind


@dataclass(frozen=True, kw_only=True)
class StopReason:
    """Place and reason of a stop before the end of the curve.

    Attributes:
        at: Length along the curve [m].
        message: Details: joint and limit, pair, or jump.
        joint: The joint at its limit, or the one that would jump; empty for other reasons.
        pair: The two that are too near; empty for other reasons.
        amount: The missing clearance [m], the limit [rad | m], or the jump [rad | m]; 0 if unknown.
    """

    status: Status
    at: float
    pose: int
    message: str
    joint: str | None = None
    pair: tuple[str, str] | None = None
    amount: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Followed(SavedResult):
    """The followed part of a curve, and the motion.

    Attributes:
        fraction: Followed part of the required length; judged if there is a verified motion.
        stop: The reason for a stop; None if the whole curve is followed.
        around: The obstacle that the motion avoids inside the tube; None without one.
    """

    required: FollowsCurve
    fraction: float
    stop: StopReason | None
    around: StopReason | None
    result: Result

    @property
    def status(self) -> Status:
        """The status: SOLVED if the whole curve is followed."""
        return self.result.status if self.stop is None else self.stop.status

    @property
    def problem(self) -> Problem:
        return self.result.problem

    @property
    def path(self) -> Path | None:
        """Knots of the joints; None if nothing could be followed."""
        return self.result.path

    @property
    def timed(self) -> Retimed | None:
        """The motion as retiming returned it, if there is any."""
        return self.result.timed

    @property
    def certificate(self) -> Certificate | None:
        """The judge's verdict on the motion."""
        return self.result.certificate

    @property
    def counts(self) -> Mapping[str, int]:
        return self.result.counts

    @property
    def cpu_seconds(self) -> Mapping[str, float]:
        """Process time of each stage [s]."""
        return self.result.cpu_seconds

    @property
    def stopped(self) -> Stop | None:  # pyright: ignore[reportIncompatibleVariableOverride]
        """The cause of an early end of planning; None without one."""
        return self.result.stopped

    @property
    def trajectory(self) -> Trajectory | None:
        return self.result.trajectory

    @property
    def verified(self) -> bool:
        """Whether the motion over the followed part is proven."""
        return self.result.verified

    @property
    def complete(self) -> bool:
        """Whether the whole curve is followed, with proof."""
        return self.verified and self.stop is None

    @property
    def deviation(self) -> float:
        """Largest distance from the curve, as the judge measured it [m]; infinite without a motion."""
        return self._measured(CheckKind.CURVE_POSITION)

    @property
    def turn(self) -> float:
        """Largest angle from the curve's orientation, as judged [rad]; 0 if the rotation is free."""
        return self._measured(CheckKind.CURVE_ROTATION, default=0.0)

    def _measured(self, kind: CheckKind, default: float = float("inf")) -> float:
        if self.certificate is None:
            return float("inf")
        found = [check.value for check in self.certificate.checks if check.kind is kind]
        return max((value for value in found if value is not None), default=default)

    @property
    def final_state(self) -> Mapping[str, float]:
        """Joint -> position of all joints at the end of the followed part.

        Raises:
            PlanningFailed: Without a verified motion; carries this result.
        """
        return self.require(0.0).final_state

    @property
    def stages(self) -> tuple[StageTime, ...]:
        """Begin and end of the followed part, as of a task with one stage."""
        return (StageTime(self.problem.name, 0.0, self.require(0.0).trajectory.duration),)

    @checked
    def require(self, fraction: float = 1.0) -> Plan:
        """Return the plan if at least a fraction of the curve is followed.

        Raises:
            PlanningFailed: If less is followed, or it is not proven; carries this result.
        """
        if (
            self.path is None
            or self.trajectory is None
            or self.result.judged is None
            or not self.verified
            or self.fraction < fraction
        ):
            raise PlanningFailed(self.reason, self)
        return Plan(self.problem, self.path, self.trajectory, self.result.judged)

    @property
    def reason(self) -> str:
        """The followed part and the reason for a stop, in a sentence or two."""
        got = f"{self.fraction:.2%} of {in_length(self.required.curve.length)} followed"
        if self.verified:
            turn = f" and {in_degrees(self.turn)}" if self.turn > 0.0 else ""
            got += f", proven, within {in_length(self.deviation)}{turn}"
        if self.around is not None:
            at = in_length(self.around.at)
            got += f", around what blocks it {at} along the curve ({self.around.message})"
        if self.stop is None:
            return got
        after = f"after pose {self.stop.pose}, {in_length(self.stop.at)} along the curve"
        return f"{got}. {self.stop.status.name} {after}: {self.stop.status.value} ({self.stop.message})"

    def explain(self) -> OutcomeSummary:
        """Return the outcome with its evidence, for printing."""
        if self.complete:
            certainty, grounds = Certainty.PROVEN, "the judge verified the motion along the whole curve"
        else:
            certainty = Certainty.EVIDENCE
            grounds = "the search found no motion that gets farther"
            grounds += "; the judge verified the motion so far" if self.verified else ""
        return OutcomeSummary(status=self.status, reason=self.reason, certainty=certainty, grounds=grounds)

    def as_dict(self) -> dict[str, object]:
        trajectory, stop = self.trajectory, self.stop
        motion: dict[str, object] = {"joint_names": list(self.problem.reduced.joint_names), "points": []}
        if trajectory is not None:
            motion = trajectory.as_dict()
        return {
            "status": self.status.name,
            "verified": self.verified,
            "complete": self.complete,
            "fraction": self.fraction,
            "message": self.reason,
            "stop": stop
            and {
                "cause": stop.status.name,
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
