"""Kinematics by itself, without a motion to plan.

Every function takes a reduced model: the robot in its scene with one group's joints free. It is
`problem.reduced` of a problem, or without one
`trajopt.kinematics.reduce_model(scene, "panda_arm", robot.positions("ready"))`.
"""

from trajopt.kinematics.forward import Placements as Placements
from trajopt.kinematics.forward import forward_kinematics as forward_kinematics
from trajopt.kinematics.forward import frame_jacobian as frame_jacobian
from trajopt.kinematics.forward import manipulability as manipulability
from trajopt.kinematics.goal_candidates import goal_configurations as goal_configurations
from trajopt.kinematics.inverse import InverseSolutions as InverseSolutions
from trajopt.kinematics.inverse import inverse_kinematics as inverse_kinematics
from trajopt.kinematics.methods import INVERSE_METHODS as INVERSE_METHODS
from trajopt.kinematics.methods import InverseMethod as InverseMethod
from trajopt.kinematics.methods import LevenbergMarquardt as LevenbergMarquardt
from trajopt.kinematics.reach_map import ReachMap as ReachMap
from trajopt.kinematics.reach_map import reach_map as reach_map
from trajopt.kinematics.sampling import RandomConfigurations as RandomConfigurations
from trajopt.kinematics.sampling import random_configurations as random_configurations
from trajopt.kinematics.self_motion import SelfMotion as SelfMotion
from trajopt.kinematics.self_motion import self_motion as self_motion
from trajopt.kinematics.table import ConfigurationTable as ConfigurationTable
from trajopt.kinematics.table import read_table as read_table
from trajopt.kinematics.table import sample_table as sample_table
from trajopt.kinematics.validity import Validity as Validity
from trajopt.kinematics.validity import validity as validity
from trajopt.model.reduced import reduce_model as reduce_model
