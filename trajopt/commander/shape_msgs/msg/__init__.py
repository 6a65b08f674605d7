"""Stands for `shape_msgs.msg`: primitives, meshes and planes."""

from trajopt.messages.shape_msgs import Mesh as Mesh
from trajopt.messages.shape_msgs import MeshTriangle as MeshTriangle
from trajopt.messages.shape_msgs import Plane as Plane
from trajopt.messages.shape_msgs import SolidPrimitive as SolidPrimitive
