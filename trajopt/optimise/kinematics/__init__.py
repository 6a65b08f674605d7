"""Kinematics alone, without a motion to plan.

Every function takes a reduced model, the robot in its scene with one group's joints free: `problem.reduced`,
or `reduce_model(scene, "panda_arm", robot.positions("ready"))`.
"""

from trajopt.optimise.kinematics.forward import Placements as Placements
from trajopt.optimise.kinematics.forward import forward_kinematics as forward_kinematics
from trajopt.optimise.kinematics.forward import frame_jacobian as frame_jacobian
from trajopt.optimise.kinematics.forward import manipulability as manipulability
from trajopt.optimise.kinematics.inverse import INVERSE_METHODS as INVERSE_METHODS
from trajopt.optimise.kinematics.inverse import InverseMethod as InverseMethod
from trajopt.optimise.kinematics.inverse import InverseSolutions as InverseSolutions
from trajopt.optimise.kinematics.inverse import LevenbergMarquardt as LevenbergMarquardt
from trajopt.optimise.kinematics.inverse import goal_configurations as goal_configurations
from trajopt.optimise.kinematics.inverse import inverse_kinematics as inverse_kinematics
from trajopt.optimise.kinematics.sampling import RandomConfigurations as RandomConfigurations
from trajopt.optimise.kinematics.sampling import random_configurations as random_configurations
from trajopt.optimise.kinematics.self_motion import SelfMotion as SelfMotion
from trajopt.optimise.kinematics.self_motion import self_motion as self_motion
from trajopt.optimise.kinematics.validity import Validity as Validity
from trajopt.optimise.kinematics.validity import validity as validity
from trajopt.scene.reducing import reduce_model as reduce_model
