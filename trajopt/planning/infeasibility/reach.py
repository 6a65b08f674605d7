"""A proof that a point is out of reach: it is farther away than the arm is long."""

import numpy as np

from trajopt.planning.infeasibility.chain import Chain
from trajopt.problem.requirements import FramePlacement, PointOnArc, PositionInRegion, Requirement
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.likely_units import meant_at_distance
from trajopt.values.placement import Placement
from trajopt.values.printed import in_length
from trajopt.values.shapes.shapes import Plane, bounding_sphere

ACCURACY = 1e-6
"""A smaller distance beyond reach proves nothing [m]."""


def out_of_reach(required: Requirement, reduced: ReducedModel) -> str:
    """Say by how much what is required is out of reach; empty where that cannot be proven.

    The bound is the sum of the lengths of the chain, so it is generous: what it excludes is out of reach.
    """
    balls = _balls(required)
    if not balls or not isinstance(required, FramePlacement | PositionInRegion | PointOnArc):
        return ""
    reference, where = reduced.attachment(required.reference)
    carrier, place = reduced.attachment(required.frame)
    if reference != 0 or carrier == 0:
        return ""
    chain = Chain(reduced)
    first = chain.joints(carrier)[0]
    origin = reduced.model.jointPlacements[first].translation
    length = chain.longest(first, carrier, place * required.offset)
    missing = min(
        float(np.linalg.norm(where * centre - origin)) - radius - length for centre, radius in balls
    )
    if missing <= ACCURACY:
        return ""
    return (
        f"{required.frame} would have to be at least {length + missing:.3f} m from "
        f"{reduced.model.names[first]}, but the arm is only {length:.3f} m long from there: "
        f"{in_length(missing)} too short{meant_at_distance(length + missing, length)}"
    )


def _balls(required: Requirement) -> tuple[tuple[Floats, float], ...]:
    """Return balls in the reference that hold all places where the point may be; none if unbounded."""
    if isinstance(required, FramePlacement):
        radius = float(np.linalg.norm(required.position_tolerance))
        return ((required.placement.translation, radius),) if np.isfinite(radius) else ()
    if isinstance(required, PointOnArc):
        return ((required.centre.translation, required.radius + required.tolerance),)
    if isinstance(required, PositionInRegion):
        if any(isinstance(shape, Plane) for shape, _ in required.members):
            return ()
        spheres = [(bounding_sphere(shape), where) for shape, where in required.members]
        return tuple((_moved(where, centre), radius) for (centre, radius), where in spheres)
    return ()


def _moved(where: Placement, point: Floats) -> Floats:
    return where * point
