"""The commander keeps MoveIt's contract: every method, its arguments and their defaults."""

import inspect

import pytest
from trajopt.ros.commander.moveit_msgs.msg import MoveItErrorCodes

from trajopt.planning.result import Status
from trajopt.ros.commander import MoveGroupCommander, PlanningSceneInterface, RobotCommander
from trajopt.server.move_group.outcome import CODES

GROUP = """
get_name() stop() get_active_joints() get_joints() get_variable_count()
has_end_effector_link() get_end_effector_link() set_end_effector_link(link_name)
get_interface_description() get_pose_reference_frame() set_pose_reference_frame(reference_frame)
get_planning_frame() get_current_joint_values() get_current_pose(end_effector_link='')
get_current_rpy(end_effector_link='') get_random_joint_values() get_random_pose(end_effector_link='')
set_start_state_to_current_state() set_start_state(msg) get_current_state() get_current_state_bounded()
get_joint_value_target() set_joint_value_target(arg1,arg2=None,arg3=None)
set_rpy_target(rpy,end_effector_link='') set_orientation_target(q,end_effector_link='')
set_position_target(xyz,end_effector_link='') set_pose_target(pose,end_effector_link='')
set_pose_targets(poses,end_effector_link='') shift_pose_target(axis,value,end_effector_link='')
clear_pose_target(end_effector_link) clear_pose_targets() set_random_target() get_named_targets()
set_named_target(name) get_named_target_values(target) remember_joint_values(name,values=None)
get_remembered_joint_values() forget_joint_values(name) get_goal_tolerance() get_goal_joint_tolerance()
get_goal_position_tolerance() get_goal_orientation_tolerance() set_goal_tolerance(value)
set_goal_joint_tolerance(value) set_goal_position_tolerance(value) set_goal_orientation_tolerance(value)
allow_looking(value) allow_replanning(value) get_known_constraints() get_path_constraints()
set_path_constraints(value) clear_path_constraints() get_trajectory_constraints()
set_trajectory_constraints(value) clear_trajectory_constraints() set_constraints_database(host,port)
get_planning_time() set_planning_time(seconds) set_planning_pipeline_id(planning_pipeline)
get_planning_pipeline_id() set_planner_id(planner_id) get_planner_id()
set_num_planning_attempts(num_planning_attempts) set_workspace(ws) set_max_velocity_scaling_factor(value)
set_max_acceleration_scaling_factor(value) limit_max_cartesian_link_speed(speed,link_name='')
clear_max_cartesian_link_speed() go(joints=None,wait=True) plan(joints=None)
construct_motion_plan_request() execute(trajectory,wait=True)
attach_object(object_name,link_name='',touch_links=()) detach_object(name='')
set_support_surface_name(value)
compute_cartesian_path(waypoints,eef_step,avoid_collisions=True,path_constraints=None)
pick(object_name,grasp=(),plan_only=False) place(object_name,location=None,plan_only=False)
retime_trajectory(ref_state_in,traj_in,velocity_scaling_factor=1.0,acceleration_scaling_factor=1.0,algorithm='iterative_time_parameterization')
get_jacobian_matrix(joint_values,reference_point=None) enforce_bounds(robot_state_msg)
"""
"""Of `moveit_commander.MoveGroupCommander` (empty lists as defaults are empty tuples here)."""

SCENE = """
add_object(collision_object) add_sphere(name,pose,radius=1) add_cylinder(name,pose,height,radius)
add_cone(name,pose,height,radius) add_mesh(name,pose,filename,size=(1, 1, 1))
add_box(name,pose,size=(1, 1, 1)) add_plane(name,pose,normal=(0, 0, 1),offset=0)
attach_object(object,link=None,touch_links=None)
attach_mesh(link,name,pose=None,filename='',size=(1, 1, 1),touch_links=None)
attach_box(link,name,pose=None,size=(1, 1, 1),touch_links=None)
attach_sphere(link,name,pose=None,radius=1,touch_links=None)
attach_cylinder(link,name,pose=None,height=1,radius=1,touch_links=None) clear()
remove_world_object(name=None) remove_attached_object(link=None,name=None)
get_known_object_names(with_type=False)
get_known_object_names_in_roi(minx,miny,minz,maxx,maxy,maxz,with_type=False)
get_object_poses(object_ids) get_objects(object_ids=()) get_attached_objects(object_ids=())
get_planning_scene(components) apply_planning_scene(planning_scene_message)
make_box(name,pose,size) make_mesh(name,pose,filename,scale=(1, 1, 1)) make_sphere(name,pose,radius)
make_cylinder(name,pose,height,radius) make_cone(name,pose,height,radius)
make_plane(name,pose,normal=(0, 0, 1),offset=0)
"""

ROBOT = """
get_planning_frame() get_robot_markers(*args) get_root_link() get_active_joint_names(group=None)
get_joint_names(group=None) get_link_names(group=None) get_group_names() get_current_state()
get_current_variable_values() get_joint(name) get_link(name) get_group(name) has_group(name)
get_default_owner_group(joint_name)
"""

CONSTRUCTORS = {
    MoveGroupCommander: "name,robot_description='robot_description',ns='',wait_for_servers=5.0,*,world=None",
    PlanningSceneInterface: "ns='',synchronous=True,*,world=None",
    RobotCommander: "robot_description='robot_description',ns='',*,world=None",
}

CODE_NUMBERS = {
    "SUCCESS": 1, "FAILURE": 99999, "PLANNING_FAILED": -1, "INVALID_MOTION_PLAN": -2,
    "MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE": -3, "CONTROL_FAILED": -4,
    "UNABLE_TO_AQUIRE_SENSOR_DATA": -5, "TIMED_OUT": -6, "PREEMPTED": -7,
    "START_STATE_IN_COLLISION": -10, "START_STATE_VIOLATES_PATH_CONSTRAINTS": -11,
    "GOAL_IN_COLLISION": -12, "GOAL_VIOLATES_PATH_CONSTRAINTS": -13, "GOAL_CONSTRAINTS_VIOLATED": -14,
    "INVALID_GROUP_NAME": -15, "INVALID_GOAL_CONSTRAINTS": -16, "INVALID_ROBOT_STATE": -17,
    "INVALID_LINK_NAME": -18, "INVALID_OBJECT_NAME": -19, "FRAME_TRANSFORM_FAILURE": -21,
    "COLLISION_CHECKING_UNAVAILABLE": -22, "ROBOT_STATE_STALE": -23, "SENSOR_INFO_STALE": -24,
    "COMMUNICATION_FAILURE": -25, "START_STATE_INVALID": -26, "GOAL_STATE_INVALID": -27,
    "UNRECOGNIZED_GOAL_TYPE": -28, "CRASH": -29, "ABORT": -30, "NO_IK_SOLUTION": -31,
}  # fmt: skip


def methods(text: str) -> list[tuple[str, str]]:
    """Split "name(arguments)" at the bracket that closes it: defaults may have brackets of their own."""
    found: list[tuple[str, str]] = []
    rest = " ".join(text.split())
    while rest:
        name, rest = rest.split("(", 1)
        depth, end = 1, 0
        while depth:
            depth += {"(": 1, ")": -1}.get(rest[end], 0)
            end += 1
        found.append((name.strip(), rest[: end - 1]))
        rest = rest[end:].strip()
    return found


def arguments(function: object) -> str:
    signature = inspect.signature(function)
    shown: list[str] = []
    for parameter in signature.parameters.values():
        if parameter.name == "self":
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and "*" not in shown:
            shown.append("*")
        star = "*" if parameter.kind is parameter.VAR_POSITIONAL else ""
        given = "" if parameter.default is parameter.empty else f"={parameter.default!r}"
        shown.append(f"{star}{parameter.name}{given}")
    return ",".join(shown)


CONTRACT = [
    (kind, name, wanted)
    for kind, text in ((MoveGroupCommander, GROUP), (PlanningSceneInterface, SCENE), (RobotCommander, ROBOT))
    for name, wanted in methods(text)
]


@pytest.mark.parametrize(
    ("kind", "name", "wanted"), CONTRACT, ids=lambda each: getattr(each, "__name__", each)
)
def test_method(kind: type, name: str, wanted: str) -> None:
    method = getattr(kind, name)
    assert arguments(method) == wanted
    assert (method.__doc__ or "").strip()


@pytest.mark.parametrize("kind", CONSTRUCTORS, ids=lambda kind: kind.__name__)
def test_constructor(kind: type) -> None:
    assert arguments(kind.__init__) == CONSTRUCTORS[kind]


def test_error_codes_are_moveits_numbers() -> None:
    for name, number in CODE_NUMBERS.items():
        assert getattr(MoveItErrorCodes, name) == number


def test_every_way_in_which_planning_ends_has_a_code() -> None:
    assert set(CODES) == set(Status)
    assert set(CODES.values()) <= set(CODE_NUMBERS.values())
    assert [status for status, code in CODES.items() if code == MoveItErrorCodes.SUCCESS] == [Status.SOLVED]
