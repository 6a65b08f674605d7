"""Playback: a slider over time, a button that plays, and a speed; and the pages that have one."""

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from trajopt.values.errors.arguments import checked
from trajopt.viewer.server import Served

if TYPE_CHECKING:
    from viser import GuiEvent, GuiSliderHandle, ViserServer

FRAME_TIME = 1 / 30
"""Time between two frames while playing [s]."""


class Playback:
    """A time slider from 0 to a duration, scrubbed by hand or played.

    Attributes:
        time: The shown time [s].
        lock: Held while drawing.
    """

    def __init__(
        self,
        server: "ViserServer",
        duration: float,
        draw: Callable[[float], None],
        taken: Callable[[], None] = lambda: None,
    ) -> None:
        """Add the controls; nothing is drawn yet.

        Args:
            duration: The last time [s].
            draw: Draws everything except the slider at a time [s].
            taken: Called when the user moves the slider, or plays.
        """
        self.time, self.lock = 0.0, threading.RLock()
        self._duration, self._draw = duration, draw
        self._playing, self._closed = threading.Event(), threading.Event()
        gui = server.gui
        step = 0.01 if duration > 1.0 else 0.001
        # The last step may lie beyond the end, which is what it shows then.
        self._slider = gui.add_slider("time [s]", 0.0, _last(duration, step), step, 0.0)
        self._button = gui.add_button("Play")
        self._speed = gui.add_slider("speed", 0.1, 2.0, 0.1, 1.0)

        @self._slider.on_update
        def _(event: "GuiEvent[GuiSliderHandle[float]]") -> None:
            if event.client is not None:
                taken()
                self.pause()
                with self.lock:
                    # Events may overtake each other: the slider itself holds the last value.
                    self.refresh(self._slider.value)

        @self._button.on_click
        def _(_: object) -> None:
            if self._playing.is_set():
                self.pause()
            else:
                taken()
                self.play()

        self._player = threading.Thread(target=self._play, name="trajopt viewer", daemon=True)
        self._player.start()

    @property
    def playing(self) -> bool:
        return self._playing.is_set()

    def show(self, t: float) -> None:
        """Show a time [s], clipped to the duration."""
        with self.lock:
            self.refresh(t)
            self._slider.value = self.time

    def refresh(self, t: float) -> None:
        """Show a time [s] without moving the slider."""
        with self.lock:
            self.time = min(max(float(t), 0.0), self._duration)
            self._draw(self.time)

    def lengthen(self, duration: float) -> None:
        """Extend the duration [s]."""
        with self.lock:
            self._duration = duration
            self._slider.max = max(_last(duration, self._slider.step), self._slider.max)

    def replace(self, duration: float) -> None:
        """Restart with another duration [s]; 0 for nothing to show."""
        with self.lock:
            self.pause()
            self._duration = duration
            self._slider.max = max(_last(duration, self._slider.step), self._slider.step)
            self._slider.disabled = self._button.disabled = self._speed.disabled = duration <= 0.0
            self._slider.value, self.time = 0.0, 0.0

    def play(self) -> None:
        with self.lock:
            if self.time >= self._duration:
                self.show(0.0)
            self._button.label = "Pause"
            self._playing.set()

    def pause(self) -> None:
        with self.lock:
            self._button.label = "Play"
            self._playing.clear()

    def close(self) -> None:
        """End the thread that plays: its frames would hold native objects beyond the interpreter's end."""
        with self.lock:
            self._closed.set()
            self._playing.set()
        self._player.join()

    def _play(self) -> None:
        """Advance while playing (body of the thread)."""
        last = time.monotonic()
        while not self._closed.is_set():
            if not self._playing.is_set():
                self._playing.wait()
                last = time.monotonic()
            now = time.monotonic()
            with self.lock:
                if self._playing.is_set() and not self._closed.is_set():
                    self.show(self.time + (now - last) * self._speed.value)
                    if self.time >= self._duration:
                        self.pause()
            last = now
            self._closed.wait(FRAME_TIME)


def _last(duration: float, step: float) -> float:
    """Return the end of a slider that must reach a duration [s]."""
    return round(float(np.ceil(duration / step)) * step, 3)


class PlayedPage(Served):
    """A page with a time slider."""

    _playback: Playback

    @property
    def time(self) -> float:
        """Shown time since the start [s]."""
        return self._playback.time

    @checked
    def show(self, t: float) -> None:
        """Show a time since the start [s], clipped to the duration."""
        self._leave_live()
        self._playback.show(t)

    def play(self) -> None:
        self._leave_live()
        self._playback.play()

    def pause(self) -> None:
        self._playback.pause()

    def _end(self) -> None:
        self._playback.close()

    def _leave_live(self) -> None:
        """Stop following a run that goes on; other pages have nothing to leave."""
