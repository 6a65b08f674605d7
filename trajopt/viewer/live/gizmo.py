"""Gizmo: arrows and rings that a person drags something by."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from trajopt.values.placement import Placement, placement
from trajopt.viewer.drawing import wxyz

if TYPE_CHECKING:
    from viser import TransformControlsEvent, TransformControlsHandle, ViserServer


class Gizmo:
    """Arrows and rings for dragging, drawn in front of everything.

    Attributes:
        length: Of the arrows [m].
    """

    def __init__(
        self, server: "ViserServer", node: str, length: float, dragged: Callable[[Placement], None]
    ) -> None:
        """Add it, hidden.

        Args:
            server: Serves the page.
            node: Its name.
            length: Of the arrows [m].
            dragged: Receives its placement in the world while it is dragged.
        """
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
        """Its placement in the world."""
        w, x, y, z = self._handle.wxyz
        return placement(self._handle.position, quaternion=(x, y, z, w))

    def show(self, where: Placement | None) -> None:
        """Show it at a placement in the world, or hide it; a dragged one stays."""
        self._handle.visible = where is not None
        if where is not None and not self._dragging:
            self._handle.position, self._handle.wxyz = where.translation, wxyz(where)
