"""Query: the native evaluator of placements, Jacobians, distances and bounds of motion."""

from collections.abc import Callable
from dataclasses import dataclass

import coal
import numpy as np

from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.geometry.evaluation import Contacts, Evaluator, JointPlacements, WorkCounts
from trajopt.geometry.geometry import BoundingBoxes, closed_triangles, collision_geometry
from trajopt.native import proximity
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Value
from trajopt.values.cached import cached_per_value
from trajopt.values.shapes.clouds import Points, Voxels, centres_of
from trajopt.values.shapes.shapes import Shape
from trajopt.values.shapes.surfaces import part_points

GJK_TOLERANCE = 1e-9
"""Coal's default of 1e-6 costs the same time and makes normals wrong by up to 1e-3."""
EPA_TOLERANCES = (1e-6, 1e-4)
"""For penetration, tried in turn: on curved shapes Coal's expanding polytope fails at tight ones and
reports the largest float as depth."""


class Query:
    """The native `Evaluator`; owns scratch memory, so one per thread.

    The loops are C++ (`trajopt.native.proximity`), on the model and geometries that Python made. A query
    caches its measurements, so configurations near the last ones cost little.
    """

    def __init__(
        self, reduced: ReducedModel, counts: WorkCounts | None = None, core: proximity.Query | None = None
    ) -> None:
        self.reduced = reduced
        self.counts = WorkCounts() if counts is None else counts
        self._core = proximity.Query(cell(reduced)) if core is None else core
        self._dynamics: DynamicsQuery | None = None

    @property
    def core(self) -> proximity.Query:
        """Distance evaluator for other cores; it shares this query's cache, and counts nothing here."""
        return self._core

    @property
    def dynamics(self) -> DynamicsQuery:
        if self._dynamics is None:
            self._dynamics = DynamicsQuery.loaded(self.reduced)
        return self._dynamics

    def kinematics(self, positions: Floats) -> JointPlacements:
        self.counts.forward_kinematics += len(positions)
        return JointPlacements(*self._core.placements(np.ascontiguousarray(positions)))

    def close_pairs(self, positions: Floats, reach: Floats, aim: Floats | None = None) -> Contacts:
        """Measure pairs within reach, (p,) [m]; up to six contacts of a cloud, with the nearest."""
        core, counts = self._core, self.counts
        bounds, distances = core.bounds, core.distances
        contacts = Contacts(
            *core.close_pairs(np.ascontiguousarray(positions), reach, reach if aim is None else aim)
        )
        counts.forward_kinematics += len(positions)
        counts.bounds += core.bounds - bounds
        counts.distances += core.distances - distances
        return contacts

    def forget(self) -> None:
        """Forget earlier measurements, so that later ones with an aim do not depend on them."""
        self._core.forget()

    def displacement(self, start: Floats, end: Floats) -> Floats:
        """Bound how far any point of any body is displaced from start to end, shape (S,) [m].

        The bound |dc| + |dR|_F / sqrt(2) r holds for the chord between the two placements: c is the body's
        centre, r the radius of its bounding sphere.
        """
        self.counts.forward_kinematics += 2 * len(start)
        return self._core.displacement(np.ascontiguousarray(start), np.ascontiguousarray(end))


def evaluator(
    reduced: ReducedModel, counts: WorkCounts | None = None, /, *, core: proximity.Query | None = None
) -> Evaluator:
    """Return the native evaluator of a reduced model, for one thread.

    Args:
        counts: Adds up the work; new counts when None.
        core: The core, if other shapes replace the model's; a new one when None.
    """
    return Query(reduced, counts, core)


def cell(reduced: ReducedModel) -> proximity.Cell:
    return reduced.derived(_cell)


def _cell(reduced: ReducedModel) -> proximity.Cell:
    return cell_of(reduced, BodyParts.of(reduced), reduced.pairs.first, reduced.pairs.second)


@dataclass(frozen=True, eq=False)
class BodyParts:
    """The bodies of a cell."""

    geometries: list[coal.CollisionGeometry]
    solids: list[proximity.Solid]
    boxes: BoundingBoxes

    @staticmethod
    def of(reduced: ReducedModel) -> "BodyParts":
        shapes = [body.shape for body in reduced.bodies]
        geometries = [collision_geometry(shape) for shape in shapes]
        return BodyParts(geometries, [solid_of(shape) for shape in shapes], BoundingBoxes.of(reduced))


def cell_of(reduced: ReducedModel, bodies: BodyParts, first: Ints, second: Ints) -> proximity.Cell:
    """Return a robot among bodies as the core needs it.

    Args:
        first: Of each pair the first body, shape (p,).
        second: The second, shape (p,).
    """
    boxes = bodies.boxes
    return proximity.Cell(
        model=reduced.model,
        expand=np.ascontiguousarray(reduced.mimic_matrix),
        offset=reduced.mimic_offset,
        geometries=bodies.geometries,
        solids=bodies.solids,
        joint=boxes.joint,
        rotation=boxes.rotation,
        translation=boxes.translation,
        centre=boxes.centre,
        half=boxes.half,
        first=first,
        second=second,
        accuracy=(GJK_TOLERANCE, *EPA_TOLERANCES),
    )


@cached_per_value
def solid_of(shape: Shape) -> proximity.Solid:
    return proximity.Solid(
        np.ascontiguousarray(part_points(shape)),
        np.ascontiguousarray(closed_triangles(shape)),
        collision_geometry(shape),
        _cloud(shape),
    )


def _cloud(shape: Shape) -> Floats:
    if isinstance(shape, Points | Voxels):
        return np.ascontiguousarray(centres_of(shape))
    return np.empty((0, 3))


@dataclass(frozen=True, eq=False)
class SearchedPath(Value):
    """Outcome of a path search.

    Attributes:
        corners: Of a path of straight lines, both ends included, shape (k, n); None if none was found.
        exhausted: Whether none was found, and the second half of the search entered nothing new: a longer
            search would hardly find one.
    """

    corners: Floats | None
    exhausted: bool = False


@dataclass(frozen=True, eq=False)
class SearchSpace(Value):
    """Space of a path search.

    Attributes:
        lower: Of the joints searched, shape (n,) [rad | m].
        upper: Shape (n,).
        unit: Of length in each joint, shape (n,): no branch of the trees is longer than one in all.
        reach: Distance that each pair keeps, shape (p,) [m].
        step: Largest travel of a body between two checked configurations [m].
    """

    lower: Floats
    upper: Floats
    unit: Floats
    reach: Floats
    step: float


def search_path(
    query: Evaluator,
    start: Floats,
    goals: Floats,
    space: SearchSpace,
    *,
    checked: int,
    shortening: int,
    seed: int,
    check: Callable[[], None],
) -> SearchedPath:
    """Search a path of straight lines.

    RRT-Connect, with a shortened path; compiled, with a generator of its own, without the interpreter's lock.
    Sources: Kuffner and LaValle, ICRA 2000; Geraerts and Overmars, IJRR 2007 (shortening).

    Args:
        query: Its counts include the work done.
        start: Shape (n,) [rad | m].
        goals: Possible ends, shape (g, n).
        space: A start or goal outside is added to it.
        checked: Configurations checked before the search gives up.
        shortening: Configurations that shortening may check, in each of its three passes.
        seed: Of the random numbers, at least 0: the same on every platform.
        check: Called every few milliseconds; may raise to stop.
    """
    ends = np.concatenate((start[None], goals))
    counts, before = query.counts, query.counts.forward_kinematics

    def going_on(looked: int) -> None:
        counts.forward_kinematics = before + looked
        check()

    corners, exhausted, looked, bounds, distances = proximity.search_path(
        cell=cell(query.reduced),
        start=np.ascontiguousarray(start),
        goals=np.ascontiguousarray(goals),
        lower=np.minimum(space.lower, ends.min(axis=0)),
        upper=np.maximum(space.upper, ends.max(axis=0)),
        unit=space.unit,
        reach=space.reach,
        step=space.step,
        looks=checked,
        shortening=shortening,
        seed=seed,
        check=going_on,
    )
    counts.forward_kinematics = before + looked
    counts.bounds += bounds
    counts.distances += distances
    if not len(corners):
        return SearchedPath(None, exhausted)
    # They were scaled to units and back.
    corners[0] = start
    corners[-1] = goals[np.argmin(np.abs(goals - corners[-1]).max(axis=1))]
    return SearchedPath(corners)
