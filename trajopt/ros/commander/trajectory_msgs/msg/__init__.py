"""Stands for `trajectory_msgs.msg`: joint trajectories."""

from trajopt.files.messages.trajectory_msgs import JointTrajectory as JointTrajectory
from trajopt.files.messages.trajectory_msgs import JointTrajectoryPoint as JointTrajectoryPoint
from trajopt.files.messages.trajectory_msgs import MultiDOFJointTrajectory as MultiDOFJointTrajectory
from trajopt.files.messages.trajectory_msgs import (
    MultiDOFJointTrajectoryPoint as MultiDOFJointTrajectoryPoint,
)
