"""Stands for `sensor_msgs.msg`: joint states."""

from trajopt.files.messages.sensor_msgs import JointState as JointState
from trajopt.files.messages.sensor_msgs import MultiDOFJointState as MultiDOFJointState
