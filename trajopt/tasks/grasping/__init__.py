"""Picking and placing: grasp, carry and release an object in one verified sequence."""

from trajopt.tasks.grasping.grasp import Grasp as Grasp
from trajopt.tasks.grasping.grasp import GraspingOptions as GraspingOptions
from trajopt.tasks.grasping.grasp import Place as Place
from trajopt.tasks.grasping.grasp import Straight as Straight
from trajopt.tasks.grasping.grasp import grasps_of as grasps_of
from trajopt.tasks.grasping.grasp import pallet as pallet
from trajopt.tasks.grasping.gripper import Gripper as Gripper
from trajopt.tasks.grasping.gripper import gripper_of as gripper_of
from trajopt.tasks.grasping.planning import pick as pick
from trajopt.tasks.grasping.planning import pick_and_place as pick_and_place
from trajopt.tasks.grasping.planning import place as place
from trajopt.tasks.grasping.result import PickPlaceResult as PickPlaceResult
from trajopt.tasks.grasping.result import Segment as Segment
from trajopt.tasks.grasping.result import Stage as Stage
from trajopt.tasks.grasping.result import Timeline as Timeline
