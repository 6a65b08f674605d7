"""Classes that robot, scene and request files may contain, and their invariants."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, cast

import numpy as np

from trajopt.problem.requirements.joints import JointPositions
from trajopt.robot.bodies import CollisionBody
from trajopt.robot.joints import JointLimits
from trajopt.robot.loading.urdf import MeshReference
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, floats
from trajopt.values.documents.codec import Kinds, kinds_in
from trajopt.values.errors import ModelError, ShapeError, shown
from trajopt.values.placement import Placement, as_placement
from trajopt.values.shapes.clouds import Points, Voxels
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Convex
from trajopt.values.trajectory import Path


@cache
def model_kinds() -> Kinds:
    """Return the classes by name."""
    return kinds_in(
        {
            "trajopt.values.shapes.shapes": "Box Sphere Cylinder Capsule Cone Plane Convex",
            "trajopt.values.shapes.mesh": "Mesh",
            "trajopt.values.shapes.clouds": "Points Voxels",
            "trajopt.values.placement": "Placement",
            "trajopt.robot.robot": "Robot FrameAttachment",
            "trajopt.robot.joints": "JointLimits LimitKind",
            "trajopt.robot.bases": "RobotBase Drive",
            "trajopt.robot.bodies": "CollisionBody",
            "trajopt.scene.clearances": "AllowedCollisions ContactAllowance Clearances PairKind",
            "trajopt.robot.loading.urdf": "LinkGeometry MeshReference Mimic",
            "trajopt.robot.loading.srdf": "EndEffector",
            "trajopt.robot.loading.groups": "Group",
            "trajopt.scene.model_error": "ModelUncertainty",
            "trajopt.scene.scene": "Scene",
            "trajopt.scene.scene_object": "SceneObject",
            "trajopt.scene.track": "Timing Track Prediction",
            "trajopt.problem.tool_speed": "ToolSpeed",
            "trajopt.values.trajectory": "Path Trajectory",
            "trajopt.values.curve": "Piece Places Curve",
            "trajopt.problem.requirements": (
                "AxisAlignment CoupledJoints DistanceBetween During FollowsCurve FramePlacement Gaze GoalSet "
                "GravityTorque JointPositions LineOfSight PointOnArc PositionInRegion RotationCoordinates "
                "SingularityDistance"
            ),
        }
    )


MOST_FACES = 200_000
"""Most faces of a convex shape or mesh; a hull has a few thousand."""


def check_value(value: object) -> None:
    """Check a value whose indices or names would otherwise be used out of bounds."""
    check = _CHECKS.get(type(value))
    if check is not None:
        check(value)


def check_fields(kind: type[object], given: Mapping[str, Any]) -> None:
    """Check fields whose constructor would take too long."""
    if kind in (Mesh, Convex) and len(np.atleast_1d(given["faces"])) > MOST_FACES:
        raise ShapeError("faces", f"must be 1 to {MOST_FACES}, are {len(given['faces'])}")


def _placement(value: Placement) -> None:
    as_placement("placement", value)


def _faces(value: Convex | Mesh) -> None:
    vertices = floats("vertices", value.vertices, (None, 3))
    faces = np.asarray(value.faces)
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind != "i":
        raise ShapeError("faces", f"must be whole numbers, shape (m, 3), have {faces.shape}")
    if not 1 <= len(faces) <= MOST_FACES:
        raise ShapeError("faces", f"must be 1 to {MOST_FACES}, are {len(faces)}")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise ShapeError("faces", "refer to vertices that do not exist")


def _cloud(value: Points | Voxels) -> None:
    value.__post_init__()


def _limits(value: JointLimits) -> None:
    count = (len(value.joint_names),)
    for name in ("lower", "upper", "velocity", "acceleration", "jerk", "effort"):
        given = np.asarray(getattr(value, name))
        if given.shape != count or given.dtype != np.float64 or np.isnan(cast("Floats", given)).any():
            raise ShapeError(f"limits {name}", f"must be numbers, shape {count}")


def _body(value: CollisionBody) -> None:
    floats("centre", value.centre, (3,))


def _mesh(value: MeshReference) -> None:
    floats("scale", value.scale, (3,))


def _path(value: Path) -> None:
    floats("knots", value.knots, (None, len(value.joint_names)))


def _joints(value: JointPositions) -> None:
    if not value.positions.keys() == value.below.keys() == value.above.keys():
        raise ModelError("tolerances and positions name different joints")


def _robot(value: Robot) -> None:
    names = tuple(value.model.names[1:])
    if names != tuple(value.joint_names) or names != tuple(value.limits.joint_names):
        raise ModelError("joints, limits and model of the robot do not have the same names")
    homeless = {body.frame for body in value.bodies} - set(value.links)
    if homeless:
        raise ModelError(f"bodies of the robot refer to unknown links: {sorted(homeless)}")
    unknown = {name for group in value.groups.values() for name in group.joints} - set(names)
    if unknown:
        raise ModelError(f"the groups of the robot contain unknown joints: {sorted(unknown)}")


def _scene(value: Scene) -> None:
    for name, item in value.objects.items():
        if item.name != name:
            raise ModelError(f"object {shown(name)} of the scene is named {shown(item.name)}")


_CHECKS: Mapping[type[object], Callable[[Any], None]] = {
    Placement: _placement,
    Convex: _faces,
    Mesh: _faces,
    Points: _cloud,
    Voxels: _cloud,
    JointLimits: _limits,
    CollisionBody: _body,
    MeshReference: _mesh,
    Path: _path,
    JointPositions: _joints,
    Robot: _robot,
    Scene: _scene,
}
