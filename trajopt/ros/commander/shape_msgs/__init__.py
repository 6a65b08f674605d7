"""Stand-in for the ROS package of this name; its messages are in `msg`."""

from trajopt.ros.commander.shape_msgs import msg as msg
