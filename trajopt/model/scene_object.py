"""A thing in the scene: shapes in a frame that is placed somewhere."""

from dataclasses import dataclass

from trajopt.model.placement import Placement
from trajopt.model.shapes import Shape

Part = tuple[Shape, Placement]
"""A shape and its placement in the object's frame."""


@dataclass(frozen=True, eq=False)
class SceneObject:
    """A thing in the scene.

    Attributes:
        name: Its id.
        parts: Shapes with their placements in the object's frame; none makes a mere frame.
        placement: Of the object's frame in `frame`.
        frame: "world", a link or tool frame, or another object.
        touch_links: Links that may touch it.
        notes: What its meshes became.
    """

    name: str
    parts: tuple[Part, ...]
    placement: Placement
    frame: str
    touch_links: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()
