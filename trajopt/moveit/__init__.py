"""MoveIt's own files, planning scenes, motion plan requests and trajectories, and what trajopt exports."""

from trajopt.moveit.constraints import reads_constraints as reads_constraints
from trajopt.moveit.motion_plan_request import RequestFile as RequestFile
from trajopt.moveit.motion_plan_request import read_request as read_request
from trajopt.moveit.motions import read_motions as read_motions
from trajopt.moveit.planning_scene import SceneFile as SceneFile
from trajopt.moveit.planning_scene import read_scene as read_scene
from trajopt.moveit.robot_trajectory import write_trajectory as write_trajectory
from trajopt.moveit.scene_files import write_scene as write_scene
from trajopt.moveit.trajectory_files import read_trajectory as read_trajectory
