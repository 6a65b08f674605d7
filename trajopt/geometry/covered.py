"""Boxes that contain clouds, so that a descent needs no single balls.

A distance from the boxes is a distance from the cloud. A box that is too near the robot at the start or the
goal is cut into smaller ones, and finally replaced by its balls or cubes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import coal
import numpy as np

from trajopt.geometry.evaluation import Evaluator, WorkCounts
from trajopt.geometry.geometry import BoundingBoxes, collision_geometry
from trajopt.geometry.query import BodyParts, cell_of, evaluator, solid_of
from trajopt.native import proximity
from trajopt.robot.joints import FixedBody
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints
from trajopt.values.cached import cached_per_value
from trajopt.values.shapes.clouds import Points, Voxels

CELL = 0.03
"""Cells that a cloud is cut into, at least as large as its balls or cubes [m]."""
MOST = 200
"""Boxes at most: among more a cloud is not looked at any sooner."""
FEWEST = 200
"""Clouds of fewer balls or cubes are left as they are."""
PARTS, CUTS = 4, 3
"""Parts that a box in the way at an end is cut into along its longest axis, and number of cuts: enough to cut
a table top of two metres to cells. Boxes still in the way become single balls or cubes.
"""
MIDDLE, NO_POINTS, NO_TRIANGLES = np.zeros((1, 3)), np.empty((0, 3)), np.empty((0, 3, 3))


@dataclass(frozen=True, eq=False)
class BoxCover:
    """The boxes that contain a cloud.

    Attributes:
        axes: Columns: the boxes' axes in the cloud's frame, shape (3, 3).
        centre: Of each box, in the cloud's frame, shape (k, 3) [m].
        half: Half of its edges, shape (k, 3) [m].
    """

    axes: Floats
    centre: Floats
    half: Floats
    core: proximity.CloudCover
    geometries: list[coal.CollisionGeometry]
    solids: list[proximity.Solid]

    @staticmethod
    def of(cloud: Points | Voxels, core: proximity.CloudCover) -> "BoxCover":
        axes, (low, high) = core.axes(), core.pieces()
        around = cloud.radius if isinstance(cloud, Points) else cloud.size / 2.0 * np.abs(axes).sum(axis=0)
        half = (high - low) / 2.0 + around
        geometries = [_box(2.0 * each) for each in half]
        solids = [proximity.Solid(MIDDLE, NO_TRIANGLES, each, NO_POINTS) for each in geometries]
        return BoxCover(axes, (low + high) / 2.0 @ axes.T, half, core, geometries, solids)

    def cut(self, cloud: Points | Voxels, boxes: Ints, parts: int) -> "BoxCover":
        return BoxCover.of(cloud, self.core.cut(solid_of(cloud), boxes, CELL, parts))


@cached_per_value
def cover_of(cloud: Points | Voxels) -> BoxCover | None:
    """Return the boxes around a cloud; None if it is small already, or so ragged that they would be many."""
    if len(cloud) < FEWEST:
        return None
    edge = 2.0 * cloud.radius if isinstance(cloud, Points) else cloud.size
    core = proximity.CloudCover(solid_of(cloud), max(CELL, edge), MOST)
    return BoxCover.of(cloud, core) if len(core.pieces()[0]) else None


def _box(edges: Floats) -> coal.CollisionGeometry:
    box = coal.Box(*edges.tolist())
    box.computeLocalAABB()
    return box


def covered_query(reduced: ReducedModel, counts: WorkCounts, ends: Floats) -> Evaluator | None:
    """Return a query in which boxes replace clouds; None without a cloud at rest that boxes can replace.

    Its pairs are the model's, and no distance is larger than theirs.

    Args:
        ends: Configurations at which every box keeps the required distance, shape (S, n) [rad | m].
    """
    whole = reduced.derived(_covered)
    if whole is None:
        return None
    for parts in (*(PARTS,) * CUTS, 0):
        blocked = whole.nearer_than_required(reduced, ends)
        if not blocked:
            break
        whole = whole.opened(reduced, blocked, parts)
    return evaluator(reduced, counts, core=whole.core(whole.stands_for, len(reduced.pairs.required)))


def _covered(reduced: ReducedModel) -> "Covered | None":
    covers = {
        number: cover
        for number, body in enumerate(reduced.bodies)
        if isinstance(body.shape, Points | Voxels) and not body.joint
        if (cover := cover_of(body.shape)) is not None
    }
    return Covered.of(reduced, covers, {}) if covers else None


@dataclass(frozen=True, eq=False)
class Covered:
    """A reduced model with boxes in the place of clouds.

    Attributes:
        covers: The covers, by the number of the cloud's body.
        stands_for: Of each pair of the cell the pair of the model, shape (m,).
        first: Its first body, shape (m,).
        second: Its second, shape (m,).
        body: Of each body of the cell the body of the model, shape (b,).
        box: Which box of its cover it is, -1 for none, shape (b,).
    """

    covers: Mapping[int, BoxCover]
    cell: proximity.Cell
    stands_for: Ints
    first: Ints
    second: Ints
    body: Ints
    box: Ints

    @staticmethod
    def of(reduced: ReducedModel, covers: Mapping[int, BoxCover], opened: Mapping[int, Ints]) -> "Covered":
        """Replace clouds by boxes, by the number of the cloud's body; opened boxes by balls or cubes."""
        plain, bodies = BodyParts.of(reduced), reduced.bodies
        parts = [_Part.plain(plain, [n for n in range(len(bodies)) if n not in covers])]
        for number, cover in covers.items():
            chosen = opened.get(number, np.empty(0, dtype=np.int64))
            parts.append(
                _Part.boxes(number, bodies[number], cover, np.setdiff1d(np.arange(len(cover.half)), chosen))
            )
            if len(chosen):
                parts.append(_Part.cloud(number, bodies[number], cover, chosen))
        body = np.concatenate([part.body for part in parts])
        members = [np.flatnonzero(body == number) for number in range(len(bodies))]
        stands_for, first, second = _pairs(reduced.pairs.first, reduced.pairs.second, members)
        cell = cell_of(reduced, _joined(parts), first, second)
        return Covered(
            covers, cell, stands_for, first, second, body, np.concatenate([part.box for part in parts])
        )

    def core(self, stands_for: Ints, count: int) -> proximity.Query:
        return proximity.Query(self.cell, stands_for, count)

    def nearer_than_required(self, reduced: ReducedModel, ends: Floats) -> Mapping[int, Ints]:
        count, required = len(self.first), reduced.pairs.required
        core = self.core(np.arange(count), count)
        reach = required[self.stands_for]
        pairs = core.close_pairs(np.ascontiguousarray(ends), reach, reach)[1]
        found = np.unique(np.concatenate((self.first[pairs], self.second[pairs])))
        found = found[self.box[found] >= 0]
        return {
            int(number): self.box[found[self.body[found] == number]] for number in np.unique(self.body[found])
        }

    def opened(self, reduced: ReducedModel, boxes: Mapping[int, Ints], parts: int) -> "Covered":
        """Return the model with some boxes replaced.

        Args:
            parts: Number of parts to cut them into along their longest axes; 0 for single balls or cubes.
        """
        if not parts:
            return Covered.of(reduced, self.covers, boxes)
        cut = {n: self.covers[n].cut(_cloud(reduced, n), chosen, parts) for n, chosen in boxes.items()}
        return Covered.of(reduced, {**self.covers, **cut}, {})


def _cloud(reduced: ReducedModel, number: int) -> Points | Voxels:
    shape = reduced.bodies[number].shape
    assert isinstance(shape, Points | Voxels)
    return shape


@dataclass(frozen=True, eq=False)
class _Part:
    bodies: BodyParts
    body: Ints
    box: Ints

    @staticmethod
    def plain(plain: BodyParts, numbers: list[int]) -> "_Part":
        boxes = plain.boxes.take(np.array(numbers, dtype=np.int64))
        taken = BodyParts([plain.geometries[n] for n in numbers], [plain.solids[n] for n in numbers], boxes)
        return _Part(taken, np.array(numbers, dtype=np.int64), np.full(len(numbers), -1))

    @staticmethod
    def boxes(number: int, body: FixedBody, cover: BoxCover, chosen: Ints) -> "_Part":
        count = len(chosen)
        rotation = body.placement.rotation @ cover.axes
        centre = cover.centre[chosen] @ body.placement.rotation.T + body.placement.translation
        placed = BoundingBoxes(
            np.zeros(count, dtype=np.int64),
            np.tile(rotation, (count, 1, 1)),
            centre,
            centre,
            cover.half[chosen],
            np.linalg.norm(cover.half[chosen], axis=1),
        )
        taken = BodyParts([cover.geometries[n] for n in chosen], [cover.solids[n] for n in chosen], placed)
        return _Part(taken, np.full(count, number), chosen)

    @staticmethod
    def cloud(number: int, body: FixedBody, cover: BoxCover, chosen: Ints) -> "_Part":
        shape = body.shape
        assert isinstance(shape, Points | Voxels)
        centres = cover.core.points_within(solid_of(shape), chosen)
        size = shape.radius if isinstance(shape, Points) else shape.size / 2.0
        low, high = centres.min(axis=0) - size, centres.max(axis=0) + size
        half, rotation = (high - low) / 2.0, body.placement.rotation
        placed = BoundingBoxes(
            np.zeros(1, dtype=np.int64),
            rotation[None],
            body.placement.translation[None],
            (rotation @ ((low + high) / 2.0) + body.placement.translation)[None],
            half[None],
            np.linalg.norm(half[None], axis=1),
        )
        geometry = collision_geometry(shape)
        solid = proximity.Solid(centres, NO_TRIANGLES, geometry, centres)
        return _Part(BodyParts([geometry], [solid], placed), np.array([number]), np.array([-1]))


def _joined(parts: Sequence[_Part]) -> BodyParts:
    return BodyParts(
        [geometry for part in parts for geometry in part.bodies.geometries],
        [solid for part in parts for solid in part.bodies.solids],
        BoundingBoxes.joined([part.bodies.boxes for part in parts]),
    )


def _pairs(first: Ints, second: Ints, members: Sequence[Ints]) -> tuple[Ints, Ints, Ints]:
    counts = np.array([len(each) for each in members])
    starts, every = np.cumsum(counts) - counts, np.concatenate(members)
    many = counts[first] * counts[second]
    stands_for = np.repeat(np.arange(len(first)), many)
    place = np.arange(len(stands_for)) - (np.cumsum(many) - many)[stands_for]
    one, other = first[stands_for], second[stands_for]
    return (
        stands_for,
        every[starts[one] + place // counts[other]],
        every[starts[other] + place % counts[other]],
    )
