"""Kinds of values that files hold of robots, scenes and requests, by the names that the files use."""

from functools import cache

from trajopt.io.values import Kinds, kinds_in


@cache
def model_kinds() -> Kinds:
    """Return the classes by name."""
    return kinds_in(
        {
            "trajopt.model.shapes": "Box Sphere Cylinder Capsule Cone Plane Convex",
            "trajopt.model.meshes.mesh_file": "Mesh",
            "trajopt.model.clouds.points": "Points",
            "trajopt.model.clouds.voxels": "Voxels",
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
        }
    )
