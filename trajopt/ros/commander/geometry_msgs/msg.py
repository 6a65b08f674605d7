"""Messages of `geometry_msgs`: points, quaternions and poses."""

from trajopt.files.messages import class_in, classes_of

globals().update(classes_of("geometry_msgs"))  # for `from ... import *`
__getattr__ = class_in("geometry_msgs")
