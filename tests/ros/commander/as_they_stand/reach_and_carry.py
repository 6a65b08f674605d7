#!/usr/bin/env python
"""What scripts for MoveIt do, written as they are: nothing in it knows of trajopt."""

# ruff: noqa -- written as scripts of Python 2's time are

from __future__ import print_function
from six.moves import input

import sys
import copy
import rospy
import moveit_commander
import moveit_msgs.msg
import geometry_msgs.msg
from math import pi
from std_msgs.msg import String
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory
from tf.transformations import quaternion_from_euler
from moveit_commander.conversions import pose_to_list
from geometry_msgs.msg import *

from helper_of_the_script import hand_over


def wait_until(scene, name, attached, known, timeout=4.0):
    start = rospy.get_time()
    rate = rospy.Rate(50)
    while rospy.get_time() - start < timeout and not rospy.is_shutdown():
        is_attached = len(scene.get_attached_objects([name]).keys()) > 0
        if is_attached == attached and (name in scene.get_known_object_names()) == known:
            return True
        rate.sleep()
    return False


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("reach_and_carry", anonymous=True)
    rospy.on_shutdown(lambda: print("at the end"))
    while not rospy.search_param("robot_description_semantic"):
        rospy.sleep(0.1)
    input("press Enter to set up")
    robot = moveit_commander.RobotCommander()
    scene = moveit_commander.PlanningSceneInterface(synchronous=True)
    group = moveit_commander.MoveGroupCommander("lab_arm")
    group.set_planner_id("RRTConnectkConfigDefault")
    display = rospy.Publisher("/display", moveit_msgs.msg.DisplayTrajectory, queue_size=20)
    words = rospy.Publisher("/words", String, queue_size=1, latch=True)
    while words.get_num_connections() < 1:
        rospy.sleep(0.1)
    scene.remove_world_object("box")
    print("groups:", robot.get_group_names(), "robot:", rospy.get_param("~robot", "lab"))
    print(robot.get_current_state())

    goal = group.get_current_joint_values()
    goal[0] = pi / 8
    print("there:", group.go(goal, wait=True))
    group.stop()

    here = group.get_current_pose().pose
    waypoints = []
    here.position.y -= 0.1
    waypoints.append(copy.deepcopy(here))
    here.position.x -= 0.05
    waypoints.append(copy.deepcopy(here))
    plan, fraction = group.compute_cartesian_path(waypoints, 0.01, 0.0)
    print("fraction:", fraction)
    message = moveit_msgs.msg.DisplayTrajectory()
    message.trajectory_start = robot.get_current_state()
    message.trajectory.append(plan)
    display.publish(message)
    print("executed:", group.execute(plan, wait=True))

    input("press Enter to take the box")
    pose = geometry_msgs.msg.PoseStamped()
    pose.header.frame_id = "hand"
    pose.header.stamp = rospy.Time.now()
    pose.pose.position.x = 0.15
    pose.pose.orientation = Quaternion(*quaternion_from_euler(0, 0, 0))
    scene.add_box("box", pose, size=(0.05, 0.05, 0.05))
    print("added:", wait_until(scene, "box", False, True))
    links = robot.get_link_names(group="wrist_only")
    scene.attach_box(group.get_end_effector_link(), "box", touch_links=links)
    print("attached:", wait_until(scene, "box", True, False))
    group.set_named_target("bent")
    print("carried:", group.go(wait=True))
    group.clear_pose_targets()
    hand_over(group, scene)
    print("detached:", wait_until(scene, "box", False, True))
    scene.remove_world_object("box")
    print("removed:", wait_until(scene, "box", False, False))
    words.publish("all done")
    rospy.loginfo("%d words: %s", len(sys.argv) - 1, " ".join(sys.argv[1:]))
    print(len(pose_to_list(here)), type(JointState()).__name__, type(JointTrajectory()).__name__)
    rospy.spin()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass
