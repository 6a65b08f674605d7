"""Stand-in for the part of `tf` that MoveIt's scripts use."""

from trajopt.ros.commander.tf import transformations as transformations
