"""Stand-in for MoveIt 2's Python package `moveit` (moveit_py): `planning` and `core`."""

from trajopt.ros.commander.moveit import core as core
from trajopt.ros.commander.moveit import planning as planning
