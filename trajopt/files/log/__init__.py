"""Logs of motions and runs as MCAP, with Foxglove's messages in JSON."""

from trajopt.files.log.logs import McapLog as McapLog
from trajopt.files.log.robot_messages import RobotMessages as RobotMessages
