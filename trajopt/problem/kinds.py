"""Classes of values in robot, scene and request files, by their names in the files."""

from functools import cache

from trajopt.values.documents.codec import Kinds, kinds_in


@cache
def model_kinds() -> Kinds:
    """Return the classes by name."""
    return kinds_in(
        {
            "trajopt.values.shapes.shapes": "Box Sphere Cylinder Capsule Cone Plane Convex",
            "trajopt.values.shapes.mesh": "Mesh",
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
            "trajopt.problem.requirements": (
                "AxisAlignment CoupledJoints DistanceBetween During FollowsCurve FramePlacement Gaze GoalSet "
                "GravityTorque JointPositions LineOfSight PointOnArc PositionInRegion RotationCoordinates "
                "SingularityDistance"
            ),
        }
    )
