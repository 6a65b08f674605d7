"""A ghost: the robot, and what it carries, once more, translucent, where it will be."""

from typing import TYPE_CHECKING

from trajopt.geometry import Kinematics
from trajopt.scene.reduced import FixedBody, ReducedModel
from trajopt.values.placement import Placement
from trajopt.viewer.drawing import wxyz
from trajopt.viewer.palette import Rgb
from trajopt.viewer.surface import surface

if TYPE_CHECKING:
    from viser import FrameHandle, MeshHandle, ViserServer

OPACITY = 0.22
"""Of a ghost: faint enough for the robot, and for two ghosts, to be seen through it."""


class Ghost:
    """The robot by its collision shapes, which are few and convex, in one colour."""

    def __init__(
        self,
        server: "ViserServer",
        reduced: ReducedModel,
        name: str,
        colour: Rgb,
        *,
        opacity: float = OPACITY,
    ) -> None:
        """Prepare it; nothing is shown yet.

        Args:
            server: Serves the page.
            reduced: The robot, and what it carries.
            name: Of its node.
            colour: Of all of it.
            opacity: Of all of it, from 0 to 1.
        """
        self._server = server
        self._root = server.scene.add_frame(f"/{name}", show_axes=False, visible=False)
        moved = sorted({body.joint for body in reduced.bodies if body.joint})
        self._joints: list[tuple[int, FrameHandle]] = [
            (joint, server.scene.add_frame(f"/{name}/joint_{joint}", show_axes=False)) for joint in moved
        ]
        self._bodies = [
            self._body(f"/{name}/joint_{body.joint}/body_{count}", body, colour, opacity)
            for count, body in enumerate(reduced.bodies)
            if body.joint
        ]

    def paint(self, colour: Rgb) -> None:
        """Give all of it another colour."""
        with self._server.atomic():
            for body in self._bodies:
                body.color = colour

    def remove(self) -> None:
        """Take it off the page for good."""
        self._root.remove()

    def stand(self, kinematics: Kinematics | None) -> None:
        """Place it as in the last of the configurations; hide it where there is none."""
        with self._server.atomic():
            self._root.visible = kinematics is not None
            if kinematics is None:
                return
            for joint, frame in self._joints:
                where = Placement(kinematics.rotation[-1, joint], kinematics.translation[-1, joint])
                frame.wxyz, frame.position = wxyz(where), where.translation

    def _body(self, node: str, body: FixedBody, colour: Rgb, opacity: float) -> "MeshHandle":
        skin = surface(body.shape)
        return self._server.scene.add_mesh_simple(
            node,
            skin.vertices,
            skin.faces,
            color=colour,
            flat_shading=not skin.smooth,
            opacity=opacity,
            side="front",
            cast_shadow=False,
            wxyz=wxyz(body.placement),
            position=body.placement.translation,
        )
