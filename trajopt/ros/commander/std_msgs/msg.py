"""Messages of `std_msgs`: headers, colours and plain values."""

from trajopt.files.messages import class_in, classes_of

globals().update(classes_of("std_msgs"))  # for `from ... import *`
__getattr__ = class_in("std_msgs")
