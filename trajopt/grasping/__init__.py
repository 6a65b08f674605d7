"""Picking and placing: an object is taken, carried and put down, in one sequence verified whole.

`trajopt.grasping.simulation` executes such a sequence in MuJoCo, where only friction holds the object.
"""

from trajopt.grasping.described import gripper_of as gripper_of
from trajopt.grasping.generators import grasps_of as grasps_of
from trajopt.grasping.grasp import Grasp as Grasp
from trajopt.grasping.grasp import Place as Place
from trajopt.grasping.grasp import Straight as Straight
from trajopt.grasping.gripper import Gripper as Gripper
from trajopt.grasping.handling import Handling as Handling
from trajopt.grasping.handling import Refusal as Refusal
from trajopt.grasping.handling import Segment as Segment
from trajopt.grasping.handling import Stage as Stage
from trajopt.grasping.options import GraspingOptions as GraspingOptions
from trajopt.grasping.planning import pick as pick
from trajopt.grasping.planning import pick_and_place as pick_and_place
from trajopt.grasping.planning import place as place
from trajopt.grasping.timeline import Timeline as Timeline
