"""What a search for clearance has still to prove, and what it has found."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.verify.kernel.windows import Windows


@dataclass(frozen=True, eq=False)
class Items:
    """What is still to be proven: pairs over intervals.

    Attributes:
        begin: Start of each interval, shape (c,) [s].
        end: End of each, shape (c,) [s].
        cell: Interval of each item, shape (i,).
        pair: Pair of each item, shape (i,).
    """

    begin: Floats
    end: Floats
    cell: Ints
    pair: Ints


@dataclass(frozen=True)
class Contact:
    """A measured contact that is not accepted, or a pair nearer than is required.

    Attributes:
        pair: The pair.
        time: When [s].
        distance: Signed distance then [m].
    """

    pair: int
    time: float
    distance: float


@dataclass(frozen=True)
class Gap:
    """An interval over which a pair could not be proven to keep apart.

    Attributes:
        pair: The pair.
        begin: Its start [s].
        end: Its end [s].
    """

    pair: int
    begin: float
    end: float


class Tally:
    """Smallest distance proven and measured of every pair.

    Attributes:
        proven: Smallest bound over the intervals proven so far, shape (p,) [m].
        measured: Smallest measured distance, shape (p,) [m]; infinite if never measured.
        time: When it was measured, shape (p,) [s].
    """

    def __init__(self, proven: Floats, measured: Floats, time: Floats) -> None:
        """Take what is known about p pairs, each of shape (p,)."""
        self.proven, self.measured, self.time = proven, measured, time

    @staticmethod
    def empty(count: int) -> "Tally":
        """Start with nothing known about a number of pairs."""
        return Tally(np.full(count, np.inf), np.full(count, np.inf), np.zeros(count))

    def note(self, pair: Ints, distance: Floats, time: Floats) -> None:
        """Take in measured distances."""
        falling = np.argsort(-distance, kind="stable")
        falling = falling[distance[falling] < self.measured[pair[falling]]]
        self.measured[pair[falling]] = distance[falling]
        self.time[pair[falling]] = time[falling]

    def best(self) -> float:
        """Smallest measured distance of all pairs [m]."""
        return float(self.measured.min(initial=np.inf))


@dataclass(frozen=True, eq=False)
class Findings:
    """What a search for a proof of clearance has found.

    Attributes:
        free: What is known of the pairs at times when they must keep apart.
        accepted: The same for times when their contact is accepted.
        contacts: Contacts found that are not accepted, and pairs nearer than is required.
        gap: First interval without proof, if the search was given up.
        windows: When contact is accepted.
    """

    free: Tally
    accepted: Tally
    contacts: tuple[Contact, ...]
    gap: Gap | None
    windows: Windows

    def deepest(self) -> tuple[Contact, ...]:
        """Return the deepest contact of each pair, deepest first."""
        every = sorted(self.contacts, key=lambda contact: -contact.distance)
        deepest = {contact.pair: contact for contact in every}
        return tuple(sorted(deepest.values(), key=lambda contact: contact.distance))

    def excused(self, contact: Contact) -> bool:
        """Say whether a contact is at a time at which some depth of it is accepted."""
        return bool(self.windows.accept(np.array([contact.time]), np.array([contact.pair]))[0])

    def correct(self, contact: Contact) -> None:
        """Take a contact, measured with more care, for the nearest that its pair comes."""
        tally = self.accepted if self.excused(contact) else self.free
        tally.measured[contact.pair], tally.time[contact.pair] = contact.distance, contact.time
