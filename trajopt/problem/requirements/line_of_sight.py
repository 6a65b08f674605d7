"""Nothing stands between a frame and a point."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from numpy.typing import ArrayLike

from trajopt.problem.requirements.requirement import MILLIMETRES, Relaxation, Requirement
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, floats, one_of, positive, sequence
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD
from trajopt.values.printed import in_length, in_point, seen_from

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
