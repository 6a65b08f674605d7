"""Specification: everything that a motion must do, for the judge, and the verdict on it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from numpy.typing import ArrayLike

from trajopt.problem.requirement import During, Requirement
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.robot.limits import JointLimits
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors.arguments import checked
from trajopt.verify.certificate import Counts


@runtime_checkable
class SampledCheck(Protocol):
    """What a user's own constraint has to offer to be judged.

    Attributes:
        name: Its name in the certificate.
    """

    @property
    def name(self) -> str:
        """Its name in the certificate."""
        ...

    def evaluate(self, times: Floats, positions: Floats) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
        """Evaluate the constraint along a motion.

        Args:
            times: Increasing times, shape (s,) [s].
            positions: Of the group's joints then, shape (s, n) [rad | m].

        Returns:
            Values, shape (s,) or (s, m), and their lower and upper bounds, which must broadcast
            to that shape.
        """
        ...


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Specification(Value):
    """Everything that a motion must do, besides keeping its bodies apart.

    Attributes:
        goals: What must hold at the end; all of them.
        constraints: What must hold at all times.
        waypoints: What must hold together at some moment, for each waypoint by name, in this order.
        partial: What must hold between waypoints.
        sampled: Constraints in user code, judged at samples.
        limits: Limits of the group's joints, or of these and of the joints that mimic them; the robot's
            where None or not named.
        tool_speeds: Largest speeds of tools.
        start_positions: Where the group's joints start, shape (n,) [rad | m]; where the model has them when
            None.
        start_velocities: Velocities at the start, shape (n,) [rad/s | m/s]; at rest when None.
        start_accelerations: The same of accelerations [rad/s^2 | m/s^2]; none when None.
        dwell: How long it stays clear where it ends, at rest, after the end [s]. Where a goal moves, how
            long it has followed that when it ends: the goals hold in its last so many seconds.
        finish_by: When the motion must be at the goal [s]; any time when None.
        clock: What the scene's clock shows when the motion begins, at least 0 [s].
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


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Whether a motion does everything that it must, and nothing about how nearly.

    Attributes:
        verified: Whether every check holds that a certificate of the motion would require.
        counts: The work that it took.
    """

    verified: bool
    counts: Counts
