"""MoveIt's services and actions as worker operations from messages to messages."""

from collections.abc import Mapping

from trajopt.ros.rosbridge.answers.execution import execute_trajectory, follow_joint_trajectory
from trajopt.ros.rosbridge.answers.planning import compute_cartesian_path, plan_kinematic_path
from trajopt.ros.rosbridge.answers.states import (
    apply_planning_scene,
    check_state_validity,
    compute_fk,
    compute_ik,
    edit_attached_object,
    edit_collision_object,
    get_planning_scene,
    point_cloud,
)
from trajopt.server.operation import Lane, Operation

OPERATIONS: Mapping[str, Operation] = {
    "moveit/compute_fk": Operation(compute_fk, Lane.QUICK),
    "moveit/compute_ik": Operation(compute_ik),
    "moveit/plan_kinematic_path": Operation(plan_kinematic_path),
    "moveit/compute_cartesian_path": Operation(compute_cartesian_path),
    "moveit/check_state_validity": Operation(check_state_validity, Lane.QUICK),
    "moveit/get_planning_scene": Operation(get_planning_scene, Lane.QUICK),
    "moveit/apply_planning_scene": Operation(apply_planning_scene, Lane.QUICK, edits=True),
    "moveit/collision_object": Operation(edit_collision_object, Lane.QUICK, edits=True),
    "moveit/attached_collision_object": Operation(edit_attached_object, Lane.QUICK, edits=True),
    "moveit/point_cloud": Operation(point_cloud, Lane.QUICK, edits=True),
    "moveit/execute_trajectory": Operation(execute_trajectory, Lane.DRIVING),
    "moveit/follow_joint_trajectory": Operation(follow_joint_trajectory, Lane.DRIVING),
}
