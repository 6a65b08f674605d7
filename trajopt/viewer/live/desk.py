"""Desk: one thread that handles the requests of a page in sequence; and buttons.

Dragging produces more requests than can be handled. Of requests with the same name only the last is handled.
All changes of the page happen in this thread, so no lock is needed.
"""

import logging
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from trajopt.values.errors import TrajoptError

if TYPE_CHECKING:
    from viser import ClientHandle, GuiButtonHandle, GuiEvent, ViserServer

LOG = logging.getLogger(__name__)


class Desk:
    """Does things in a thread of its own."""

    def __init__(self, complain: Callable[[str], None]) -> None:
        """Start the thread.

        Args:
            complain: Receives, in that thread, the reason why a request failed.
        """
        self._complain = complain
        self._waiting: dict[str, Callable[[], None]] = {}
        self._working, self._closed = False, False
        self._news = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="trajopt live page", daemon=True)
        self._thread.start()

    def do(self, name: str, work: Callable[[], None]) -> None:
        """Queue a request; it replaces a waiting one with the same name."""
        with self._news:
            self._waiting[name] = work
            self._news.notify_all()

    def settle(self, seconds: float) -> bool:
        """Wait until all requests are handled; return False after a time-out [s]."""
        with self._news:
            return self._news.wait_for(lambda: not self._waiting and not self._working, seconds)

    def close(self) -> None:
        """End the thread; waiting requests are dropped."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _work(self) -> None:
        """Handle requests, the oldest first (body of the thread)."""
        while True:
            with self._news:
                self._working = False
                self._news.notify_all()
                self._news.wait_for(lambda: bool(self._waiting) or self._closed)
                if self._closed:
                    return
                name = next(iter(self._waiting))
                work, self._working = self._waiting.pop(name), True
            try:
                work()
            except TrajoptError as error:
                self._complain(str(error))
            except Exception as error:  # a fault of the page must not leave it dead
                LOG.exception("the live page failed at %s", name)
                self._complain(f"a fault of this page ({type(error).__name__}: {error})")


Colour = Literal["blue", "green", "red", "gray"]


class Lever:
    """A button.

    Attributes:
        name: Its label.
        refusal: The reason why it is disabled; empty if enabled.
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
            name: Its label.
            hint: Its effect, shown under the mouse.
            pressed: Called on a press, with the page of the press.
            colour: Its colour.
        """
        self.name, self.refusal, self._hint = name, "", hint
        self._button: GuiButtonHandle = server.gui.add_button(name, hint=hint, color=colour)

        @self._button.on_click
        def _(event: "GuiEvent[GuiButtonHandle]") -> None:
            if not self.refusal:
                pressed(event.client)

    def allow(self, refusal: str = "") -> None:
        """Enable or disable it; the reason is shown in its hint."""
        self.refusal = refusal
        self._button.disabled = bool(refusal)
        self._button.hint = f"{self._hint} Not now: {refusal}." if refusal else self._hint

    def offer(self, there: bool) -> None:
        """Show it only while it is useful."""
        self._button.visible = there
        self.refusal = "" if there else "it is not offered"
