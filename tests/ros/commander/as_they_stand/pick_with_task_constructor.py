"""A task for the MoveIt Task Constructor: a bar is turned on its table, and the hand goes home."""

from math import pi

import rclcpp
from geometry_msgs.msg import PoseStamped, TwistStamped
from moveit.task_constructor import core, stages
from moveit_commander import PlanningSceneInterface
from moveit_msgs.msg import Constraints, OrientationConstraint

rclcpp.init()
node = rclcpp.Node("bar")
ARM, HAND, BAR = "panda_arm", "hand", "bar"


def along_z(frame: str, way: float) -> TwistStamped:
    """Return a straight motion along z of a frame."""
    twist = TwistStamped()
    twist.header.frame_id = frame
    twist.twist.linear.z = way
    return twist


def lying(x: float, y: float) -> PoseStamped:
    """Return a pose of the bar on the table."""
    pose = PoseStamped()
    pose.header.frame_id = "world"
    pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = x, y, 0.215
    pose.pose.orientation.w = 1.0
    return pose


world = PlanningSceneInterface(synchronous=True)
world.remove_world_object()
table = lying(0.45, 0.1)
table.pose.position.z = 0.1
world.add_box("table", table, size=[0.4, 0.8, 0.2])
world.add_box(BAR, lying(0.4, 0.0), size=[0.12, 0.04, 0.03])

task = core.Task()
task.name = "move the bar"
task.loadRobotModel(node)
task.add(stages.CurrentState("now"))
pipeline = core.PipelinePlanner(node, "ompl", "RRTConnectkConfigDefault")
task.add(stages.Connect("to the bar", [(ARM, pipeline)]))

grasps = stages.GenerateGraspPose("grasps")
grasps.angle_delta = pi / 2
grasps.pregrasp, grasps.grasp = "open", "close"
grasps.setMonitoredStage(task["now"])
closing = stages.SimpleGrasp(grasps, "closing")
between_pads = PoseStamped()
between_pads.header.frame_id = "panda_hand"
between_pads.pose.position.z = 0.1034
between_pads.pose.orientation.x = 1.0
closing.setIKFrame(between_pads)
pick = stages.Pick(closing, "pick")
pick.eef, pick.object = HAND, BAR
pick.setApproachMotion(along_z("world", -1.0), 0.03, 0.1)
pick.setLiftMotion(along_z("world", 1.0), 0.03, 0.1)
task.add(pick)

level = OrientationConstraint()
level.parameterization = level.ROTATION_VECTOR
level.header.frame_id, level.link_name, level.orientation.w = "world", BAR, 1.0
level.absolute_x_axis_tolerance = level.absolute_y_axis_tolerance = 0.1
level.absolute_z_axis_tolerance = pi
carry = stages.Connect("carry", [(ARM, pipeline)])
carry.path_constraints = Constraints(orientation_constraints=[level])
task.add(carry)

there = stages.GeneratePlacePose("there")
there.setMonitoredStage(task["pick"])
there.object, there.pose = BAR, lying(0.5, 0.3)
place = stages.Place(stages.SimpleUnGrasp(there, "opening"), "place")
place.eef, place.object = HAND, BAR
place.setPlaceMotion(along_z("world", -1.0), 0.03, 0.1)
place.setRetractMotion(along_z("world", 1.0), 0.03, 0.1)
task.add(place)

home = stages.MoveTo("home", core.JointInterpolationPlanner())
home.group = ARM
home.setGoal("ready")
task.add(home)
shut = stages.MoveTo("shut", core.JointInterpolationPlanner())
shut.group = HAND
shut.setGoal("close")
task.add(shut)

if task.plan():
    task.publish(task.solutions[0])
    print("executed", task.execute(task.solutions[0]).val)
