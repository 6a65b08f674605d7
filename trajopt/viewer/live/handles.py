"""Goal and objects on the live page, with gizmos for dragging them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from trajopt.geometry import Evaluator, JointPlacements
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene_object import SceneObject
from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement, placement, scalar_first
from trajopt.values.shapes.shapes import Plane
from trajopt.viewer import palette
from trajopt.viewer.clearance import ClearanceQuery, Nearest
from trajopt.viewer.drawing import PAIRS, Drawing, Ghost, NearestDrawing, add_mesh, in_world, telling_pairs
from trajopt.viewer.live.objects import is_carried
from trajopt.viewer.live.workbench import Goal, Reachability
from trajopt.viewer.palette import Rgb
from trajopt.viewer.scene_view import LONG

if TYPE_CHECKING:
    from viser import FrameHandle, TransformControlsEvent, TransformControlsHandle, ViserServer


class Gizmo:
    """Arrows and rings for dragging, drawn in front of everything."""

    def __init__(
        self, server: "ViserServer", node: str, length: float, dragged: Callable[[Placement], None]
    ) -> None:
        self.length, self._dragging = length, False
        self._handle: TransformControlsHandle = server.scene.add_transform_controls(
            node, scale=length, depth_test=False, line_width=3.5, visible=False
        )

        # A coroutine, so that its events come in their order.
        async def hear(event: "TransformControlsEvent") -> None:
            self._dragging = event.phase != "end"
            if event.phase == "update":
                dragged(self.placement)

        listen: Any = self._handle.on_update
        listen(hear)

    @property
    def placement(self) -> Placement:
        w, x, y, z = self._handle.wxyz
        return placement(self._handle.position, quaternion=(x, y, z, w))

    def show(self, where: Placement | None) -> None:
        self._handle.visible = where is not None
        if where is not None and not self._dragging:
            self._handle.position, self._handle.wxyz = where.translation, scalar_first(where)


HAND_GIZMO = 0.22
"""Length of the arrows [m], about a hand's."""
OPACITY = 0.45
"""Of the robot at its goal; the robot is seen through it."""
SAME = 5e-3
"""A robot this near to its goal in each joint hides it [rad | m]."""

COLOURS: dict[Reachability, Rgb] = {
    Reachability.REACHABLE: (0x22, 0x99, 0x66),
    Reachability.COLLIDING: palette.TOUCHING,
    Reachability.BEYOND_LIMITS: palette.STOP,
    Reachability.OUT_OF_REACH: (0x88, 0x88, 0x88),
}


class GoalDrawing:
    """The drawn goal and its gizmo."""

    def __init__(
        self, server: "ViserServer", reduced: ReducedModel, dragged: Callable[[Placement], None]
    ) -> None:
        self._server, self._ghosts = server, 0
        self.gizmo = Gizmo(server, "/goal/hand", HAND_GIZMO, dragged)
        self._ghost = Ghost(server, reduced, "goal_0", COLOURS[Reachability.REACHABLE], opacity=OPACITY)
        self._carried = _moved(reduced)

    def renew(self, reduced: ReducedModel) -> None:
        carried = _moved(reduced)
        if carried == self._carried:
            return
        self._carried = carried
        self._ghost.remove()
        self._ghosts += 1
        self._ghost = Ghost(
            self._server, reduced, f"goal_{self._ghosts}", COLOURS[Reachability.REACHABLE], opacity=OPACITY
        )

    def show(self, goal: Goal, query: Evaluator, now: np.ndarray) -> None:
        with self._server.atomic():
            self.gizmo.show(goal.placement)
            elsewhere = float(np.abs(goal.positions - now).max()) > SAME
            self._ghost.paint(COLOURS[goal.reachability])
            self._ghost.stand(query.kinematics(goal.positions[None]) if elsewhere else None)


def _moved(reduced: ReducedModel) -> list[tuple[str, int, bytes]]:
    return [
        (body.name, id(body.shape), body.placement.homogeneous.tobytes())
        for body in reduced.bodies
        if body.joint
    ]


OBJECT_GIZMO = 0.15
"""Length of the arrows at the chosen object: shorter than those at the hand [m]."""


@dataclass(eq=False)
class _Drawn:
    item: SceneObject
    frame: "FrameHandle"


class ObjectsDrawing:
    """The drawn objects."""

    def __init__(
        self, server: "ViserServer", picked: Callable[[str], None], dragged: Callable[[Placement], None]
    ) -> None:
        self._server, self._picked = server, picked
        self._drawn: dict[str, _Drawn] = {}
        self._count, self._chosen = 0, ""
        self._gizmo = Gizmo(server, "/chosen", OBJECT_GIZMO, dragged)

    def show(self, reduced: ReducedModel, kinematics: JointPlacements) -> None:
        """Draw the objects of a scene in the first configuration."""
        objects = reduced.scene.objects
        with self._server.atomic():
            for name in [each for each in self._drawn if each not in objects]:
                self._drawn.pop(name).frame.remove()
            for name, item in objects.items():
                known = self._drawn.get(name)
                if known is None or known.item.parts != item.parts:
                    if known is not None:
                        known.frame.remove()
                    self._drawn[name] = self._draw(item)
                else:
                    known.item = item
            self.move(reduced, kinematics)

    def move(self, reduced: ReducedModel, kinematics: JointPlacements) -> None:
        with self._server.atomic():
            for name, drawn in self._drawn.items():
                where = in_world(reduced, name, kinematics)
                drawn.frame.wxyz, drawn.frame.position = scalar_first(where), where.translation
            free = self._chosen in self._drawn and not is_carried(reduced.scene, self._chosen)
            self._gizmo.show(in_world(reduced, self._chosen, kinematics) if free else None)

    def choose(self, name: str) -> None:
        self._chosen = name

    def _draw(self, item: SceneObject) -> _Drawn:
        node, self._count = f"/objects/{self._count}", self._count + 1
        colour = palette.SURFACES[self._count % len(palette.SURFACES)]
        frame = self._server.scene.add_frame(node, show_axes=False)
        for count, (shape, where) in enumerate(item.parts):
            paint = palette.GROUND if isinstance(shape, Plane) else colour
            mesh = add_mesh(self._server, f"{node}/part_{count}", shape, where, paint)
            mesh.on_click(lambda _, name=item.name: self._picked(name))
        return _Drawn(item, frame)


class EditedScene:
    """A scene whose objects come and go in a page: the robot, the objects and the nearest pairs."""

    def __init__(
        self,
        server: "ViserServer",
        reduced: ReducedModel,
        positions: Floats,
        picked: Callable[[str], None] = lambda _: None,
        dragged: Callable[[Placement], None] = lambda _: None,
    ) -> None:
        self._server = server
        self.nearest: tuple[Nearest, ...] = ()
        self._objects = ObjectsDrawing(server, picked, dragged)
        self._near = NearestDrawing(server)
        self.change(reduced, positions)
        self.robot = Drawing(server, reduced, self.kinematics(positions[None]), objects=False)

    def change(self, reduced: ReducedModel, positions: Floats) -> None:
        self._reduced, self.clearance = reduced, ClearanceQuery(reduced, LONG)
        self._objects.show(reduced, self.kinematics(positions[None]))

    def kinematics(self, positions: Floats) -> JointPlacements:
        return self.clearance.query.kinematics(positions)

    def show(self, positions: Floats, *, pairs: bool = True) -> None:
        here = self.kinematics(positions[None])
        self.nearest = telling_pairs(self.clearance, positions, PAIRS) if pairs else ()
        with self._server.atomic():
            self.robot.move(here)
            self._objects.move(self._reduced, here)
            self._near.show(self.nearest)

    def choose(self, name: str) -> None:
        self._objects.choose(name)

    def line_of(self, frame: str, along: JointPlacements) -> Floats:
        joint, held = self._reduced.attachment(frame)
        return along.rotation[:, joint] @ held.translation + along.translation[:, joint]
