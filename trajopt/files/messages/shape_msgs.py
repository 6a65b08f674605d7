"""Messages of `shape_msgs`: primitives, meshes and planes."""

from dataclasses import dataclass, field
from typing import ClassVar

from trajopt.files.messages.geometry_msgs import Point, Polygon
from trajopt.files.messages.primitives import UInt8, UInt32


@dataclass(slots=True)
class SolidPrimitive:
    """A box, sphere, cylinder, cone or prism [m]; the constants give the order of the dimensions."""

    BOX: ClassVar[int] = 1
    SPHERE: ClassVar[int] = 2
    CYLINDER: ClassVar[int] = 3
    CONE: ClassVar[int] = 4
    PRISM: ClassVar[int] = 5
    BOX_X: ClassVar[int] = 0
    BOX_Y: ClassVar[int] = 1
    BOX_Z: ClassVar[int] = 2
    SPHERE_RADIUS: ClassVar[int] = 0
    CYLINDER_HEIGHT: ClassVar[int] = 0
    CYLINDER_RADIUS: ClassVar[int] = 1
    CONE_HEIGHT: ClassVar[int] = 0
    CONE_RADIUS: ClassVar[int] = 1
    PRISM_HEIGHT: ClassVar[int] = 0

    type: UInt8 = 0
    dimensions: list[float] = field(default_factory=list[float])
    polygon: Polygon = field(default_factory=Polygon)


@dataclass(slots=True)
class MeshTriangle:
    """Indices of the three vertices of a triangle."""

    vertex_indices: list[UInt32] = field(default_factory=list[UInt32])


@dataclass(slots=True)
class Mesh:
    """Triangles over vertices [m]."""

    triangles: list[MeshTriangle] = field(default_factory=list[MeshTriangle])
    vertices: list[Point] = field(default_factory=list[Point])


@dataclass(slots=True)
class Plane:
    """The plane a x + b y + c z + d = 0; the space below it is solid."""

    coef: list[float] = field(default_factory=list[float])
