"""The query in C++: the core `trajopt.native.proximity` on the model and geometries that Python made."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.closed_surface import part_points
from trajopt.model.derived import once_each
from trajopt.model.reduced import ReducedModel
from trajopt.model.shapes import Shape
from trajopt.native import proximity
from trajopt.query.boxes import BoundingBoxes
from trajopt.query.contacts import Contacts
from trajopt.query.distance import EPA_TOLERANCES, GJK_TOLERANCE
from trajopt.query.enclosure import closed_triangles
from trajopt.query.geometry import collision_geometry
from trajopt.query.kinematics import Counts, Kinematics
from trajopt.query.query import Query


class CompiledQuery(Query):
    """Remembers what it measured: configurations near the last ones cost little."""

    def __init__(self, reduced: ReducedModel, counts: Counts | None = None) -> None:
        """Hand the model and the geometries over; once for a reduced model."""
        super().__init__(reduced, counts)
        self._core = proximity.Query(reduced.derived(_cell))

    def kinematics(self, positions: Floats) -> Kinematics:
        """Place all joints at configurations of shape (S, n); see `Query.kinematics`."""
        self.counts.forward_kinematics += len(positions)
        return Kinematics(*self._core.placements(np.ascontiguousarray(positions)))

    def near(self, positions: Floats, reach: Floats) -> Contacts:
        """Measure every pair that is nearer than its reach; see `Query.near`."""
        core, counts = self._core, self.counts
        bounds, distances = core.bounds, core.distances
        found = Contacts(*core.near(np.ascontiguousarray(positions), reach))
        counts.forward_kinematics += len(positions)
        counts.bounds += core.bounds - bounds
        counts.distances += core.distances - distances
        return found

    def displacement(self, start: Floats, end: Floats) -> Floats:
        """Bound the motion between configurations; see `Query.displacement`."""
        self.counts.forward_kinematics += 2 * len(start)
        return self._core.displacement(np.ascontiguousarray(start), np.ascontiguousarray(end))


def _cell(reduced: ReducedModel) -> proximity.Cell:
    boxes = BoundingBoxes.of(reduced)
    return proximity.Cell(
        model=reduced.model,
        expand=np.ascontiguousarray(reduced.mimic_matrix),
        offset=reduced.mimic_offset,
        geometries=[collision_geometry(body.shape) for body in reduced.bodies],
        solids=[_solid(body.shape) for body in reduced.bodies],
        joint=boxes.joint,
        rotation=boxes.rotation,
        translation=boxes.translation,
        centre=boxes.centre,
        half=boxes.half,
        first=reduced.pairs.first,
        second=reduced.pairs.second,
        accuracy=(GJK_TOLERANCE, *EPA_TOLERANCES),
    )


@once_each
def _solid(shape: Shape) -> proximity.Solid:
    return proximity.Solid(
        np.ascontiguousarray(part_points(shape)), np.ascontiguousarray(closed_triangles(shape))
    )
