"""Stand-in for `moveit.task_constructor`, on `trajopt.tasks`."""

from trajopt.ros.commander.moveit.task_constructor import core as core
from trajopt.ros.commander.moveit.task_constructor import stages as stages
