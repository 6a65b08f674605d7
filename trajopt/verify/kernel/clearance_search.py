"""Search for a proof that bodies keep apart at all times, by the native core."""

from dataclasses import dataclass

import numpy as np

from trajopt.scene.reduced import BodyPairs
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.pair_distances import PairDistances, required_clearances


class Windows:
    """Allowance windows of intended contact, by pair.

    Contact of a pair that is not present is accepted at any depth. If several allowances name one pair, the
    longest window and the smallest depth apply.

    Attributes:
        required: Clearance of the pairs outside of their windows, shape (p,) [m].
        edges: Times inside the motion at which a window opens or closes [s].
    """

    def __init__(
        self,
        pairs: BodyPairs,
        required: Floats,
        duration: float,
        present: Floats | None = None,
        *,
        staying: float = 0.0,
    ) -> None:
        """Collect the allowances.

        Args:
            duration: Of the motion [s].
            present: Time span in which both bodies are present, shape (p, 2) [s]; always by default.
            staying: Part of the duration at rest after the motion [s].
        """
        self.required = required
        self._rows: Floats = np.empty((len(pairs.first), 4))
        self._rows[:] = -np.inf, np.inf, np.inf, np.inf
        self._until, self._from, self._first_depth, self._last_depth = self._rows.T
        for pair, allowance in pairs.allowances:
            # Intended contact is that of the described robot, and distances are less the error of the model.
            depth = allowance.depth + float(pairs.error[pair])
            if allowance.first > 0.0:
                self._until[pair] = max(self._until[pair], allowance.first)
                self._first_depth[pair] = min(self._first_depth[pair], depth)
            if allowance.last > 0.0:
                self._from[pair] = min(self._from[pair], duration - staying - allowance.last)
                self._last_depth[pair] = min(self._last_depth[pair], depth)
        if present is not None:
            self._accept_absent(present[:, 0], present[:, 1], duration)
        windowed = pairs.allowances or present is not None
        edges = self._rows[:, :2] if windowed else np.empty(0)
        self.edges: Floats = np.array(sorted(set(edges[(edges > 0.0) & (edges < duration)].tolist())))

    def _accept_absent(self, appears: Floats, expires: Floats, duration: float) -> None:
        late, early = appears > np.maximum(self._until, 0.0), expires < np.minimum(self._from, duration)
        self._until[late], self._first_depth[late] = appears[late], np.inf
        self._from[early], self._last_depth[early] = expires[early], np.inf

    def rows(self, pair: Ints, clock: float) -> Floats:
        """Return times and depths of the windows of pairs (i,), on a clock that shows `clock` at the start.

        Returns:
            End of the first window, start of the last, depth in the first and in the last, shape (i, 4).
        """
        found = self._rows[pair]
        found[:, :2] += clock
        return found

    def accept(self, time: Floats, pair: Ints) -> Bools:
        return (time <= self._until[pair]) | (time >= self._from[pair])


@dataclass(frozen=True)
class Contact:
    """A contact that is not accepted, or a pair below its clearance; signed distance [m], time [s]."""

    pair: int
    time: float
    distance: float


@dataclass(frozen=True)
class Gap:
    """An interval [s] without a proof of a pair's clearance."""

    pair: int
    begin: float
    end: float


class Tally:
    """Smallest proven and measured distance of every pair.

    Attributes:
        proven: Smallest bound over the proven intervals, shape (p,) [m].
        measured: Smallest measured distance, shape (p,) [m]; infinite if never measured.
        time: Of that measurement, shape (p,) [s].
    """

    def __init__(self, proven: Floats, measured: Floats, time: Floats) -> None:
        self.proven, self.measured, self.time = proven, measured, time

    def best(self) -> float:
        return float(self.measured.min(initial=np.inf))


@dataclass(frozen=True, eq=False)
class Findings:
    """Result of a search for a proof of clearance.

    Attributes:
        accepted: Distances at times at which their contact is accepted.
        gap: First interval without a proof, if the search gave up.
    """

    free: Tally
    accepted: Tally
    contacts: tuple[Contact, ...]
    gap: Gap | None
    windows: Windows

    @property
    def proven(self) -> bool:
        return not self.contacts and self.gap is None

    def deepest(self) -> tuple[Contact, ...]:
        every = sorted(self.contacts, key=lambda contact: -contact.distance)
        deepest = {contact.pair: contact for contact in every}
        return tuple(sorted(deepest.values(), key=lambda contact: contact.distance))

    def excused(self, contact: Contact) -> bool:
        return bool(self.windows.accept(np.array([contact.time]), np.array([contact.pair]))[0])

    def correct(self, contact: Contact) -> None:
        tally = self.accepted if self.excused(contact) else self.free
        tally.measured[contact.pair], tally.time[contact.pair] = contact.distance, contact.time


def search_clearance(
    motion: JudgedMotion, distances: PairDistances, *, measured: bool = True, present: Floats | None = None
) -> Findings:
    """Search for a proof that all pairs keep apart over a motion, by conservative advancement.

    A pair at distance d at some time of an interval, whose bodies travel by at most m from there, is at
    distance d - m or more in all of it. If this is not enough, the interval is cut.

    Args:
        measured: Whether to measure margins too. Otherwise the search ends as soon as the verdict is known.
        present: Time span in which pairs are examined, shape (p, 2) [s]; while both are present by default.
    """
    position, reduced, options = motion.position, motion.reduced, motion.options
    present = distances.present_since(motion.clock) if present is None else present
    required, staying = required_clearances(reduced), motion.staying
    windows = Windows(reduced.pairs, required, motion.duration, present, staying=staying)
    strict = distances.strict if present is None else distances.always_apart(present)
    windowed, clock = np.flatnonzero(~strict), motion.clock
    free, accepted, contacts, gap, configurations = distances.core.search(
        position.times + clock,
        np.ascontiguousarray(position.coefficients),
        motion.differentiable,
        reduced.mimic_matrix,
        reduced.mimic_offset,
        windowed,
        windows.rows(windowed, clock),
        windows.edges + clock,
        np.array(
            (
                options.resolution,
                options.far,
                options.smallest_interval,
                options.most_distances,
                distances.error,
                max(min(options.first_intervals, int(motion.duration / options.first_interval)), 2),
            )
        ),
        measured,
    )
    motion.kinematics.calls += configurations
    return Findings(
        Tally(*free[:2], free[2] - clock),
        Tally(*accepted[:2], accepted[2] - clock),
        tuple(Contact(int(pair), float(time) - clock, float(distance)) for pair, time, distance in contacts),
        Gap(gap[0], gap[1] - clock, gap[2] - clock) if gap[0] >= 0 else None,
        windows,
    )
