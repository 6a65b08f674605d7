"""Motions in the formats that controllers read: CSV, ROS 2, MoveIt, URScript."""

from trajopt.export.exporter import Exported as Exported
from trajopt.export.exporter import Exporter as Exporter
from trajopt.export.messages import FollowJointTrajectory as FollowJointTrajectory
from trajopt.export.messages import JointTrajectory as JointTrajectory
from trajopt.export.messages import RobotTrajectory as RobotTrajectory
from trajopt.export.registry import EXPORTERS as EXPORTERS
from trajopt.export.registry import export as export
from trajopt.export.registry import exporter_named as exporter_named
from trajopt.export.table import Csv as Csv
from trajopt.export.urscript import Movej as Movej
from trajopt.export.urscript import Servoj as Servoj
