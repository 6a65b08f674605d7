"""What a robot looks like, as markers."""

from collections.abc import Sequence

from trajopt.arrays import Floats
from trajopt.commander.conversions import pose_of
from trajopt.commander.geometry_msgs.msg import Vector3
from trajopt.commander.std_msgs.msg import ColorRGBA, Header
from trajopt.commander.visualization_msgs.msg import Marker, MarkerArray
from trajopt.errors import FrameNotFound
from trajopt.model.description.urdf import MeshReference
from trajopt.model.scene import Scene
from trajopt.model.shapes import Box, Cylinder, Sphere

GREY = (0.5, 0.5, 0.5, 1.0)
"""Colour of what the description leaves without one."""


def markers(scene: Scene, positions: Floats, links: Sequence[str]) -> MarkerArray:
    """Return a marker for every visual element of links.

    Args:
        scene: The scene.
        positions: Of all joints [rad | m].
        links: The links.

    Raises:
        FrameNotFound: If one is unknown.
    """
    robot = scene.robot
    for link in links:
        if link not in robot.links:
            raise FrameNotFound("link", link, robot.links)
    found: list[Marker] = []
    for element in robot.visuals:
        if element.link not in links:
            continue
        where = scene.placement_of(element.link, positions) * element.placement
        marker = Marker(Header(frame_id=robot.links[0]), element.link, len(found), pose=pose_of(where))
        marker.color = ColorRGBA(*(element.colour or GREY))
        match element.geometry:
            case MeshReference(path=path, scale=scale):
                marker.type, marker.mesh_resource = Marker.MESH_RESOURCE, f"file://{path}"
                marker.scale = Vector3(*scale)
            case Box(x=x, y=y, z=z):
                marker.type, marker.scale = Marker.CUBE, Vector3(x, y, z)
            case Sphere(radius=radius):
                marker.type, marker.scale = Marker.SPHERE, Vector3(2 * radius, 2 * radius, 2 * radius)
            case Cylinder(radius=radius, length=length):
                marker.type, marker.scale = Marker.CYLINDER, Vector3(2 * radius, 2 * radius, length)
            case _:
                continue  # URDF has no other primitives.
        found.append(marker)
    return MarkerArray(found)
