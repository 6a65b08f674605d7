"""Stand-in for the ROS package of this name; its messages are in `msg`."""

from trajopt.ros.commander.std_msgs import msg as msg
