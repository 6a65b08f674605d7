"""Contacts of a simulation: when which pair touched, how deep, and whether it was allowed."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from trajopt.scene.clearances import ContactAllowance

SAME_CONTACT = 0.02
"""Contacts of a pair that separate for less than this [s] are reported as one."""


@dataclass(frozen=True)
class Contact:
    """Two things touching over an interval of time.

    Attributes:
        pair: Names of the two links or objects.
        start: When it began [s].
        end: When it ended [s].
        depth: Deepest penetration [m]; MuJoCo's contacts yield a little.
        allowance: Name of the allowance that covers all of it; None for a collision.
    """

    pair: tuple[str, str]
    start: float
    end: float
    depth: float
    allowance: str | None = None

    def __str__(self) -> str:
        """Say it in words."""
        first, second = self.pair
        meant = "" if self.allowance is None else f" (meant: {self.allowance})"
        return (
            f"{first} touches {second} from {self.start:.3f} s to {self.end:.3f} s, "
            f"{self.depth * 1e3:.2f} mm deep{meant}"
        )


class ContactLog:
    """Merges the contacts seen at single instants into intervals."""

    def __init__(self, allowances: Iterable[ContactAllowance], duration: float) -> None:
        """Start empty.

        Args:
            allowances: Contacts that are allowed.
            duration: Of the trajectory, from whose end allowances count backwards [s].
        """
        self._allowances = tuple(allowances)
        self._duration = duration
        self._open: dict[tuple[str, str], Contact] = {}
        self._closed: list[Contact] = []

    def record(self, time: float, depths: Mapping[tuple[str, str], float]) -> None:
        """Note which pairs touch at an instant, later than those before.

        Args:
            time: The instant [s].
            depths: Penetration by pair [m].
        """
        for pair, depth in depths.items():
            running = self._open.get(pair)
            if running is not None and time - running.end <= SAME_CONTACT:
                self._open[pair] = Contact(pair, running.start, time, max(depth, running.depth))
                continue
            if running is not None:
                self._closed.append(running)
            self._open[pair] = Contact(pair, time, time, depth)

    def contacts(self) -> tuple[Contact, ...]:
        """Return all contacts, in the order of their beginnings."""
        found = (*self._closed, *self._open.values())
        return tuple(sorted(map(self._judged, found), key=lambda contact: (contact.start, contact.pair)))

    def _judged(self, contact: Contact) -> Contact:
        for allowance in self._allowances:
            early = contact.end <= allowance.first
            late = allowance.last > 0.0 and contact.start >= self._duration - allowance.last
            if frozenset(contact.pair) == allowance.pair and (early or late):
                if contact.depth <= allowance.depth:
                    return Contact(contact.pair, contact.start, contact.end, contact.depth, allowance.name)
        return contact
