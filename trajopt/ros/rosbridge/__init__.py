"""rosbridge, version 2: clients made for ROS and MoveIt plan and move as with a `move_group`.

`rosbridge_face` serves a `Service` this way; `docs/from-compas-fab.md` lists the supported requests and
the differences.
"""

from trajopt.ros.rosbridge.description import RobotDescription as RobotDescription
from trajopt.ros.rosbridge.face import ANSWERS as ANSWERS
from trajopt.ros.rosbridge.face import serve_rosbridge as serve_rosbridge
from trajopt.ros.rosbridge.options import Distro as Distro
from trajopt.ros.rosbridge.options import RosbridgeOptions as RosbridgeOptions
