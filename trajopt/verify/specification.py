"""Specification of a motion for the judge, its criteria, and the verdict."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from numpy.typing import ArrayLike

from trajopt.problem.requirement import During, Requirement
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.robot.joints import JointLimits
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors.arguments import checked
from trajopt.verify.certificate import Check, Counts


@runtime_checkable
class SampledCheck(Protocol):
    """Protocol of a constraint in user code."""

    @property
    def name(self) -> str:
        """Name in the certificate."""
        ...

    def evaluate(self, times: Floats, positions: Floats) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
        """Evaluate the constraint along a motion.

        Args:
            times: Increasing, shape (s,) [s].
            positions: Of the group's joints, shape (s, n) [rad | m].

        Returns:
            Values, shape (s,) or (s, m), and their lower and upper bounds, which must broadcast to that
            shape.
        """
        ...


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Specification(Value):
    """Requirements on a motion, beyond clearance.

    The other fields are arguments of `verify`.

    Attributes:
        start_positions: Of the group's joints, shape (n,) [rad | m]; the model's start by default.
        clock: Scene clock at the start of the motion, at least 0 [s].
    """

    goals: Sequence[Requirement]
    constraints: Sequence[Requirement] = ()
    waypoints: Mapping[str, Sequence[Requirement]] = field(default_factory=dict[str, Sequence[Requirement]])
    partial: Sequence[During[Requirement] | During[SampledCheck]] = ()
    sampled: Sequence[SampledCheck] = ()
    limits: JointLimits | None = None
    tool_speeds: Sequence[ToolSpeed] = ()
    start_positions: Floats | None = None
    start_velocities: Floats | None = None
    start_accelerations: Floats | None = None
    dwell: float = 0.0
    finish_by: float | None = None
    clock: float = 0.0


@dataclass(frozen=True)
class FoundContact:
    """Links or objects that come too near to each other at a time of a motion [s]."""

    first: str
    second: str
    time: float


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Outcome of the judgement without margins.

    Attributes:
        failed: Class of the first criterion that does not hold; None if all do.
        contact: The contact that ended the search for a proof; None if none did.
    """

    failed: "type[Criterion] | None"
    contact: FoundContact | None
    counts: Counts

    @property
    def verified(self) -> bool:
        """Whether every required check of a certificate would hold."""
        return self.failed is None


class Criterion(ABC):
    """One part of the judgement, decided to accept or reject a motion, and measured to write a certificate.

    Both give the same verdict; deciding may stop early and skip measurements.
    """

    @abstractmethod
    def measure(self) -> Iterable[Check]:
        """Judge the criterion and return its checks with margins."""

    def holds(self) -> bool:
        return all(check.holds or not check.required for check in self.measure())
