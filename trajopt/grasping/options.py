"""What grasping is planned with."""

from dataclasses import dataclass, field

from trajopt.arrays import number, one_of
from trajopt.errors import ShapeError
from trajopt.methods import Knots, Method


@dataclass(frozen=True, kw_only=True)
class GraspingOptions:
    """Options of `pick`, `place` and `pick_and_place`.

    Attributes:
        velocity_scaling: Factor in (0, 1] on the velocity limits.
        acceleration_scaling: Factor in (0, 1] on the acceleration limits.
        aside: How far the tool may leave the line of a straight motion [m].
        turn: How far it may turn there [rad].
        contact_time: How long the object may touch what it stands on, since the lift begins and until the
            lowering ends [s].
        grip_time: Rest after the fingers closed, in which the force builds up [s].
        release_time: Rest before the fingers open, in which the object comes to stand [s].
        configurations: Of the arm that are tried for each grasp and each place.
        attempts: First guesses for each motion.
        method: Transcription and solver with their options.
    """

    velocity_scaling: float = 1.0
    acceleration_scaling: float = 1.0
    aside: float = 2e-3
    turn: float = 0.02
    contact_time: float = 0.15
    grip_time: float = 0.3
    release_time: float = 0.2
    configurations: int = 4
    attempts: int = 16
    method: Method = field(default_factory=Knots)

    def __post_init__(self) -> None:
        """Check that each number can be used."""
        for name in ("velocity_scaling", "acceleration_scaling"):
            if not 0.0 < number(name, getattr(self, name)) <= 1.0:
                raise ShapeError(name, f"must lie in (0, 1], is {getattr(self, name)}")
        for name in ("configurations", "attempts"):
            one_of(name, getattr(self, name), int)
        for name in ("aside", "turn", "contact_time", "configurations", "attempts"):
            if number(name, getattr(self, name)) <= 0.0:
                raise ShapeError(name, f"must be positive, is {getattr(self, name):g}")
        for name in ("grip_time", "release_time"):
            if number(name, getattr(self, name)) < 0.0:
                raise ShapeError(name, f"is negative: {getattr(self, name):g} s")
