"""Messages of `sensor_msgs`: joint states and clouds of points."""

from trajopt.files.messages import class_in, classes_of

globals().update(classes_of("sensor_msgs"))  # for `from ... import *`
__getattr__ = class_in("sensor_msgs")
