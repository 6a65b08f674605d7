"""The objects in the live page: one node each, so that a move sends one message."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from trajopt.geometry import JointPlacements
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene_object import SceneObject
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import Plane
from trajopt.viewer import palette
from trajopt.viewer.drawing import in_world, wxyz
from trajopt.viewer.live.gizmo import Gizmo
from trajopt.viewer.live.objects import is_carried
from trajopt.viewer.surface import surface

if TYPE_CHECKING:
    from viser import FrameHandle, MeshHandle, ViserServer

GIZMO = 0.15
"""Length of the arrows at the object that is chosen: shorter than those at the hand [m]."""


@dataclass(eq=False)
class _Drawn:
    """An object in the page."""

    item: SceneObject
    frame: "FrameHandle"
    meshes: "list[MeshHandle]"


class ObjectsDrawing:
    """The drawn objects."""

    def __init__(
        self, server: "ViserServer", picked: Callable[[str], None], dragged: Callable[[Placement], None]
    ) -> None:
        """Draw nothing yet.

        Args:
            server: Serves the page.
            picked: Receives the name of a clicked object.
            dragged: Receives the dragged placement of the chosen object in the world.
        """
        self._server, self._picked = server, picked
        self._drawn: dict[str, _Drawn] = {}
        self._count, self._chosen = 0, ""
        self._gizmo = Gizmo(server, "/chosen", GIZMO, dragged)

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
        """Place the objects as in the first of the configurations."""
        with self._server.atomic():
            for name, drawn in self._drawn.items():
                where = in_world(reduced, name, kinematics)
                drawn.frame.wxyz, drawn.frame.position = wxyz(where), where.translation
            free = self._chosen in self._drawn and not is_carried(reduced.scene, self._chosen)
            self._gizmo.show(in_world(reduced, self._chosen, kinematics) if free else None)

    def choose(self, name: str) -> None:
        """Choose an object for dragging, or none; `move` shows it."""
        self._chosen = name

    def _draw(self, item: SceneObject) -> _Drawn:
        node, self._count = f"/objects/{self._count}", self._count + 1
        colour = palette.SURFACES[self._count % len(palette.SURFACES)]
        frame = self._server.scene.add_frame(node, show_axes=False)
        drawn = _Drawn(item, frame, [])
        for count, (shape, where) in enumerate(item.parts):
            skin = surface(shape)
            mesh = self._server.scene.add_mesh_simple(
                f"{node}/part_{count}",
                skin.vertices,
                skin.faces,
                color=palette.GROUND if isinstance(shape, Plane) else colour,
                flat_shading=not skin.smooth,
                side="double",
                cast_shadow=not isinstance(shape, Plane),
                wxyz=wxyz(where),
                position=where.translation,
            )
            mesh.on_click(lambda _, name=item.name: self._picked(name))
            drawn.meshes.append(mesh)
        return drawn
