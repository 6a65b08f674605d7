"""Stand-in for MoveIt 2's Python package `moveit` (moveit_py): `planning`, `core` and `task_constructor`."""

from trajopt.ros.commander.moveit import core as core
from trajopt.ros.commander.moveit import planning as planning
from trajopt.ros.commander.moveit import task_constructor as task_constructor
