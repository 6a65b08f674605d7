"""Collision bodies: convex shapes (or exact meshes, if requested) fixed to frames, and covers of meshes."""

import logging
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import pairwise
from pathlib import Path
from time import monotonic

import numpy as np

from trajopt.native import covers
from trajopt.robot.loading.urdf import LinkGeometry, MeshReference
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.cached import Arrays, cached_arrays
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.shapes.mesh import ALONE, Mesh, load_mesh
from trajopt.values.shapes.shapes import Convex, Shape, convex, scaled
from trajopt.values.shapes.surfaces import closed_surface

_VERSION = 5  # of what is kept: part of the key of the cache
_KEPT = ("vertices", "faces", "ends", "note", "centre", "coarse")


@checked
@dataclass(frozen=True)
class MeshPolicy:
    """Representation of a collision mesh.

    Attributes:
        exact: Whether to keep the triangles (slower, and without penetration depth) instead of convex pieces
            that contain them. The inside of closed parts counts as contact; open parts have no inside.
        hull_excess: A mesh becomes its convex hull if that adds at most this share of volume
            and protrudes by at most twice the tolerance.
        tolerance: A mesh is cut until its pieces protrude by about this [m]: at most 1.2 times at test
            points, and 1.55 times anywhere; if the allowed work is exceeded, the note contains the
            protrusion.
        large: Tolerance for large meshes, if it is more: at most a twentieth of their longest side [m].
    """

    exact: bool = False
    hull_excess: float = 0.05
    tolerance: float = 0.01
    large: float = 0.0


FINE = 0.005
"""Tolerance of a robot's large meshes, as a share of its reach: a centimetre for two metres, longer than most
arms. An arm of ten metres would need hundreds of pieces for a centimetre.
"""


@dataclass(frozen=True, eq=False)
class Cover:
    """The shapes that represent a mesh.

    Attributes:
        shapes: One convex hull, several convex pieces, or the mesh itself.
        centre: Mean of the mesh's vertices, shape (3,) [m].
        coarse: Whether the shapes protrude farther than the policy allows.
    """

    shapes: tuple[Shape, ...]
    note: str
    centre: Floats
    coarse: bool = False


def _tolerance(policy: MeshPolicy, mesh: Mesh) -> float:
    longest = float(np.ptp(mesh.vertices, axis=0).max())
    return max(policy.tolerance, min(policy.large, longest / 20.0))


def cover_mesh(mesh: Mesh, policy: MeshPolicy) -> Cover:
    """Return the shapes that represent a mesh, and a note on them."""
    centre = mesh.vertices.mean(axis=0)
    if policy.exact:
        known = f"exact mesh of {len(mesh.faces)} triangles"
        doubt = closed_surface(mesh).note
        return Cover((mesh,), f"{known}; {doubt}" if doubt else known, centre)
    tolerance = _tolerance(policy, mesh)
    cover = convex_pieces(mesh, hull_excess=policy.hull_excess, tolerance=tolerance)
    shapes = tuple(convex(piece) for piece in cover.pieces)
    if cover.method is CoverMethod.HULL:
        return Cover(shapes, "convex hull", centre)
    note = f"{len(shapes)} convex pieces"
    coarse = cover.reach > FARTHEST * tolerance
    if coarse:
        far, asked = 1000.0 * cover.reach, 1000.0 * tolerance
        note += (
            f", which protrude by up to {far:.0f} mm: cutting reached its limit of work before "
            f"{asked:g} mm; MeshPolicy(exact=True) keeps the triangles"
        )
    return Cover(shapes, note, centre, coarse)


def cover_file(path: Path, scale: tuple[float, float, float], policy: MeshPolicy) -> Cover:
    """Return the shapes that represent a mesh file, from the cache folder if they were computed before."""
    if policy.exact or path.suffix.lower() not in ALONE or not path.is_file():
        return cover_mesh(load_mesh(path, scale), policy)

    def make() -> Arrays:
        cover = cover_mesh(load_mesh(path, scale), policy)
        shapes = [shape for shape in cover.shapes if isinstance(shape, Convex)]
        return {
            "vertices": np.concatenate([shape.vertices for shape in shapes]),
            "faces": np.concatenate([shape.faces for shape in shapes]),
            "ends": np.cumsum([(len(shape.vertices), len(shape.faces)) for shape in shapes], axis=0),
            "note": np.array(cover.note),
            "centre": cover.centre,
            "coarse": np.array(cover.coarse),
        }

    options = np.array([VERSION, _VERSION, *scale, policy.hull_excess, policy.tolerance, policy.large])
    key = (path.suffix.lower().encode(), options.tobytes(), path.read_bytes())
    kept = cached_arrays("cover", key, _KEPT, make)
    vertices, faces = kept["vertices"], kept["faces"]
    for array in (vertices, faces):
        array.flags.writeable = False
    shapes = tuple(
        Convex(vertices[a:b], faces[c:d])
        for (a, c), (b, d) in pairwise(np.concatenate([[(0, 0)], kept["ends"]]).tolist())
    )
    return Cover(shapes, str(kept["note"]), kept["centre"], bool(kept["coarse"]))


THICKNESS = covers.THICKNESS
"""Least thickness of a piece [m]; flatter pieces are thickened by this, half on either side."""
FARTHEST = covers.FARTHEST
"""Largest protrusion of pieces, in tolerances, if the allowed work suffices."""
VERSION = 4
"""Of the algorithm: part of the key of the cache."""

_SAMPLES = 40_000  # points in the hull of a mesh at which its distance is looked at
_MOST_WORK = 3 * 10**8  # points times planes that cutting may cost, half a second; merging as much again


class CoverMethod(Enum):
    """Method of making a mesh convex."""

    HULL = "hull"
    DECOMPOSITION = "decomposition"


@dataclass(frozen=True, eq=False)
class ConvexCover:
    """Convex pieces whose union contains the surface of a mesh.

    Attributes:
        pieces: Extreme points of each piece, frame of the mesh, shape (k, 3) [m], read-only.
        method: Whether the only piece is the mesh's hull, or the mesh was cut.
        excess: Volume that the hull adds, as a share of the mesh's (the union of its closed parts, with
            inaccessible cavities); infinite if the mesh bounds no volume, None if the hull is within the
            tolerance.
        reach: Upper bound on the protrusion of pieces [m].
    """

    pieces: tuple[Floats, ...]
    method: CoverMethod
    excess: float | None
    reach: float

    def __post_init__(self) -> None:
        for piece in self.pieces:
            readonly(piece)


def convex_pieces(
    mesh: Mesh, *, hull_excess: float = 0.05, tolerance: float = 0.01, max_pieces: int = 64
) -> ConvexCover:
    """Cover the surface of a mesh by convex pieces, cached in $TRAJOPT_CACHE_DIR or the user's cache folder.

    The mesh becomes its hull if that protrudes by at most `tolerance`, or adds at most `hull_excess` of
    volume and protrudes by at most twice the tolerance. Otherwise it is cut until no piece protrudes farther
    than 1.2 times `tolerance` at test points of the hull, and 1.55 times anywhere, unless `max_pieces` or the
    allowed work is exceeded. So a distance to the pieces is at most the true one, and smaller by at most
    `reach`, except in places that a ball of radius `tolerance` cannot enter from outside. An open mesh is a
    thin sheet.

    Args:
        mesh: Closed or open, of one or many parts, which may overlap.
        tolerance: Largest protrusion of pieces [m].
    """
    if not len(mesh.faces):
        raise ShapeError("mesh", "has no face with an area, so there is nothing to cover")
    if not (hull_excess >= 0.0 and tolerance > 0.0 and max_pieces >= 1):
        given = f"{hull_excess:g}, {tolerance:g}, {max_pieces}"
        raise ShapeError("hull_excess, tolerance, max_pieces", f"need >= 0, > 0, >= 1, are {given}")
    options = np.array([VERSION, _SAMPLES, _MOST_WORK, THICKNESS, hull_excess, tolerance, max_pieces])
    key = (mesh.vertices.tobytes(), mesh.faces.tobytes(), options.tobytes())

    def make() -> Arrays:
        cover = _cover(mesh, hull_excess, tolerance, max_pieces)
        return {
            "points": np.concatenate(cover.pieces),
            "ends": np.cumsum([len(piece) for piece in cover.pieces]),
            "method": np.array(cover.method.value),
            "figures": np.array([np.nan if cover.excess is None else cover.excess, cover.reach]),
        }

    kept = cached_arrays("convex", key, ("points", "ends", "method", "figures"), make)
    excess, reach = kept["figures"].tolist()
    pieces = np.split(kept["points"], kept["ends"][:-1])
    known = None if np.isnan(excess) else excess
    return ConvexCover(tuple(pieces), CoverMethod(str(kept["method"])), known, reach)


def _cover(mesh: Mesh, hull_excess: float, tolerance: float, max_pieces: int) -> ConvexCover:
    part, closed = mesh.parts(tolerance)
    points, ends, cut, excess, reach = covers.cover(
        mesh.vertices,
        mesh.faces,
        np.where(closed[part], part, -1).astype(np.int32),
        hull_excess,
        tolerance,
        max_pieces,
        _SAMPLES,
        _MOST_WORK,
    )
    pieces = tuple(_extreme(piece) for piece in np.split(points, ends[:-1]))
    method = CoverMethod.DECOMPOSITION if cut else CoverMethod.HULL
    return ConvexCover(pieces, method, None if np.isnan(excess) else excess, reach)


def _extreme(points: Floats) -> Floats:
    from scipy.spatial import ConvexHull

    return points[ConvexHull(points).vertices]


FIRST = 1.0
_EVERY = 2.0  # between two lines [s]
_LOG = logging.getLogger("trajopt.robot")


@dataclass
class CoverProgress:
    """Reports the number of covered meshes after a second of wall time, then every two seconds.

    The lines go to the logger "trajopt.robot" as warnings.
    """

    total: int
    done: int = 0
    _next: float = field(default_factory=lambda: monotonic() + FIRST)

    def step(self, link: str) -> None:
        self.done += 1
        if self.done < self.total and monotonic() >= self._next:
            self._next = monotonic() + _EVERY
            _LOG.warning(
                "covering collision meshes by convex pieces, kept for the next time: %d of %d done, last %s",
                self.done,
                self.total,
                link,
            )


ORIGIN = readonly(np.zeros(3))


@dataclass(frozen=True, eq=False)
class CollisionBody(Value):
    """One shape fixed to a frame.

    Attributes:
        name: Its link or object, with a number if there are several.
        owner: The link or scene object that it is part of.
        frame: Link it moves with, or "world".
        placement: Of the shape in that frame.
        centre: Point about which it is scaled, in its own frame, shape (3,) [m]; of a mesh the mean of its
            vertices.
    """

    name: str
    owner: str
    frame: str
    placement: Placement
    shape: Shape
    centre: Floats = field(default_factory=lambda: ORIGIN)
    scale: float = 1.0

    def scaled(self, scale: float) -> "CollisionBody":
        """Return it at another scale, relative to its original size, as MoveIt scales links."""
        return replace(self, shape=scaled(self.shape, scale / self.scale, self.centre), scale=scale)


@dataclass(frozen=True, eq=False)
class RobotBodies:
    """The collision bodies of a robot's links."""

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
