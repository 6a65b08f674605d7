"""A ROS 2 node: plans to each pose that is published, and sends the motion to the arm's controller.

    python planning_node.py --ros-args -p robot:=my_arm.urdf -p group:=arm

It subscribes to `/joint_states` and `/goal_pose` (`geometry_msgs/PoseStamped` of the group's tool, in a frame
of the robot), and is a client of the controller's action `FollowJointTrajectory`. It needs ROS 2 and trajopt
in one Python; the tests run it with stand-ins of ROS' modules. docs/drivers.md has drivers that watch the
robot.
"""

import rclpy
from control_msgs.action import FollowJointTrajectory
from geometry_msgs.msg import PoseStamped
from rclpy.action import ActionClient
from rclpy.node import Node
from rosidl_runtime_py.set_message import set_message_fields
from sensor_msgs.msg import JointState

import trajopt as to
from trajopt.files.messages import FollowJointTrajectoryGoal, encode
from trajopt.files.moveit.trajectories import trajectory_message


class PlanningNode(Node):
    """Plans from the measured state to the last pose that was published."""

    def __init__(self):
        """Load the robot, and begin to listen."""
        super().__init__("trajopt")
        self.declare_parameter("robot", "panda")
        self.declare_parameter("group", "panda_arm")
        self.declare_parameter("action", "/joint_trajectory_controller/follow_joint_trajectory")
        self.group = self.get_parameter("group").value
        self.scene = to.Scene(to.load(self.get_parameter("robot").value))  # .add("table", to.Box(...), ...)
        self.joints = {}
        action = self.get_parameter("action").value
        self.controller = ActionClient(self, FollowJointTrajectory, action)
        self.create_subscription(JointState, "/joint_states", self.hear_joints, 10)
        self.create_subscription(PoseStamped, "/goal_pose", self.go, 10)

    def hear_joints(self, state):
        """Store the positions of the joints [rad | m]."""
        known = self.scene.robot.joint_names
        stated = zip(state.name, state.position, strict=True)
        self.joints |= {name: position for name, position in stated if name in known}

    def go(self, message):
        """Plan to a pose, and drive there."""
        if not self.joints:
            self.get_logger().warning("no joint states yet: the pose is ignored")
            return
        try:
            result = to.plan(self.problem(message))
        except to.TrajoptError as error:  # a frame that the robot does not have, a start outside the limits
            self.get_logger().error(str(error))
            return
        self.get_logger().info(result.reason)
        if result.verified:
            self.drive(result.trajectory)

    def problem(self, message):
        """Return the problem that a pose of the group's tool states, in the frame of its header."""
        position, turn = message.pose.position, message.pose.orientation
        pose = to.placement((position.x, position.y, position.z), quaternion=(turn.x, turn.y, turn.z, turn.w))
        frame = self.scene.placement_of(message.header.frame_id, self.joints)
        return to.Problem(scene=self.scene, group=self.group, start=self.joints, goal=frame * pose)

    def drive(self, trajectory):
        """Send a motion to the controller."""
        motion = FollowJointTrajectoryGoal(trajectory_message(trajectory).joint_trajectory)
        goal = FollowJointTrajectory.Goal()
        set_message_fields(goal, encode(motion))
        if not self.controller.wait_for_server(timeout_sec=1.0):
            self.get_logger().error("the controller's action is not there")
            return
        self.controller.send_goal_async(goal).add_done_callback(self.answered)

    def answered(self, future):
        """Report whether the controller drives the motion."""
        taken = future.result().accepted
        self.get_logger().info("the controller drives" if taken else "the controller refuses the motion")


def main():
    """Plan until the process is ended."""
    rclpy.init()
    rclpy.spin(PlanningNode())


if __name__ == "__main__":
    main()
