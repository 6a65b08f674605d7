"""Stands for `geometry_msgs.msg`: points, quaternions and poses."""

from trajopt.files.messages.geometry_msgs import Accel as Accel
from trajopt.files.messages.geometry_msgs import Point as Point
from trajopt.files.messages.geometry_msgs import Point32 as Point32
from trajopt.files.messages.geometry_msgs import PointStamped as PointStamped
from trajopt.files.messages.geometry_msgs import Polygon as Polygon
from trajopt.files.messages.geometry_msgs import Pose as Pose
from trajopt.files.messages.geometry_msgs import PoseArray as PoseArray
from trajopt.files.messages.geometry_msgs import PoseStamped as PoseStamped
from trajopt.files.messages.geometry_msgs import Quaternion as Quaternion
from trajopt.files.messages.geometry_msgs import QuaternionStamped as QuaternionStamped
from trajopt.files.messages.geometry_msgs import Transform as Transform
from trajopt.files.messages.geometry_msgs import TransformStamped as TransformStamped
from trajopt.files.messages.geometry_msgs import Twist as Twist
from trajopt.files.messages.geometry_msgs import TwistStamped as TwistStamped
from trajopt.files.messages.geometry_msgs import Vector3 as Vector3
from trajopt.files.messages.geometry_msgs import Vector3Stamped as Vector3Stamped
from trajopt.files.messages.geometry_msgs import Wrench as Wrench
from trajopt.files.messages.geometry_msgs import WrenchStamped as WrenchStamped
