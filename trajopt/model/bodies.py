"""Collision bodies: a convex shape (or an exact mesh, if asked for) fixed to a frame."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from trajopt.model.convex import CoverMethod, convex_pieces
from trajopt.model.mesh_file import Mesh, load_mesh
from trajopt.model.placement import Placement
from trajopt.model.shapes import Shape, convex
from trajopt.model.urdf import LinkGeometry, MeshReference


@dataclass(frozen=True)
class MeshPolicy:
    """How a collision mesh becomes what distances are measured to.

    Attributes:
        exact: Keep the triangles themselves (slower, and without depth of penetration) in place
            of convex pieces that contain them.
        hull_excess: A mesh becomes its convex hull where that adds at most this share of volume
            and stands out of the mesh nowhere by more than twice the tolerance.
        tolerance: Convex pieces stand out of the mesh by no more than this, as sampled [m].
    """

    exact: bool = False
    hull_excess: float = 0.05
    tolerance: float = 0.01


@dataclass(frozen=True, eq=False)
class CollisionBody:
    """One shape fixed to a frame.

    Attributes:
        name: Link or object it belongs to, with a number where there are several.
        owner: The link or scene object it is part of.
        frame: Link it moves with, or "world".
        placement: Of the shape in that frame.
        shape: The shape.
    """

    name: str
    owner: str
    frame: str
    placement: Placement
    shape: Shape


@dataclass(frozen=True, eq=False)
class Cover:
    """The shapes that stand for a mesh.

    Attributes:
        shapes: One convex hull, several convex pieces, or the mesh itself.
        note: What they are, in words.
    """

    shapes: tuple[Shape, ...]
    note: str


def cover_mesh(mesh: Mesh, policy: MeshPolicy) -> Cover:
    """Return the shapes that stand for a mesh, and say which they are."""
    if policy.exact:
        return Cover((mesh,), f"exact mesh of {len(mesh.faces)} triangles")
    cover = convex_pieces(mesh, hull_excess=policy.hull_excess, tolerance=policy.tolerance)
    shapes = tuple(convex(piece) for piece in cover.pieces)
    if cover.method is CoverMethod.HULL:
        return Cover(shapes, "convex hull")
    return Cover(shapes, f"{len(shapes)} convex pieces")


def robot_bodies(
    collisions: Sequence[LinkGeometry], policy: MeshPolicy
) -> tuple[tuple[CollisionBody, ...], tuple[str, ...]]:
    """Make the collision bodies of a robot's links.

    Returns:
        The bodies, and sentences that say which links' meshes became what.

    Raises:
        MeshFileError: If a mesh is missing, empty or unreadable.
    """
    bodies: list[CollisionBody] = []
    counts: Counter[str] = Counter()
    links_by_note: dict[str, list[str]] = {}
    for element in collisions:
        shapes: tuple[Shape, ...]
        if isinstance(element.geometry, MeshReference):
            cover = cover_mesh(load_mesh(element.geometry.path, element.geometry.scale), policy)
            shapes = cover.shapes
            links_by_note.setdefault(cover.note, []).append(element.link)
        else:
            shapes = (element.geometry,)
        for shape in shapes:
            name = f"{element.link}/{counts[element.link]}"
            counts[element.link] += 1
            bodies.append(CollisionBody(name, element.link, element.link, element.placement, shape))
    notes = tuple(f"{', '.join(links)}: {note}" for note, links in links_by_note.items())
    return tuple(bodies), notes
