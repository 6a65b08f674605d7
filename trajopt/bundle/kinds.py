"""Kinds of values that a bundle holds, by the names that its files use.

A name stays what it is when the class is moved or renamed: then the new place is written here beside the old
name. A kind that is not here is not in any bundle; nothing else is ever made of what a file says.
"""

from collections.abc import Mapping
from enum import Enum
from functools import cache
from importlib import import_module
from typing import Any

_PLACES: Mapping[str, str] = {
    "trajopt.model.shapes": "Box Sphere Cylinder Capsule Cone Plane Convex",
    "trajopt.model.meshes.mesh_file": "Mesh",
    "trajopt.model.placement": "Placement",
    "trajopt.model.robot": "Robot",
    "trajopt.model.limits": "JointLimits LimitKind",
    "trajopt.model.bases": "RobotBase Drive",
    "trajopt.model.frame_attachment": "FrameAttachment",
    "trajopt.model.collisions.bodies": "CollisionBody",
    "trajopt.model.collisions.allowed_collisions": "AllowedCollisions ContactAllowance",
    "trajopt.model.collisions.clearances": "Clearances PairKind",
    "trajopt.model.description.urdf": "LinkGeometry MeshReference Mimic",
    "trajopt.model.description.srdf": "EndEffector",
    "trajopt.model.description.groups": "Group",
    "trajopt.model.scene": "Scene",
    "trajopt.model.scene_object": "SceneObject",
    "trajopt.model.timing": "Timing",
    "trajopt.model.track": "Track Prediction",
    "trajopt.model.tool_speed": "ToolSpeed",
    "trajopt.model.trajectory": "Path Trajectory",
    "trajopt.model.curve": "Piece Places Curve",
    "trajopt.model.requirements.axis_alignment": "AxisAlignment",
    "trajopt.model.requirements.coupled_joints": "CoupledJoints",
    "trajopt.model.requirements.distance_between": "DistanceBetween",
    "trajopt.model.requirements.during": "During",
    "trajopt.model.requirements.follows_curve": "FollowsCurve",
    "trajopt.model.requirements.frame_placement": "FramePlacement RotationCoordinates",
    "trajopt.model.requirements.gaze": "Gaze",
    "trajopt.model.requirements.goal_set": "GoalSet",
    "trajopt.model.requirements.gravity_torque": "GravityTorque",
    "trajopt.model.requirements.joint_positions": "JointPositions",
    "trajopt.model.requirements.line_of_sight": "LineOfSight",
    "trajopt.model.requirements.point_on_arc": "PointOnArc",
    "trajopt.model.requirements.position_in_region": "PositionInRegion",
    "trajopt.model.requirements.singularity_distance": "SingularityDistance",
    "trajopt.nlp": "Loss",
    "trajopt.terms.residual": "Cost Constraint Window",
    "trajopt.terms.smoothness": "Velocity Acceleration Jerk",
    "trajopt.terms.rest_posture": "RestPosture",
    "trajopt.terms.singularity_distance": "LostManipulability",
    "trajopt.problem": "Problem",
    "trajopt.planning.budget": "Budget",
}


@cache
def kind_places() -> Mapping[str, str]:
    """Return the module of each kind by its name."""
    return {name: module for module, names in _PLACES.items() for name in names.split()}


@cache
def kind_named(name: str) -> type[Any] | None:
    """Return the class of a kind; None where there is none of that name."""
    module = kind_places().get(name)
    return None if module is None else getattr(import_module(module), name)


def name_of(kind: type[object]) -> str | None:
    """Return the name of the kind that a class is; None where it is none."""
    name = kind.__name__
    return name if kind_named(name) is kind else None


def is_enum(kind: type[object]) -> bool:
    """Say whether a kind is one of a few named values."""
    return issubclass(kind, Enum)
