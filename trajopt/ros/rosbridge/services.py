"""MoveIt's services and actions for clients made for ROS: their operations and types."""

from collections.abc import Mapping
from dataclasses import dataclass

from trajopt.files.messages import plain_name

EDITS: Mapping[str, tuple[str, str]] = {
    "/planning_scene": ("moveit_msgs/PlanningScene", "moveit/apply_planning_scene"),
    "/collision_object": ("moveit_msgs/CollisionObject", "moveit/collision_object"),
    "/attached_collision_object": ("moveit_msgs/AttachedCollisionObject", "moveit/attached_collision_object"),
}
"""Topics that change the scene: type and worker operation of each."""
CLOUD = ("sensor_msgs/PointCloud2", "moveit/point_cloud")
"""Type and worker operation of a camera's topic."""


@dataclass(frozen=True)
class MoveItService:
    """A service of MoveIt.

    Attributes:
        kind: Its type in ROS 1; its messages add the suffixes Request and Response.
        operation: The worker's operation.
    """

    kind: str
    operation: str


SERVICES: Mapping[str, MoveItService] = {
    f"/{name}": MoveItService(f"moveit_msgs/{kind}", f"moveit/{name}")
    for name, kind in {
        "compute_fk": "GetPositionFK",
        "compute_ik": "GetPositionIK",
        "plan_kinematic_path": "GetMotionPlan",
        "compute_cartesian_path": "GetCartesianPath",
        "check_state_validity": "GetStateValidity",
        "get_planning_scene": "GetPlanningScene",
        "apply_planning_scene": "ApplyPlanningScene",
    }.items()
}
"""MoveIt's services by name."""


@dataclass(frozen=True)
class ActionServer:
    """A served action.

    Attributes:
        kind: Its type in ROS 1; its messages add the suffixes Goal, Result and Feedback.
        operation: Operation that drives the robot; empty if it is planned first.
    """

    kind: str
    operation: str


_EXECUTE = ActionServer("moveit_msgs/ExecuteTrajectory", "moveit/execute_trajectory")
_FOLLOW = ActionServer("control_msgs/FollowJointTrajectory", "moveit/follow_joint_trajectory")
_MOVE = ActionServer("moveit_msgs/MoveGroup", "")
ACTIONS: Mapping[str, ActionServer] = {
    "/execute_trajectory": _EXECUTE,
    "/move_action": _MOVE,
    "/move_group": _MOVE,
    "/joint_trajectory_action": _FOLLOW,
    "/follow_joint_trajectory": _FOLLOW,
}
"""The actions by name; `/move_group` is ROS 1's name of `/move_action`."""


def same_type(named: str | None, kind: str) -> bool:
    """Return whether a client's type matches; ROS 1 adds Action to an action's type."""
    return not named or plain_name(named).removesuffix("Action") == kind
