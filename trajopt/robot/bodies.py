"""Collision bodies: a convex shape (or an exact mesh, if requested) fixed to a frame."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from trajopt.robot.loading.urdf import LinkGeometry, MeshReference
from trajopt.robot.mesh_cover import CoverProgress, MeshPolicy, cover_file, cover_mesh
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.placement import Placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Shape, scaled

ORIGIN = readonly(np.zeros(3))


@dataclass(frozen=True, eq=False)
class CollisionBody(Value):
    """One shape fixed to a frame.

    Attributes:
        name: Its link or object, with a number if there are several.
        owner: The link or scene object that it is part of.
        frame: Link it moves with, or "world".
        placement: Of the shape in that frame.
        centre: Point about which it is scaled, in its own frame, shape (3,) [m]; for a mesh and its cover
            the mean of the mesh's vertices.
        scale: Factor on its size.
    """

    name: str
    owner: str
    frame: str
    placement: Placement
    shape: Shape
    centre: Floats = field(default_factory=lambda: ORIGIN)
    scale: float = 1.0

    def scaled(self, scale: float) -> "CollisionBody":
        """Return it at another scale, relative to its original size, as MoveIt scales links.

        Raises:
            SizeError: If the result is larger than any shape may be.
        """
        return replace(self, shape=scaled(self.shape, scale / self.scale, self.centre), scale=scale)


@dataclass(frozen=True, eq=False)
class RobotBodies:
    """The collision bodies of a robot's links.

    Attributes:
        bodies: The bodies, in the order of the links' shapes.
        mesh_notes: A note on the cover of each mesh.
        notes: The notes on covers that exceed the tolerance.
    """

    bodies: tuple[CollisionBody, ...]
    mesh_notes: tuple[str, ...]
    notes: tuple[str, ...]


def robot_bodies(collisions: Sequence[LinkGeometry], policy: MeshPolicy) -> RobotBodies:
    """Make the collision bodies of a robot's links."""
    bodies: list[CollisionBody] = []
    counts: Counter[str] = Counter()
    links_by_note: dict[str, list[str]] = {}
    coarse: dict[str, None] = {}
    progress = CoverProgress(sum(isinstance(item.geometry, MeshReference | Mesh) for item in collisions))
    for element in collisions:
        shapes: tuple[Shape, ...]
        centre = ORIGIN
        if isinstance(element.geometry, MeshReference | Mesh):
            cover = (
                cover_mesh(element.geometry, policy)
                if isinstance(element.geometry, Mesh)
                else cover_file(element.geometry.path, element.geometry.scale, policy)
            )
            progress.step(element.link)
            shapes, centre = cover.shapes, cover.centre
            links_by_note.setdefault(cover.note, []).append(element.link)
            coarse.update({cover.note: None} if cover.coarse else {})
        else:
            shapes = (element.geometry,)
        for shape in shapes:
            name = f"{element.link}/{counts[element.link]}"
            counts[element.link] += 1
            bodies.append(CollisionBody(name, element.link, element.link, element.placement, shape, centre))
    said = {note: f"{', '.join(links)}: {note}" for note, links in links_by_note.items()}
    return RobotBodies(
        tuple(bodies), tuple(said.values()), tuple(f"collision mesh of {said[note]}" for note in coarse)
    )
