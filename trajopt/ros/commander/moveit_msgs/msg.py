"""Messages of `moveit_msgs`: what MoveIt plans with."""

from trajopt.files.messages import class_in, classes_of

globals().update(classes_of("moveit_msgs"))  # for `from ... import *`
__getattr__ = class_in("moveit_msgs")
