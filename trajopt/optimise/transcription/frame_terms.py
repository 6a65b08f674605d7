"""Terms of frames for the core: the same formulas, evaluated without Python."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trajopt.native import descent
from trajopt.optimise.terms.axis_alignment import AxisAngle
from trajopt.optimise.terms.distance_between import PointDistance
from trajopt.optimise.terms.frame_placement import FramePlacementError
from trajopt.optimise.terms.gaze import ViewAngle, ViewDistance
from trajopt.optimise.terms.position_in_region import RegionCoordinates
from trajopt.problem.requirements import Region, RotationCoordinates
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere


@dataclass(frozen=True, eq=False)
class FrameInCore:
    """A term of a frame, as the core needs it.

    Attributes:
        view: The frame, its point, and the reference that it is seen from.
        term: The formula.
    """

    view: descent.View
    term: descent.FrameTerm


def frame_in_core(residual: object) -> FrameInCore | None:
    """Return a term of a frame in the core's form; None if it is not such a term, or has no formula there."""
    build = _BUILD.get(type(residual))
    return None if build is None else build(residual)


def _axis_angle(residual: AxisAngle) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.frame, need.reference, np.zeros(3))
    return FrameInCore(view, descent.axis_angle(need.axis, need.direction, _across(need.direction)))


def _placement(residual: FramePlacementError) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.frame, need.reference, need.offset)
    euler = need.coordinates is not RotationCoordinates.ROTATION_VECTOR
    rotation = np.ascontiguousarray(need.placement.rotation)
    return FrameInCore(view, descent.frame_placement(rotation, need.placement.translation, euler))


def _distance(residual: PointDistance) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.first, need.second, need.first_offset)
    return FrameInCore(view, descent.point_distance(need.second_offset))


def _view_angle(residual: ViewAngle) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.reference, need.frame, need.target)
    return FrameInCore(view, descent.view_angle(need.origin, need.axis, _across(need.axis)))


def _view_distance(residual: ViewDistance) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.reference, need.frame, need.target)
    return FrameInCore(view, descent.view_distance(need.origin))


def _region(residual: RegionCoordinates) -> FrameInCore:
    need = residual.required
    members = [
        (*_shape(shape), np.ascontiguousarray(where.rotation), where.translation)
        for shape, where in need.members
    ]
    view = _view(residual.reduced, need.frame, need.reference, need.offset)
    return FrameInCore(view, descent.region(members))


_BUILD: Mapping[type, Callable[[Any], FrameInCore]] = {
    AxisAngle: _axis_angle,
    FramePlacementError: _placement,
    PointDistance: _distance,
    ViewAngle: _view_angle,
    ViewDistance: _view_distance,
    RegionCoordinates: _region,
}

FRAME_TERMS = frozenset(_BUILD)
"""Terms that have a formula in the core."""


def _shape(shape: Region) -> tuple[descent.Shape, Floats]:
    """Return a shape and its sizes."""
    match shape:
        case Box():
            return descent.Shape.BOX, np.array((shape.x, shape.y, shape.z)) / 2.0
        case Sphere():
            return descent.Shape.SPHERE, np.full(3, shape.radius)
        case Cylinder():
            return descent.Shape.CYLINDER, np.array((shape.radius, shape.radius, shape.length / 2.0))
        case Plane():
            return descent.Shape.HALF_SPACE, np.zeros(3)


def _view(reduced: ReducedModel, frame: str, reference: str, offset: Floats) -> descent.View:
    joint, held = reduced.attachment(frame)
    base, base_held = reduced.attachment(reference)
    return descent.View(
        joint=joint,
        rotation=np.ascontiguousarray(held.rotation),
        point=held * offset,
        base=base,
        base_rotation=np.ascontiguousarray(base_held.rotation),
        base_origin=base_held.translation,
    )


def _across(axis: Floats) -> Floats:
    """Return the unit vector across an axis that the terms use when no direction is given."""
    return np.ascontiguousarray(np.linalg.svd(axis[None, :])[2][1])
