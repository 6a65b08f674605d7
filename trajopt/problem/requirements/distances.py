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
    """Bounds on the distance between points of two frames.

    Fields: arguments of `distance_between`.
    """

    first: str
    second: str
    lower: float
    upper: float
    first_offset: Floats
    second_offset: Floats

    @property
    def frames(self) -> tuple[str, ...]:
        return (self.first, self.second)

    @property
    def units(self) -> tuple[str, ...]:
        return ("m",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        what, found = f"distance of {self.first} from {self.second}", list[Relaxation]()
        if self.lower > 0.0:
            found.append(self.relaxed("lower", f"smallest {what}", self.lower, MILLIMETRES, shrinks=True))
        if np.isfinite(self.upper):
            found.append(self.relaxed("upper", f"largest {what}", 2.0, MILLIMETRES))
        return tuple(found)

    def __str__(self) -> str:
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
        first_offset: Point of the first frame, in its coordinates, shape (3,) [m].
        second_offset: Point of the second frame, in its coordinates, shape (3,) [m].

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: Unless 0 <= lower < upper, with at least one effective bound.
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

    The judge uses the convex parts of objects. It ignores robot links and the objects to which camera and
    target are fixed. Dynamic obstacles are placed by time; objects that appear or expire count at all times.

    Fields: arguments of `line_of_sight`, with `ignore` stored as `ignored`.
    """

    frame: str
    target: Floats
    margin: float
    origin: Floats
    reference: str
    ignored: frozenset[str]

    def obstacles(self, scene: Scene) -> tuple[str, ...]:
        """Return the names of the objects that may not interrupt the line.

        Raises:
            FrameNotFound: If an object to ignore does not exist.
        """
        for name in self.ignored:
            scene.holder(name)
        left_out = {self.frame, self.reference, *self.ignored}
        return tuple(name for name, item in scene.objects.items() if item.parts and name not in left_out)

    @property
    def units(self) -> tuple[str, ...]:
        return ("m",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        return (
            self.relaxed(
                "margin",
                f"margin of the line of sight of {self.frame}",
                0.99 * self.margin,
                MILLIMETRES,
                shrinks=True,
            ),
        )

    def __str__(self) -> str:
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
        frame: Camera: link, tool frame or object.
        target: Target point in `reference`, shape (3,) [m].
        margin: Smallest distance of the line from an object, > 0 [m].
        origin: Start of the line in the camera's frame, shape (3,) [m].
        reference: "world", or the frame that carries the target.
        ignore: Objects that may interrupt the line, such as the observed object.

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
