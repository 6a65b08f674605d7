"""Nodes of the 3-D page: scene, trails, ghosts and nearest pairs."""

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from trajopt.geometry import JointPlacements
from trajopt.robot.loading.urdf import LinkGeometry
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.simulation.halo import THINNEST, Halo, halo, has_halo
from trajopt.values.arrays import Floats
from trajopt.values.errors import MeshFileError
from trajopt.values.placement import Placement, placement, scalar_first
from trajopt.values.shapes.shapes import Plane, Shape, placed_box
from trajopt.values.shapes.surfaces import surface
from trajopt.viewer import palette
from trajopt.viewer.clearance import ClearanceQuery, Nearest
from trajopt.viewer.palette import Rgb

if TYPE_CHECKING:
    from viser import FrameHandle, MeshHandle, ViserServer

TRANSLUCENT = 0.35
"""Opacity of objects seen through."""
HALO = 0.3
FLOOR_EDGE = 4.0
"""Edge of the floor grid [m]."""
WITNESS_SIZE = 0.006
"""Size of the dots at the two nearest points [m]."""


POINTS = 41
"""Of the line: two metres of it are drawn in pieces of 5 cm, which look round."""


class Trail:
    """A line in the page, as thick on the screen from near as from afar."""

    def __init__(self, server: "ViserServer", node: str, colour: Rgb, thickness: float) -> None:
        self._line = server.scene.add_line_segments(
            node,
            np.zeros((1, 2, 3), dtype=np.float32),
            colour,
            thickness=thickness,
            thickness_units="screen",
            visible=False,
        )

    def show(self, points: Floats | None, colour: Rgb | None = None) -> None:
        """Draw it through points, shape (k, 3); None for no line."""
        self._line.visible = points is not None
        if points is not None:
            self._line.points = np.stack((points[:-1], points[1:]), axis=1).astype(np.float32)
        if colour is not None:
            self._line.colors = np.array(colour, dtype=np.uint8)


def add_mesh(
    server: "ViserServer",
    node: str,
    shape: Shape,
    where: Placement,
    colour: Rgb,
    *,
    opacity: float | None = None,
    ghost: bool = False,
) -> "MeshHandle":
    """Draw a shape; a ghost has no inside and casts no shadow."""
    skin = surface(shape)
    return server.scene.add_mesh_simple(
        node,
        skin.vertices,
        skin.faces,
        color=colour,
        flat_shading=not skin.smooth,
        opacity=opacity,
        side="front" if ghost else "double",
        cast_shadow=not ghost and not isinstance(shape, Plane),
        wxyz=scalar_first(where),
        position=where.translation,
    )


class Drawing:
    """Robot, objects, floor, tool path and the line between the nearest points."""

    def __init__(
        self,
        server: "ViserServer",
        reduced: ReducedModel,
        start: JointPlacements,
        *,
        root: str = "",
        robot: bool = True,
        objects: bool = True,
    ) -> None:
        """Draw all in the start posture, below a root node if a page has several drawings."""
        self._server = server
        self._reduced = reduced
        self._name = root
        self._root = server.scene.add_frame(root, show_axes=False) if root else None
        self._halos: list[tuple[str, Halo, MeshHandle]] = []
        self._joints: list[FrameHandle] = [
            server.scene.add_frame(self._joint_node(joint), show_axes=False)
            for joint in range(1, reduced.model.njoints)
        ]
        self._collision: list[MeshHandle] = []
        self._visual: list[MeshHandle] = []
        self._objects: list[tuple[str, MeshHandle]] = []
        if robot:
            self._draw_robot()
            self._draw_floor()
        if objects:
            self._draw_objects()
        self._line = Trail(server, f"{root}/nearest/line", palette.TOUCHING, 3.0)
        self._dots = server.scene.add_point_cloud(
            f"{root}/nearest/points",
            np.zeros((2, 3)),
            palette.TOUCHING,
            point_size=WITNESS_SIZE,
            point_shape="circle",
            precision="float32",
            visible=False,
        )
        self.move(start)

    def show(self, visible: bool) -> None:
        if self._root is not None:
            self._root.visible = visible

    def move(self, kinematics: JointPlacements) -> None:
        with self._server.atomic():
            for joint, frame in enumerate(self._joints, start=1):
                where = Placement(kinematics.rotation[0, joint], kinematics.translation[0, joint])
                frame.wxyz = scalar_first(where)
                frame.position = where.translation

    def joint_placement(self, joint: str) -> Placement:
        frame = self._joints[list(self._reduced.model.names).index(joint) - 1]
        w, x, y, z = frame.wxyz
        return placement(frame.position, quaternion=(x, y, z, w))

    def point_out(self, nearest: Nearest | None) -> None:
        self._dots.visible = nearest is not None
        if nearest is None:
            self._line.show(None)
            return
        colour = palette.TOUCHING if nearest.distance < nearest.margin else palette.SAFE
        self._line.show(nearest.points, colour)
        self._dots.points = nearest.points.astype(np.float32)
        self._dots.colors = np.array(colour, dtype=np.uint8)

    def show_collision_shapes(self, visible: bool) -> None:
        with self._server.atomic():
            for handle in self._collision:
                handle.visible = visible

    def show_visual_shapes(self, visible: bool) -> None:
        with self._server.atomic():
            for handle in self._visual:
                handle.visible = visible

    def make_translucent(self, names: Collection[str]) -> None:
        with self._server.atomic():
            for name, handle in self._objects:
                handle.opacity = TRANSLUCENT if name in names else None

    def show_changing(self, timed: TimedModel, time: float) -> None:
        """Draw the objects that are there at a time [s], and halos as far as they may be off their tracks."""
        with self._server.atomic():
            for name, handle in self._objects:
                handle.visible = timed.there(name, time)
            for name, halo, handle in self._halos:
                distance = timed.error(name, time)
                handle.visible = timed.there(name, time) and distance > THINNEST
                if handle.visible:
                    handle.vertices = halo.grown(distance).astype(np.float32)

    def draw_halos(self, timed: TimedModel) -> None:
        """Prepare halos around uncertain objects; `show_changing` sets their size."""
        colours = self._colours()
        for count, body in enumerate(self._reduced.bodies):
            if timed.is_uncertain(body.owner) and has_halo(body):
                around = halo(body.shape, body.placement)
                handle = self._server.scene.add_mesh_simple(
                    f"{self._joint_node(body.joint)}/halo_{count}",
                    around.nearest,
                    around.faces,
                    color=colours[body.owner],
                    opacity=HALO,
                    cast_shadow=False,
                    visible=False,
                )
                self._halos.append((body.owner, around, handle))

    def draw_tool_paths(self, paths: Floats) -> None:
        for count, points in enumerate(paths):
            Trail(self._server, f"/tool_path_{count}", palette.TOOL_PATH, 2.5).show(points)

    def _draw_robot(self) -> None:
        robot = self._reduced.scene.robot
        for number, link in enumerate(robot.links):
            joint, where = self._reduced.attachment(link)
            plain = palette.LINKS[number % len(palette.LINKS)]
            visuals = [visual for visual in robot.visuals if visual.link == link]
            shapes = _readable(visuals)
            bodies = [body for body in self._reduced.bodies if body.owner == link]
            for count, (visual, shape) in enumerate(shapes):
                node = f"{self._joint_node(joint)}/link_{number}_visual_{count}"
                self._visual.append(self._mesh(node, shape, where * visual.placement, _colour(visual, plain)))
            for count, body in enumerate(bodies):
                node = f"{self._joint_node(joint)}/link_{number}_collision_{count}"
                if shapes:
                    handle = self._mesh(node, body.shape, body.placement, palette.COLLISION, opacity=0.45)
                    handle.visible = False
                    self._collision.append(handle)
                else:
                    self._mesh(node, body.shape, body.placement, plain)

    def _draw_objects(self) -> None:
        names, colours = list(self._reduced.scene.objects), self._colours()
        for count, body in enumerate(self._reduced.bodies):
            if body.owner in names:
                number = names.index(body.owner)
                colour = palette.GROUND if isinstance(body.shape, Plane) else colours[body.owner]
                node = f"{self._joint_node(body.joint)}/object_{number}_part_{count}"
                self._objects.append((body.owner, self._mesh(node, body.shape, body.placement, colour)))

    def _colours(self) -> dict[str, Rgb]:
        alike = list(dict.fromkeys(name.split("/")[0] for name in self._reduced.scene.objects))
        return {
            name: palette.SURFACES[alike.index(name.split("/")[0]) % len(palette.SURFACES)]
            for name in self._reduced.scene.objects
        }

    def _draw_floor(self) -> None:
        fixed = [b for b in self._reduced.bodies if b.joint == 0 and not isinstance(b.shape, Plane)]
        lowest = min((float(placed_box(b.shape, b.placement)[0, 2]) for b in fixed), default=0.0)
        self._server.scene.add_grid(
            "/floor",
            width=FLOOR_EDGE,
            height=FLOOR_EDGE,
            cell_size=0.1,
            cell_color=(228, 228, 228),
            section_size=0.5,
            section_color=(196, 196, 196),
            position=(0.0, 0.0, min(lowest, 0.0)),
        )

    def _joint_node(self, joint: int) -> str:
        return f"{self._name}/joint_{joint}" if joint else f"{self._name}/world"

    def _mesh(
        self, node: str, shape: Shape, where: Placement, colour: Rgb, *, opacity: float | None = None
    ) -> "MeshHandle":
        return add_mesh(self._server, node, shape, where, colour, opacity=opacity)


def _readable(visuals: list[LinkGeometry]) -> list[tuple[LinkGeometry, Shape]]:
    try:
        return [(visual, visual.shape) for visual in visuals]
    except MeshFileError:
        return []


def _colour(visual: LinkGeometry, plain: Rgb) -> Rgb:
    if visual.colour is None:
        return plain
    red, green, blue = (round(255 * min(max(share, 0.0), 1.0)) for share in visual.colour[:3])
    return red, green, blue


def in_world(reduced: ReducedModel, name: str, kinematics: JointPlacements) -> Placement:
    joint, where = reduced.attachment(name)
    return Placement(kinematics.rotation[0, joint], kinematics.translation[0, joint]) * where


OPACITY = 0.22
"""Of a ghost: faint enough for the robot, and for two ghosts, to be seen through it."""


class Ghost:
    """The robot by its convex collision shapes, in one colour."""

    def __init__(
        self,
        server: "ViserServer",
        reduced: ReducedModel,
        name: str,
        colour: Rgb,
        *,
        opacity: float = OPACITY,
    ) -> None:
        """Prepare it with an opacity from 0 to 1; nothing is shown yet."""
        self._server = server
        self._root = server.scene.add_frame(f"/{name}", show_axes=False, visible=False)
        moved = sorted({body.joint for body in reduced.bodies if body.joint})
        self._joints: list[tuple[int, FrameHandle]] = [
            (joint, server.scene.add_frame(f"/{name}/joint_{joint}", show_axes=False)) for joint in moved
        ]
        self._bodies = [
            add_mesh(
                server,
                f"/{name}/joint_{body.joint}/body_{count}",
                body.shape,
                body.placement,
                colour,
                opacity=opacity,
                ghost=True,
            )
            for count, body in enumerate(reduced.bodies)
            if body.joint
        ]

    def paint(self, colour: Rgb) -> None:
        with self._server.atomic():
            for body in self._bodies:
                body.color = colour

    def remove(self) -> None:
        self._root.remove()

    def stand(self, kinematics: JointPlacements | None) -> None:
        with self._server.atomic():
            self._root.visible = kinematics is not None
            if kinematics is None:
                return
            for joint, frame in self._joints:
                where = Placement(kinematics.rotation[-1, joint], kinematics.translation[-1, joint])
                frame.wxyz, frame.position = scalar_first(where), where.translation


PAIRS = 3
"""Number of marked pairs: more would hide the robot."""


class NearestDrawing:
    """Lines and labels."""

    def __init__(self, server: "ViserServer") -> None:
        self._server = server
        self._lines = [Trail(server, f"/nearest/line_{count}", palette.SAFE, 3.0) for count in range(PAIRS)]
        self._labels = [
            server.scene.add_label(
                f"/nearest/label_{count}", "", anchor="bottom-center", font_screen_scale=0.8, visible=False
            )
            for count in range(PAIRS)
        ]

    def show(self, pairs: tuple[Nearest, ...]) -> None:
        with self._server.atomic():
            for place, (line, label) in enumerate(zip(self._lines, self._labels, strict=True)):
                label.visible = place < len(pairs)
                if place >= len(pairs):
                    line.show(None)
                    continue
                near = pairs[place]
                line.show(near.points, colour_of(near))
                label.position = near.points.mean(axis=0)
                label.text = f"{1000.0 * near.distance:.3g} mm" if near.distance > 0.0 else "contact"


def colour_of(near: Nearest) -> palette.Rgb:
    if near.distance <= max(near.required, 0.0):
        return palette.TOUCHING
    return palette.NARROW if near.distance < near.margin else palette.SAFE


MEASURED = 24
"""Pairs measured to find those with something around the robot among them."""
CLOSE = 0.03
"""Pairs of links farther apart are not marked: some links are always near each other [m]."""


def telling_pairs(clearance: ClearanceQuery, positions: Floats, count: int) -> tuple[Nearest, ...]:
    """Return the nearest pairs at a posture (n,) [rad | m], the nearest first."""
    found = clearance.nearest_pairs(0.0, positions, MEASURED)
    objects = clearance.reduced.scene.objects.keys()
    apart = [each for each in found if each.distance < CLOSE or not objects.isdisjoint(each.owners)]
    return tuple((apart or found)[:count])
