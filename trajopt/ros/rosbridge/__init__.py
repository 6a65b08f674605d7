"""rosbridge, version 2: clients made for ROS and MoveIt plan and drive as if a `move_group` were behind it.

`rosbridge_face` serves a `Service` so; `docs/from-compas-fab.md` says what is answered, and how it differs.
"""

from trajopt.ros.rosbridge.description import RobotDescription as RobotDescription
from trajopt.ros.rosbridge.face import ANSWERS as ANSWERS
from trajopt.ros.rosbridge.face import serve_rosbridge as serve_rosbridge
from trajopt.ros.rosbridge.options import Distro as Distro
from trajopt.ros.rosbridge.options import RosbridgeOptions as RosbridgeOptions
