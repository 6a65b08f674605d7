"""Stands for `visualization_msgs.msg`: markers that show a robot."""

from trajopt.files.messages.visualization_msgs import Marker as Marker
from trajopt.files.messages.visualization_msgs import MarkerArray as MarkerArray
