"""Messages of `shape_msgs`: primitives, meshes and planes."""

from trajopt.files.messages import class_in, classes_of

globals().update(classes_of("shape_msgs"))  # for `from ... import *`
__getattr__ = class_in("shape_msgs")
