"""Stand-in for `moveit.core`: robot models, states, trajectories, scenes and constraints."""

from trajopt.ros.commander.moveit.core import kinematic_constraints as kinematic_constraints
from trajopt.ros.commander.moveit.core import planning_scene as planning_scene
from trajopt.ros.commander.moveit.core import robot_model as robot_model
from trajopt.ros.commander.moveit.core import robot_state as robot_state
from trajopt.ros.commander.moveit.core import robot_trajectory as robot_trajectory
