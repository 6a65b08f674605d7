"""Stands for what MoveIt's scripts call of `tf`."""

from trajopt.commander.tf import transformations as transformations
