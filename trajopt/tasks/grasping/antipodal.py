"""Places of two parallel pads on solids of any shape.

Two soft fingers hold a solid if the line between their contacts lies in both friction cones, so the surfaces
there are almost opposite (Nguyen, "Constructing force-closure grasps", IJRR 7(3), 1988).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.values.arrays import Floats, Ints
from trajopt.values.placement import Placement
from trajopt.values.shapes.mesh import Mesh, crossings
from trajopt.values.shapes.shapes import Shape, outermost
from trajopt.values.shapes.surfaces import closed_surface, surface

SAMPLES = 128
"""Points of the surface from which opposite ones are sought."""
SLANT = np.radians(15.0)
"""Largest angle between a pad and the surface: needs friction of 0.27, where rubber has 0.5 or more [rad]."""
PATCH = 5e-3
"""Radius of the contact of a pad: half the width of a narrow one [m]."""
UNEVEN = float(PATCH * np.tan(SLANT))
"""Largest deviation of the surface from a pad within the contact [m]."""
AROUND = 8
"""Directions from which the pads come to a pair of points."""
EACH = 3
"""Places of the pads on each side of the solid."""
RIM = PATCH * np.stack([(np.cos(k * np.pi / 6.0), np.sin(k * np.pi / 6.0)) for k in range(12)])
"""Points of the rim of the contact, shape (12, 2) [m]."""
TRIED = 100
"""Guesses of a place tried on a side: a rough solid of many triangles may refuse all."""
APART = 0.01
"""Places farther apart are different [m]; so are those with a direction turned by more than `TURNED`."""
TURNED = np.radians(30.0)
OFF_EDGES = np.array((0.61803, 0.78615)) * 1e-7
"""Shift of a line, which else would meet the edges that symmetric solids have at their middle [m]."""

SIDES = "+z", "+x", "-x", "+y", "-y", "-z"
"""Sides of an object: the top first."""
DIRECTIONS = np.array([(0, 0, 1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, -1)], dtype=np.float64)
"""Their outward normals, shape (6, 3)."""
ALIGNED = float(np.cos(np.pi / AROUND))
"""Least cosine of the angle between an aligned direction and a side."""


@dataclass(frozen=True, eq=False)
class Pads:
    """A place of two pads.

    Attributes:
        middle: Point between them, shape (3,) [m].
        width: Their distance [m].
        closing: From one to the other, shape (3,), a unit vector.
        outward: Against the approach, shape (3,), a unit vector.
    """

    middle: Floats
    width: float
    closing: Floats
    outward: Floats

    @property
    def name(self) -> str:
        at = tuple((1e3 * self.middle).round().astype(int).tolist())
        along, out = (tuple((axis.round(2) + 0.0).tolist()) for axis in (self.closing, self.outward))
        cosines = DIRECTIONS @ self.outward
        side = SIDES[int(np.argmax(cosines))] if cosines.max() > ALIGNED else out
        return f"from {side} at {at} mm, closing along {along}"

    def is_like_one_of(self, others: Sequence["Pads"]) -> bool:
        return any(
            min(abs(self.closing @ other.closing), self.outward @ other.outward) > np.cos(TURNED)
            and np.linalg.norm(self.middle - other.middle) < APART
            for other in others
        )


def places_of_pads(
    parts: Sequence[tuple[Shape, Placement]], centre: Floats, reach: float, widths: tuple[float, float]
) -> Iterator[Pads]:
    """Yield places on each side of a solid of placed shapes, the nearest to its centre of mass first.

    Open meshes have no inside and are left out.

    Args:
        centre: Centre of mass, shape (3,) [m].
        reach: Overlap of the middle with the solid before the hand would touch it [m].
        widths: Smallest and largest distance of the pads [m].
    """
    solid = _Solid(parts)
    if not len(solid.triangles):
        return
    for guesses in _guesses(solid, centre, reach, widths[1]):
        taken: list[Pads] = []
        for _, guess in sorted(guesses, key=lambda one: one[0])[:TRIED]:
            if len(taken) == EACH:
                break
            fitted = None if guess.is_like_one_of(taken) else _fitted(solid, guess)
            if fitted is None or fitted.is_like_one_of(taken):
                continue
            if widths[0] <= fitted.width <= widths[1]:
                taken.append(fitted)
        yield from taken


class _Solid:
    """Triangles around a solid (m, 3, 3) [m] and their outward normals (m, 3); its parts may overlap."""

    def __init__(self, parts: Sequence[tuple[Shape, Placement]]) -> None:
        placed: list[Floats] = []
        for shape, where in parts:
            if isinstance(shape, Mesh):
                triangles = closed_surface(shape).triangles
            else:
                skin = surface(shape)
                triangles = skin.vertices[skin.faces]
            placed.append(triangles @ where.rotation.T + where.translation)
        triangles = np.concatenate(placed)
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        double_area = np.linalg.norm(normals, axis=1)
        some = double_area > 0.0
        self.triangles: Floats = triangles[some]
        self.normals: Floats = normals[some] / double_area[some, None]
        self._centres: Floats = self.triangles.mean(axis=1)
        self._radii = np.linalg.norm(self.triangles - self._centres[:, None], axis=2).max(axis=1)

    def along(self, axes: Floats, point: Floats, radius: float) -> tuple[Floats, Ints]:
        """Return the triangles that may meet a round bar about the third axis, (k, 3, 3) [m], and which.

        Their corners are relative to a point on the bar's axis, (3,) [m], in the frame of the axes.
        """
        off = (self._centres - point) @ axes[:, :2]
        near = np.flatnonzero((off * off).sum(axis=1) <= (self._radii + radius) ** 2)
        return (self.triangles[near] - point) @ axes, near


def _guesses(
    solid: _Solid, centre: Floats, reach: float, widest: float
) -> list[list[tuple[tuple[bool, float, float], Pads]]]:
    """Return places of pads for each side, of which contact is not sure, each with its cost."""
    corners = outermost(solid.triangles.reshape(-1, 3))
    found: list[list[tuple[tuple[bool, float, float], Pads]]] = [[] for _ in SIDES]
    for line in _opposite(solid, widest):
        off = centre - line.middle
        around = _around(line.closing)
        aligned, farthest = around @ DIRECTIONS.T, (corners @ around.T).max(axis=0)
        for start in (line.middle + off - (off @ line.closing) * line.closing, line.middle):
            over = np.maximum(farthest - around @ start - reach, 0.0)
            middles = start + over[:, None] * around
            # To a millimetre, since below that a flat contact is worth more.
            levers = np.linalg.norm(centre - middles, axis=1).round(3)
            for outward, middle, lever, cosines in zip(around, middles, levers, aligned, strict=True):
                side = int(np.argmax(cosines))
                cosine = float(cosines[side])
                cost = cosine <= ALIGNED, float(lever), -line.flatness * cosine
                found[side].append((cost, Pads(middle, line.width, line.closing, outward)))
    return found


@dataclass(frozen=True, eq=False)
class _Line:
    """A line between two points whose outward normals are almost opposite.

    Attributes:
        flatness: Cosine of the angle between these and the line.
    """

    middle: Floats
    width: float
    closing: Floats
    flatness: float


def _opposite(solid: _Solid, widest: float) -> Iterator[_Line]:
    for point, face in zip(*_samples(solid.triangles), strict=True):
        inward = -solid.normals[face]
        bar, near = solid.along(_axes(inward), point, OFF_EDGES[1])
        heights, faces = _spans(bar, np.zeros(2))
        if not len(heights):
            continue
        here = int(np.argmin(np.abs(heights[:, 0])))
        for height, other in zip(heights[here:, 1].tolist(), near[faces[here:, 1]].tolist(), strict=True):
            between = solid.normals[other] + inward
            closing = between / max(float(np.linalg.norm(between)), 1e-12)
            flatness = float(closing @ inward)
            if height <= widest and flatness >= np.cos(SLANT):
                yield _Line(point + 0.5 * height * inward, height, closing, flatness)


def _samples(triangles: Floats) -> tuple[Floats, Ints]:
    """Return points spread evenly over triangles, (k, 3) [m], and the triangle of each, (k,).

    Within the triangles by the additive recurrence of the plastic number (Roberts, "The unreasonable
    effectiveness of quasirandom sequences", 2018).
    """
    edges = triangles[:, 1:] - triangles[:, :1]
    area = np.cumsum(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1))
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    face = np.asarray(np.searchsorted(area[:-1], share * float(area[-1])), dtype=np.int64)
    weights = (0.5 + np.arange(SAMPLES)[:, None] * (0.7548776662466927, 0.5698402909980532)) % 1.0
    weights = np.where(weights.sum(axis=1, keepdims=True) > 1.0, 1.0 - weights, weights)
    return triangles[face, 0] + np.einsum("ke,kej->kj", weights, edges[face]), face


def _axes(closing: Floats) -> Floats:
    """Return orthogonal unit vectors as columns: the third is `closing`, the first near z or x."""
    upward: Floats = np.eye(3)[2 if abs(closing[2]) < 0.9 else 0]
    first = upward - (upward @ closing) * closing
    first = first / float(np.linalg.norm(first))
    return np.asarray(np.stack((first, np.cross(closing, first), closing), axis=1), dtype=np.float64)


def _around(closing: Floats) -> Floats:
    """Return directions at right angles to one, shape (AROUND, 3)."""
    first, second = _axes(closing).T[:2]
    angles = 2.0 * np.pi * np.arange(AROUND)[:, None] / AROUND
    return np.cos(angles) * first + np.sin(angles) * second


def _spans(bar: Floats, offset: Floats) -> tuple[Floats, Ints]:
    """Return where a line along the third axis is in the solid.

    Args:
        bar: Triangles that it may meet, shape (k, 3, 3) [m].
        offset: Of the line along the first two axes, shape (2,) [m].

    Returns:
        Of each span in ascending order: begin and end, (s, 2) [m]; the triangles there, (s, 2). None if the
        line meets an edge.
    """
    met, heights, areas = crossings(bar, (offset + OFF_EDGES)[None])
    order = np.argsort(heights)
    depth = np.cumsum(-np.sign(areas[order]))  # it leaves where a normal points along it
    ends = np.flatnonzero(depth == 0.0) if depth[-1:].sum() == 0.0 else np.empty(0, dtype=np.int64)
    pairs = order[np.stack((np.concatenate(([0], ends + 1))[: len(ends)], ends), axis=1)]
    return heights[pairs], met[pairs]


def _fitted(solid: _Solid, guess: Pads) -> Pads | None:
    """Return the pads in contact near a guess; None if the surface under one is slanted or uneven."""
    bar, near = solid.along(_axes(guess.closing), guess.middle, PATCH)
    heights, faces = _spans(bar, np.zeros(2))
    if not len(heights):
        return None
    first, last = np.abs(heights + 0.5 * guess.width * np.array((1.0, -1.0))).argmin(axis=0).tolist()
    slopes = (solid.normals[near[[faces[first, 0], faces[last, 1]]]] @ guess.closing) * (-1.0, 1.0)
    if first > last or slopes.min() < np.cos(SLANT):
        return None
    begin, end = float(heights[first, 0]), float(heights[last, 1])
    # Flat triangles are highest below the rim of a pad, or at a corner.
    corners = bar[(bar[:, :, :2] ** 2).sum(axis=2) < PATCH**2][:, 2]
    below = [corners[(corners > begin - PATCH) & (corners < end + PATCH)]]
    for offset in RIM:
        heights, _ = _spans(bar, offset)
        below.append(heights[(heights[:, 0] < end + PATCH) & (heights[:, 1] > begin - PATCH)].ravel())
    met = np.concatenate((*below, (begin, end)))
    low, high = float(met.min()), float(met.max())
    if low < begin - UNEVEN or high > end + UNEVEN:
        return None
    return replace(guess, middle=guess.middle + 0.5 * (low + high) * guess.closing, width=high - low)
