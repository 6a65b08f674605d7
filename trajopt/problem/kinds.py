"""Kinds of values that files hold of robots, scenes and requests, by the names that the files use."""

from functools import cache

from trajopt.values.documents.values import Kinds, kinds_in


@cache
def model_kinds() -> Kinds:
    """Return the classes by name."""
    return kinds_in(
        {
            "trajopt.values.shapes.shapes": "Box Sphere Cylinder Capsule Cone Plane Convex",
            "trajopt.values.shapes.mesh_file": "Mesh",
            "trajopt.values.shapes.clouds.points": "Points",
            "trajopt.values.shapes.clouds.voxels": "Voxels",
            "trajopt.values.placement": "Placement",
            "trajopt.robot.robot": "Robot FrameAttachment",
            "trajopt.robot.limits": "JointLimits LimitKind",
            "trajopt.robot.bases": "RobotBase Drive",
            "trajopt.robot.bodies": "CollisionBody",
            "trajopt.scene.clearances": "AllowedCollisions ContactAllowance Clearances PairKind",
            "trajopt.robot.loading.urdf": "LinkGeometry MeshReference Mimic",
            "trajopt.robot.loading.srdf": "EndEffector",
            "trajopt.robot.loading.groups": "Group",
            "trajopt.scene.scene": "Scene",
            "trajopt.scene.scene_object": "SceneObject",
            "trajopt.scene.timing": "Timing",
            "trajopt.scene.track": "Track Prediction",
            "trajopt.problem.tool_speed": "ToolSpeed",
            "trajopt.values.trajectory": "Path Trajectory",
            "trajopt.values.curve": "Piece Places Curve",
            "trajopt.problem.requirements.axis_alignment": "AxisAlignment",
            "trajopt.problem.requirements.coupled_joints": "CoupledJoints",
            "trajopt.problem.requirements.distance_between": "DistanceBetween",
            "trajopt.problem.requirements.during": "During",
            "trajopt.problem.requirements.follows_curve": "FollowsCurve",
            "trajopt.problem.requirements.frame_placement": "FramePlacement RotationCoordinates",
            "trajopt.problem.requirements.gaze": "Gaze",
            "trajopt.problem.requirements.goal_set": "GoalSet",
            "trajopt.problem.requirements.gravity_torque": "GravityTorque",
            "trajopt.problem.requirements.joint_positions": "JointPositions",
            "trajopt.problem.requirements.line_of_sight": "LineOfSight",
            "trajopt.problem.requirements.point_on_arc": "PointOnArc",
            "trajopt.problem.requirements.position_in_region": "PositionInRegion",
            "trajopt.problem.requirements.singularity_distance": "SingularityDistance",
        }
    )
