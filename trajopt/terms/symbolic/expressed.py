"""Residuals as CasADi expressions of a configuration: the same numbers, derivatives of any order automatic.

What is not listed here is measured (clearance, lines of sight, singular values) or is a user's plain
function; `expressed` returns None for it.
"""

from functools import singledispatch

import casadi as ca
import numpy as np

from trajopt.model.payload import loaded_model
from trajopt.model.requirements import RotationCoordinates
from trajopt.model.rotations import from_rpy
from trajopt.model.shapes import Box, Cylinder, Plane, Sphere
from trajopt.terms.axis_alignment import AxisAngle
from trajopt.terms.coupled_joints import JointSum
from trajopt.terms.distance_between import PointDistance
from trajopt.terms.expression import Expression
from trajopt.terms.frame_placement import FramePlacementError
from trajopt.terms.gaze import ViewAngle, ViewDistance
from trajopt.terms.gravity_torque import GravityShare
from trajopt.terms.joint_positions import JointPosition
from trajopt.terms.point_on_arc import ArcCoordinates
from trajopt.terms.position_in_region import ROWS, RegionCoordinates
from trajopt.terms.residual import Residual
from trajopt.terms.rest_posture import RestPosture
from trajopt.terms.symbolic.kinematics import SymbolicKinematics

SMALL = 1e-16
"""Squared lengths below this count as this, so that a root has a slope everywhere."""
INSIDE = -1.0
"""What coordinates of a member of a union read that is not the nearest one: within every bound [m]."""


@singledispatch
def expressed(residual: Residual, kinematics: SymbolicKinematics) -> ca.SX | None:
    """Return a residual's components at the configuration `kinematics.q`, a column; None if it has none.

    Args:
        residual: The residual.
        kinematics: Of the reduced model that it is of.
    """
    del residual, kinematics
    return None


def _length(vector: ca.SX) -> ca.SX:
    return ca.sqrt(ca.fmax(ca.sumsqr(vector), SMALL))


@expressed.register
def _(residual: Expression, kinematics: SymbolicKinematics) -> ca.SX:
    return ca.SX(residual.build(kinematics))


@expressed.register
def _(residual: JointPosition, kinematics: SymbolicKinematics) -> ca.SX:
    return kinematics.q[residual.joints.tolist()]


@expressed.register
def _(residual: JointSum, kinematics: SymbolicKinematics) -> ca.SX:
    return ca.dot(ca.SX(residual.weights), kinematics.q) + residual.constant


@expressed.register
def _(residual: RestPosture, kinematics: SymbolicKinematics) -> ca.SX:
    names = kinematics.reduced.joint_names
    places = [names.index(joint) for joint in residual.positions]
    return kinematics.q[places] - ca.SX(list(residual.positions.values()))


@expressed.register
def _(residual: AxisAngle, kinematics: SymbolicKinematics) -> ca.SX:
    need = residual.required
    axis = kinematics.rotation(need.frame, need.reference) @ ca.SX(need.axis)
    direction = ca.SX(need.direction)
    return ca.atan2(_length(ca.cross(axis, direction)), ca.dot(axis, direction))


@expressed.register
def _(residual: PointDistance, kinematics: SymbolicKinematics) -> ca.SX:
    need = residual.required
    apart = kinematics.point(need.first, need.first_offset, need.second) - ca.SX(need.second_offset)
    return ca.vertcat(apart, _length(apart))


@expressed.register
def _(residual: FramePlacementError, kinematics: SymbolicKinematics) -> ca.SX:
    need = residual.required
    to_goal = ca.SX(need.placement.rotation.T)
    point = kinematics.point(need.frame, need.offset, need.reference)
    rotation = to_goal @ kinematics.rotation(need.frame, need.reference)
    angles = (
        _rotation_vector(rotation)
        if need.coordinates is RotationCoordinates.ROTATION_VECTOR
        else _xyz_euler(rotation)
    )
    return ca.vertcat(to_goal @ (point - ca.SX(need.placement.translation)), angles)


def _rotation_vector(rotation: ca.SX) -> ca.SX:
    """Return log R = t / sin t (R - R^T) / 2, the angle t by its sine and cosine."""
    axis = 0.5 * ca.vertcat(
        rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]
    )
    sine = _length(axis)
    return axis * (ca.atan2(sine, 0.5 * (ca.trace(rotation) - 1.0)) / sine)


def _xyz_euler(rotation: ca.SX) -> ca.SX:
    """Return angles (a, b, c) of R = Rx(a) Ry(b) Rz(c)."""
    return ca.vertcat(
        ca.atan2(-rotation[1, 2], rotation[2, 2]),
        ca.asin(ca.fmin(ca.fmax(rotation[0, 2], -1.0), 1.0)),
        ca.atan2(-rotation[0, 1], rotation[0, 0]),
    )


@expressed.register
def _(residual: ViewAngle, kinematics: SymbolicKinematics) -> ca.SX:
    need = residual.required
    point = kinematics.point(need.reference, need.target, need.frame) - ca.SX(need.origin)
    ahead = ca.dot(point, ca.SX(need.axis))
    return ca.atan2(_length(point - ca.SX(need.axis) * ahead), ahead)


@expressed.register
def _(residual: ViewDistance, kinematics: SymbolicKinematics) -> ca.SX:
    need = residual.required
    return _length(kinematics.point(need.reference, need.target, need.frame) - ca.SX(need.origin))


@expressed.register
def _(residual: GravityShare, kinematics: SymbolicKinematics) -> ca.SX:
    """The gradient of the potential energy - sum m g . c over the bodies' centres of mass c."""
    model = loaded_model(kinematics.reduced)
    gravity = ca.SX(np.asarray(model.gravity.linear, dtype=np.float64))
    energy = ca.SX(0.0)
    for joint in range(1, model.njoints):
        body = model.inertias[joint]
        centre = kinematics.joint_point(joint, np.asarray(body.lever, dtype=np.float64))
        energy -= float(body.mass) * ca.dot(gravity, centre)
    torque = ca.jacobian(energy, kinematics.q).T
    return torque[residual.joints.tolist()] / ca.SX(kinematics.reduced.limits.effort[residual.joints])


@expressed.register
def _(residual: ArcCoordinates, kinematics: SymbolicKinematics) -> ca.SX:
    need = residual.required
    axes = need.centre.rotation @ from_rpy(0.0, 0.0, need.sweep / 2.0)
    seen = kinematics.point(need.frame, need.offset, need.reference)
    point = ca.SX(axes.T) @ (seen - ca.SX(need.centre.translation))
    off = ca.vertcat(_length(point[:2]) - need.radius, point[2])
    return ca.vertcat(off, _length(off), need.radius * ca.atan2(point[1], point[0]))


@expressed.register
def _(residual: RegionCoordinates, kinematics: SymbolicKinematics) -> ca.SX:
    """Four components a member; those of members that are not the nearest lie within all bounds."""
    need = residual.required
    seen = kinematics.point(need.frame, need.offset, need.reference)
    local = [ca.SX(where.rotation.T) @ (seen - ca.SX(where.translation)) for _, where in need.members]
    columns = [_coordinates(shape, at) for (shape, _), at in zip(need.members, local, strict=True)]
    if len(columns) == 1:
        return columns[0]
    outside = [_outside(shape, at) for (shape, _), at in zip(need.members, local, strict=True)]
    found: list[ca.SX] = []
    for mine, ((shape, _), column) in enumerate(zip(need.members, columns, strict=True)):
        nearest = ca.SX(1.0)
        for other, away in enumerate(outside):
            if other != mine:
                # Of members equally near the first one counts.
                nearest = nearest * (outside[mine] < away if other < mine else outside[mine] <= away)
        rest = INSIDE if isinstance(shape, Plane) else 0.0
        found.append(ca.if_else(nearest, column, rest))
    return ca.vertcat(*found)


def _coordinates(shape: object, point: ca.SX) -> ca.SX:
    match shape:
        case Sphere():
            rows = [point, _length(point)]
        case Cylinder():
            rows = [point[:2], _length(point[:2]), point[2]]
        case Plane():
            rows = [point[2]]
        case _:
            rows = [point]
    column = ca.vertcat(*rows)
    return ca.vertcat(column, ca.SX(np.zeros(ROWS - column.shape[0])))


def _outside(shape: object, point: ca.SX) -> ca.SX:
    """Signed distance from a shape, negative inside."""
    match shape:
        case Box():
            over = ca.fabs(point) - ca.SX(np.array((shape.x, shape.y, shape.z)) / 2.0)
        case Sphere():
            return _length(point) - shape.radius
        case Cylinder():
            over = ca.vertcat(_length(point[:2]) - shape.radius, ca.fabs(point[2]) - shape.length / 2.0)
        case _:
            return point[2]
    return _length(ca.fmax(over, 0.0)) + ca.fmin(ca.mmax(over), 0.0)
