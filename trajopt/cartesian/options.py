"""What a caller may choose about following a curve."""

from dataclasses import dataclass
from enum import Enum

from trajopt.arrays import number
from trajopt.errors import ProblemError
from trajopt.model.tool_speed import ToolSpeed


class Avoid(Enum):
    """What to do where the curve is blocked."""

    STOP = "follow the curve as far as it goes"
    DEVIATE = "leave the curve inside a tube around it, no farther than needed"


class Begin(Enum):
    """Which configuration the motion begins in."""

    AT_START = "the start, which must be at the beginning of the curve"
    ANY_BRANCH = "any that is at the beginning of the curve: the one that gets farthest"


@dataclass(frozen=True, kw_only=True)
class FollowOptions:
    """Options of `follow`.

    Attributes:
        begin: Which configuration the motion begins in.
        avoid: What to do where the curve is blocked.
        tube: With `Avoid.DEVIATE`, how far the frame may leave the curve [m].
        velocity_scaling: Factor in (0, 1] on the velocity limits.
        acceleration_scaling: Factor in (0, 1] on the acceleration limits.
        tool_speed: Largest speeds of tools, steady if they say so.
        branches: With `Begin.ANY_BRANCH`, most configurations at the beginning that are tried.
    """

    begin: Begin = Begin.AT_START
    avoid: Avoid = Avoid.STOP
    tube: float = 0.0
    velocity_scaling: float = 1.0
    acceleration_scaling: float = 1.0
    tool_speed: tuple[ToolSpeed, ...] = ()
    branches: int = 16

    def __post_init__(self) -> None:
        """Refuse what cannot be meant.

        Raises:
            ProblemError: If a tube is missing, or given though nothing may deviate, or there are no branches.
        """
        radius = number("tube", self.tube)
        if (self.avoid is Avoid.DEVIATE) != (radius > 0.0):
            raise ProblemError(
                f"a tube of {radius:g} m with {self.avoid}: Avoid.DEVIATE needs the radius of the tube "
                "that it may use, Avoid.STOP has none"
            )
        if self.branches < 1:
            raise ProblemError(f"branches must be at least 1, is {self.branches}")
