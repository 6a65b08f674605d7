"""Gizmo: arrows and rings that a person drags something by."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from trajopt.values.placement import Placement, placement
from trajopt.viewer.drawing import wxyz

if TYPE_CHECKING:
    from viser import TransformControlsEvent, TransformControlsHandle, ViserServer


class Gizmo:
    """Arrows and rings, seen through whatever is before them.

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
            dragged: Told, again and again, where it is dragged to in the world.
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
        """Where it is in the world."""
        w, x, y, z = self._handle.wxyz
        return placement(self._handle.position, quaternion=(x, y, z, w))

    def show(self, where: Placement | None) -> None:
        """Show it somewhere in the world, or hide it; whoever drags it has it where it is."""
        self._handle.visible = where is not None
        if where is not None and not self._dragging:
            self._handle.position, self._handle.wxyz = where.translation, wxyz(where)
