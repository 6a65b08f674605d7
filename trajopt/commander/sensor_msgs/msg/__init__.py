"""Stands for `sensor_msgs.msg`: joint states."""

from trajopt.messages.sensor_msgs import JointState as JointState
from trajopt.messages.sensor_msgs import MultiDOFJointState as MultiDOFJointState
