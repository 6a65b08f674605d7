"""Messages of `moveit_msgs`: requests, constraints, scenes and trajectories."""

from trajopt.files.messages import class_in, classes_of

globals().update(classes_of("moveit_msgs"))  # for `from ... import *`
__getattr__ = class_in("moveit_msgs")
