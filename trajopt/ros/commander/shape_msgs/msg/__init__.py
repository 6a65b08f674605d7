"""Stands for `shape_msgs.msg`: primitives, meshes and planes."""

from trajopt.files.messages.shape_msgs import Mesh as Mesh
from trajopt.files.messages.shape_msgs import MeshTriangle as MeshTriangle
from trajopt.files.messages.shape_msgs import Plane as Plane
from trajopt.files.messages.shape_msgs import SolidPrimitive as SolidPrimitive
