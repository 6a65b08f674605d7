"""rosbridge, version 2, for clients made for ROS and MoveIt.

`rosbridge_face` serves a `Service` this way; see docs/from-compas-fab.md.
"""

from trajopt.ros.rosbridge.description import RobotDescription as RobotDescription
from trajopt.ros.rosbridge.face import ANSWERS as ANSWERS
from trajopt.ros.rosbridge.face import serve_rosbridge as serve_rosbridge
from trajopt.ros.rosbridge.options import Distro as Distro
from trajopt.ros.rosbridge.options import RosbridgeOptions as RosbridgeOptions
