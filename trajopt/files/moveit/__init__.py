"""MoveIt's files: planning scenes, motion plan requests, trajectories, and exports of trajopt."""

from trajopt.files.moveit.constraints import reads_constraints as reads_constraints
from trajopt.files.moveit.motion_plan_request import RequestFile as RequestFile
from trajopt.files.moveit.motion_plan_request import read_request as read_request
from trajopt.files.moveit.planning_scene import SceneFile as SceneFile
from trajopt.files.moveit.planning_scene import read_motions as read_motions
from trajopt.files.moveit.planning_scene import read_scene as read_scene
from trajopt.files.moveit.scene_messages import write_scene as write_scene
from trajopt.files.moveit.trajectories import read_trajectory as read_trajectory
from trajopt.files.moveit.trajectories import write_trajectory as write_trajectory
