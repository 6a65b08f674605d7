"""Lever: a button that can be pressed only when that does something, and that says why not otherwise."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from viser import ClientHandle, GuiButtonHandle, GuiEvent, ViserServer

Colour = Literal["blue", "green", "red", "gray"]


class Lever:
    """A button.

    Attributes:
        name: What is written on it.
        refusal: Why it cannot be pressed now; empty if it can.
    """

    def __init__(
        self,
        server: "ViserServer",
        name: str,
        hint: str,
        pressed: Callable[["ClientHandle | None"], None],
        *,
        colour: Colour = "blue",
    ) -> None:
        """Add it to the page.

        Args:
            server: Serves the page.
            name: What is written on it.
            hint: What it does, shown when the mouse is over it.
            pressed: Called when somebody presses it, with the page where that was.
            colour: Its colour.
        """
        self.name, self.refusal, self._hint = name, "", hint
        self._button: GuiButtonHandle = server.gui.add_button(name, hint=hint, color=colour)

        @self._button.on_click
        def _(event: "GuiEvent[GuiButtonHandle]") -> None:
            if not self.refusal:
                pressed(event.client)

    def allow(self, refusal: str = "") -> None:
        """Let it be pressed, or not: then the reason stands in its hint."""
        self.refusal = refusal
        self._button.disabled = bool(refusal)
        self._button.hint = f"{self._hint} Not now: {refusal}." if refusal else self._hint

    def offer(self, there: bool) -> None:
        """Have it on the page only where it is of use: what cannot be pressed for long is not shown."""
        self._button.visible = there
        self.refusal = "" if there else "it is not offered"
