"""Stands for what MoveIt's scripts call of `tf`."""

from trajopt.ros.commander.tf import transformations as transformations
