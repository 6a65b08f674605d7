"""Stand-ins for MoveIt's Python API: `moveit_commander`, its messages, and a simulated world.

See docs/from-moveit.md. Misuse raises a `MoveItCommanderException`.
"""

from collections.abc import Sequence

from trajopt.files.messages import PACKAGES, import_package
from trajopt.ros.commander import conversions as conversions
from trajopt.ros.commander import moveit as moveit
from trajopt.ros.commander import rclpy as rclpy
from trajopt.ros.commander import rospy as rospy
from trajopt.ros.commander import tf as tf
from trajopt.ros.commander.move_group import MoveGroupCommander as MoveGroupCommander
from trajopt.ros.commander.planning_scene_interface import PlanningSceneInterface as PlanningSceneInterface
from trajopt.ros.commander.robot import RobotCommander as RobotCommander
from trajopt.ros.commander.world import World as World
from trajopt.server.move_group.outcome import ExecutionOutcome as ExecutionOutcome
from trajopt.server.move_group.outcome import MoveItCommanderException as MoveItCommanderException

globals().update({name: import_package(__name__, name) for name in PACKAGES})


def roscpp_initialize(args: Sequence[str]) -> None:
    """Do nothing; no middleware is used."""


def roscpp_shutdown() -> None:
    """Do nothing; no middleware is used."""
