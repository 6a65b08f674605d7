"""A script for MoveIt 2's `moveit_py`, as people write them."""

import sys

import rclpy
from geometry_msgs.msg import Pose, PoseStamped
from moveit.core.kinematic_constraints import construct_joint_constraint, construct_link_constraint
from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy, MultiPipelinePlanRequestParameters, PlanRequestParameters
from moveit_msgs.msg import CollisionObject
from rclpy.logging import get_logger
from shape_msgs.msg import SolidPrimitive


def plan_and_execute(robot, component, logger, **parameters):
    result = component.plan(**parameters)
    if not result:
        logger.error(result.error_code.message)
        return False
    return bool(robot.execute(result.trajectory, controllers=[]))


def main():
    rclpy.init()
    logger = get_logger("lab.motions")
    robot = MoveItPy(node_name="motions")
    arm = robot.get_planning_component("arm")
    logger.info(f"{arm.planning_group_name}: {', '.join(arm.named_target_states)}")

    arm.set_start_state(configuration_name="bent")
    arm.set_goal_state(configuration_name="straight")
    print("named:", plan_and_execute(robot, arm, logger))

    state = RobotState(robot.get_robot_model())
    state.set_to_random_positions()
    arm.set_start_state_to_current_state()
    arm.set_goal_state(robot_state=state)
    parameters = PlanRequestParameters(robot, "ompl_rrtc")
    parameters.planner_id, parameters.planning_time = "RRTConnectkConfigDefault", 4.0
    print("state:", plan_and_execute(robot, arm, logger, single_plan_parameters=parameters))

    state.joint_positions = {"shoulder": 0.5, "elbow": -0.9, "wrist": 0.1}
    goal = PoseStamped()
    goal.header.frame_id = "base"
    goal.pose = state.get_pose("hand")
    arm.set_goal_state(pose_stamped_msg=goal, pose_link="hand")
    print("pose:", plan_and_execute(robot, arm, logger))

    group = robot.get_robot_model().get_joint_model_group("arm")
    state.joint_positions = {"shoulder": 0.2, "elbow": 0.4}
    held = construct_joint_constraint(robot_state=state, joint_model_group=group)
    where = state.get_pose("hand").position
    placed = construct_link_constraint("hand", "base", [where.x, where.y, where.z], 0.001)
    arm.set_goal_state(motion_plan_constraints=[held, placed])
    several = MultiPipelinePlanRequestParameters(robot, ["ompl_rrtc", "pilz_lin"])
    print("constraints:", plan_and_execute(robot, arm, logger, multi_plan_parameters=several))

    monitor = robot.get_planning_scene_monitor()
    with monitor.read_write() as scene:
        box = CollisionObject(id="box")
        box.header.frame_id = "base"
        box.primitives.append(SolidPrimitive(type=SolidPrimitive.BOX, dimensions=(0.1, 0.1, 0.1)))
        box.primitive_poses.append(Pose())
        box.primitive_poses[0].position.x, box.primitive_poses[0].position.z = 0.3, 0.1
        box.operation = CollisionObject.ADD
        scene.apply_collision_object(box)
        scene.current_state.update()
    with monitor.read_only() as scene:
        state = scene.current_state
        before = state.get_joint_group_positions("arm")
        state.set_joint_group_positions("arm", [0.0, 0.0, 0.0])
        print("colliding:", scene.is_state_colliding(state, "arm", verbose=True))
        reached = state.set_from_ik("arm", goal.pose, "hand")
        print("reached:", reached, scene.is_state_colliding(robot_state=state, joint_model_group_name="arm"))
        state.set_joint_group_positions("arm", before)
    with monitor.read_write() as scene:
        scene.remove_all_collision_objects()
    robot.shutdown()
    return 0 if not rclpy.ok() else 1


if __name__ == "__main__":
    sys.exit(main())
