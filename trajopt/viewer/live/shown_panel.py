"""The panel of what is drawn: shapes of the robot, the trail of the hand, the nearest pairs."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from trajopt.values.arrays import Value
from trajopt.viewer.live.words import block_html

if TYPE_CHECKING:
    from viser import ViserServer


@dataclass(frozen=True)
class Shown(Value):
    """What is drawn.

    Attributes:
        links: The robot as it looks.
        collision: The robot's shapes that count in collisions.
        trail: The line that the hand draws along the motion.
        nearest: The nearest pairs, with their distances.
        reach: Where the hand gets to.
    """

    links: bool = True
    collision: bool = False
    trail: bool = True
    nearest: bool = True
    reach: bool = False


WORDS = {
    "links": ("robot as it looks", "The robot's visual shapes."),
    "collision": ("collision shapes", "The shapes that count when clearances are measured."),
    "trail": ("trail of the hand", "The line that the hand draws along the planned motion."),
    "nearest": ("nearest pairs", "What is nearest to what, with the distance."),
    "reach": ("reach of the hand", "Where the hand gets to without a collision; takes a moment."),
}
"""A label and a hint for each."""


class ShownPanel:
    """A tick for each."""

    def __init__(self, server: "ViserServer", changed: Callable[[Shown], None]) -> None:
        """Add the controls.

        Args:
            server: Serves the page.
            changed: Told what is to be drawn.
        """
        plain = Shown()
        self._ticks = {
            name: server.gui.add_checkbox(label, getattr(plain, name), hint=hint)
            for name, (label, hint) in WORDS.items()
        }
        for tick in self._ticks.values():
            tick.on_update(lambda _: changed(self.shown))
        self._text = server.gui.add_html("")

    def say(self, words: str) -> None:
        """Say something below the ticks."""
        self._text.content = block_html("", [words]) if words else ""

    @property
    def shown(self) -> Shown:
        """What is to be drawn."""
        return Shown(**{name: tick.value for name, tick in self._ticks.items()})
