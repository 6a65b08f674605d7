"""Picking and placing: an object is taken, carried and put down, in one sequence, all of it verified.

`trajopt.grasping.simulation` executes such a sequence in MuJoCo, where only friction holds the object.
"""

from trajopt.grasping.generators import grasps_of as grasps_of
from trajopt.grasping.grasp import Grasp as Grasp
from trajopt.grasping.grasp import GraspingOptions as GraspingOptions
from trajopt.grasping.grasp import Place as Place
from trajopt.grasping.grasp import Straight as Straight
from trajopt.grasping.gripper import Gripper as Gripper
from trajopt.grasping.gripper import gripper_of as gripper_of
from trajopt.grasping.planning import pick as pick
from trajopt.grasping.planning import pick_and_place as pick_and_place
from trajopt.grasping.planning import place as place
from trajopt.grasping.result import PickPlaceResult as PickPlaceResult
from trajopt.grasping.result import Refusal as Refusal
from trajopt.grasping.result import Segment as Segment
from trajopt.grasping.result import Stage as Stage
from trajopt.grasping.result import Timeline as Timeline
