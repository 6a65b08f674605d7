"""Messages of `visualization_msgs`: markers that show a robot."""

from trajopt.files.messages import class_in, classes_of

globals().update(classes_of("visualization_msgs"))  # for `from ... import *`
__getattr__ = class_in("visualization_msgs")
