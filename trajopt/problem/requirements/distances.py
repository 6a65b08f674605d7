"""Requirements on distances between frames and on lines of sight."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.requirement import MILLIMETRES, Relaxation, Requirement
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, floats, number, one_of, positive, sequence
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD
from trajopt.values.printed import in_length, in_point, seen_from


@dataclass(frozen=True, eq=False)
class DistanceBetween(Requirement):
    """The distance between a point of one frame and a point of another lies between bounds.

    Made by `distance_between`, whose arguments are its fields.
    """

    first: str
    second: str
    lower: float
    upper: float
    first_offset: Floats
    second_offset: Floats

    @property
    def frames(self) -> tuple[str, ...]:
        """Both frames."""
        return (self.first, self.second)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """Both bounds, as far as there are any."""
        what, found = f"distance of {self.first} from {self.second}", list[Relaxation]()
        if self.lower > 0.0:
            largest = self.lower
            found.append(
                Relaxation.of(
                    self, "lower", f"smallest {what}", largest=largest, unit=MILLIMETRES, shrinks=True
                )
            )
        if np.isfinite(self.upper):
            found.append(Relaxation.of(self, "upper", f"largest {what}", largest=2.0, unit=MILLIMETRES))
        return tuple(found)

    def __str__(self) -> str:
        """Say the bounds that there are."""
        if np.isinf(self.upper):
            apart = f"at least {in_length(self.lower)}"
        elif self.lower == 0.0:
            apart = f"at most {in_length(self.upper)}"
        else:
            apart = f"{in_length(self.lower)} to {in_length(self.upper)}"
        return f"{self.first} and {self.second} {apart} apart"


@checked
def distance_between(
    first: str,
    second: str,
    *,
    lower: float = 0.0,
    upper: float = np.inf,
    first_offset: ArrayLike = (0.0, 0.0, 0.0),
    second_offset: ArrayLike = (0.0, 0.0, 0.0),
) -> DistanceBetween:
    """Require the distance between two points of frames to lie between bounds.

    Args:
        first: Link, tool frame or object, or "world".
        second: Another; both may move.
        lower: Smallest distance, >= 0 [m].
        upper: Largest distance [m]; inf for none.
        first_offset: The point of the first frame, in its coordinates, shape (3,) [m].
        second_offset: The point of the second frame, in its coordinates, shape (3,) [m].

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If the bounds are not 0 <= lower < upper, or nothing is bounded.
    """
    low, high = number("lower", lower), number("upper", upper, infinite=True)
    if not 0.0 <= low < high:
        raise ProblemError(f"distance_between: needs 0 <= lower < upper, has {low:g} m and {high:g} m")
    if low == 0.0 and np.isinf(high):
        raise ProblemError(
            f"distance_between({shown(first)}, {shown(second)}): give a lower or an upper bound"
        )
    offsets = (floats("first_offset", first_offset, (3,)), floats("second_offset", second_offset, (3,)))
    return DistanceBetween(first, second, low, high, *offsets)


MARGIN = 0.01
"""Default clearance of the line of sight [m]."""


@dataclass(frozen=True, eq=False)
class LineOfSight(Requirement):
    """The straight line from a camera to a target keeps clear of the scene's objects.

    Objects count with their convex parts; the robot's links are not considered, nor are the objects that
    camera and target are fixed to. Objects that move by themselves count where they are at each time, and
    those that appear or expire count at all times.

    Made by `line_of_sight`, whose arguments are its fields; `ignored` are the objects to ignore.
    """

    frame: str
    target: Floats
    margin: float
    origin: Floats
    reference: str
    ignored: frozenset[str]

    @property
    def frames(self) -> tuple[str, ...]:
        """Camera and reference."""
        return (self.frame, self.reference)

    def obstacles(self, scene: Scene) -> tuple[str, ...]:
        """Return the names of the objects that may not be in between.

        Args:
            scene: The scene.

        Raises:
            FrameNotFound: If an object to ignore does not exist.
        """
        for name in self.ignored:
            scene.holder(name)
        left_out = {self.frame, self.reference, *self.ignored}
        return tuple(name for name, item in scene.objects.items() if item.parts and name not in left_out)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """The margin."""
        return (
            Relaxation.of(
                self,
                "margin",
                f"margin of the line of sight of {self.frame}",
                largest=0.99 * self.margin,
                unit=MILLIMETRES,
                shrinks=True,
            ),
        )

    def __str__(self) -> str:
        """Say the target, and the margin in millimetres."""
        target = f"{in_point(self.target)}{seen_from(self.reference)}"
        return f"{self.frame} sees {target}, its line of sight clear by {in_length(self.margin)}"


@checked
def line_of_sight(
    frame: str,
    target: ArrayLike,
    *,
    margin: float = MARGIN,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    reference: str = WORLD,
    ignore: Iterable[str] = (),
) -> LineOfSight:
    """Keep objects out of the line from a camera to a point; `gaze` keeps the point in view.

    Args:
        frame: The camera: link, tool frame or object.
        target: The point, in `reference`, shape (3,) [m].
        margin: Smallest distance of the line from an object, > 0 [m].
        origin: Where in the camera's frame the line begins, shape (3,) [m].
        reference: "world", or the name of what the target is fixed to.
        ignore: Objects that may be in between, such as the one that is looked at.

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If the margin is not positive, or `ignore` is a single name.
    """
    return LineOfSight(
        frame,
        floats("target", target, (3,)),
        positive("margin", margin),
        floats("origin", origin, (3,)),
        reference,
        frozenset(one_of("name to ignore", name, str) for name in sequence("ignore", ignore)),
    )
