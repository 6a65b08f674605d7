"""Messages of `trajectory_msgs`: joint trajectories."""

from trajopt.files.messages import class_in, classes_of

globals().update(classes_of("trajectory_msgs"))  # for `from ... import *`
__getattr__ = class_in("trajectory_msgs")
