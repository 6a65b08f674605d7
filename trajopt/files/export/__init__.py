"""Motions in the formats that controllers read (CSV, ROS 2, MoveIt, URScript), and in that of logs (MCAP)."""

from trajopt.files.export.exporter import Exported as Exported
from trajopt.files.export.exporter import Exporter as Exporter
from trajopt.files.export.exporter import ModelExporter as ModelExporter
from trajopt.files.export.mcap import Mcap as Mcap
from trajopt.files.export.registry import EXPORTERS as EXPORTERS
from trajopt.files.export.registry import export as export
from trajopt.files.export.registry import exporter_named as exporter_named
from trajopt.files.export.sampled import Csv as Csv
from trajopt.files.export.sampled import FollowJointTrajectory as FollowJointTrajectory
from trajopt.files.export.sampled import JointTrajectory as JointTrajectory
from trajopt.files.export.sampled import RobotTrajectoryMessage as RobotTrajectoryMessage
from trajopt.files.export.urscript import Movej as Movej
from trajopt.files.export.urscript import Servoj as Servoj
