"""Desk: one thread that does what a page is asked for, one thing after the other.

Whoever drags something asks more often than can be done. Of what has the same name only the last is done, and
nothing waits for what was asked before it. As all that changes what a page shows is done here, it needs no
lock.
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
        """Begin.

        Args:
            complain: Told, in that thread, why something could not be done.
        """
        self._complain = complain
        self._waiting: dict[str, Callable[[], None]] = {}
        self._working, self._closed = False, False
        self._news = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="trajopt live page", daemon=True)
        self._thread.start()

    def do(self, name: str, work: Callable[[], None]) -> None:
        """Have something done soon, in place of what has the same name and still waits."""
        with self._news:
            self._waiting[name] = work
            self._news.notify_all()

    def settle(self, seconds: float) -> bool:
        """Wait until all is done, or the seconds are over; say whether it is."""
        with self._news:
            return self._news.wait_for(lambda: not self._waiting and not self._working, seconds)

    def close(self) -> None:
        """End the thread; what waits is not done any more."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _work(self) -> None:
        """Do what waits, the oldest first (body of the thread)."""
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
