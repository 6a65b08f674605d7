"""Stands for `std_msgs.msg`: headers, colours and plain values."""

from trajopt.files.messages.std_msgs import Bool as Bool
from trajopt.files.messages.std_msgs import ColorRGBA as ColorRGBA
from trajopt.files.messages.std_msgs import Empty as Empty
from trajopt.files.messages.std_msgs import Float32 as Float32
from trajopt.files.messages.std_msgs import Float32MultiArray as Float32MultiArray
from trajopt.files.messages.std_msgs import Float64 as Float64
from trajopt.files.messages.std_msgs import Float64MultiArray as Float64MultiArray
from trajopt.files.messages.std_msgs import Header as Header
from trajopt.files.messages.std_msgs import Int8 as Int8
from trajopt.files.messages.std_msgs import Int8MultiArray as Int8MultiArray
from trajopt.files.messages.std_msgs import Int16 as Int16
from trajopt.files.messages.std_msgs import Int32 as Int32
from trajopt.files.messages.std_msgs import Int64 as Int64
from trajopt.files.messages.std_msgs import MultiArrayDimension as MultiArrayDimension
from trajopt.files.messages.std_msgs import MultiArrayLayout as MultiArrayLayout
from trajopt.files.messages.std_msgs import String as String
from trajopt.files.messages.std_msgs import UInt8 as UInt8
from trajopt.files.messages.std_msgs import UInt16 as UInt16
from trajopt.files.messages.std_msgs import UInt32 as UInt32
from trajopt.files.messages.std_msgs import UInt64 as UInt64
