"""Waiting: the same motion begun later, among things that change with time.

A motion that begins at rest may begin at any later time. Sampled times are looked at, in order; what seems
clear is for the judge to prove.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, inf, log2

import numpy as np

from trajopt.arrays import Bools, Floats, Ints
from trajopt.model.timed import TimedModel
from trajopt.model.trajectory import Trajectory
from trajopt.query import Counts, Query

LOOK = 0.02
"""Time between two looks along a motion [s]: at 1 m/s things move by 2 cm, as between samples of a path."""
STEP = 0.05
"""Beginnings are tried in steps of this [s]; then halved between the last that was blocked and the next."""
HALVINGS = 4
"""So a motion begins within 3 ms of the earliest time that is clear."""
LONGEST = 60.0
"""Nothing waits longer [s]: whoever has so much time asks again."""
ROOM = 2e-3
"""Clearance that is kept above what is required, for what is between the looks [m]; of a pair that has less
at the start, half of what it has there."""


@dataclass(eq=False)
class Waiting:
    """Finds when a motion can begin; one for each thread.

    Attributes:
        timed: The model among what changes.
        counts: The work done so far.
    """

    timed: TimedModel
    counts: Counts
    _room: Floats = field(default_factory=lambda: np.zeros(0))

    def earliest(self, trajectory: Trajectory) -> Trajectory | None:
        """Return a motion begun as early as seems clear, at rest until then; None if no beginning does.

        Args:
            trajectory: Of the group's joints.
        """
        looks: Floats = np.linspace(0.0, trajectory.duration, max(2, ceil(trajectory.duration / LOOK) + 1))
        positions = trajectory(looks)
        self._leave_room(positions[:1])
        if self._clear(positions, looks):
            return trajectory
        at_rest = not (trajectory(0.0, 1).any() or trajectory(0.0, 2).any())
        blocked = 0.0
        for wait in self._beginnings() if at_rest else ():
            standing: Floats = np.arange(blocked, wait, LOOK, dtype=np.float64)
            if not self._clear(np.tile(positions[0], (len(standing), 1)), standing):
                return None
            if self._clear(positions, looks + wait):
                return begun_later(trajectory, self._sooner(positions, looks, blocked, wait))
            blocked = wait
        return None

    def _leave_room(self, start: Floats) -> None:
        """Note how much room each pair is to keep, by what it has where the motion begins."""
        known = self._pairs
        self._room = np.full(len(known.required), ROOM)
        reach = np.where(known.changes, known.required + known.error_at(0.0, slice(None)) + ROOM, -inf)
        found = self._query.close_pairs(self.timed.positions(start, np.zeros(1)), reach)
        spare = found.distance - known.required[found.pair] - known.error_at(0.0, found.pair)
        self._room[found.pair] = np.clip(spare / 2.0, 0.0, ROOM)

    def _beginnings(self) -> Iterator[float]:
        """Yield times to begin at, until nothing changes any more."""
        last = min(self._settled, LONGEST, self.timed.until)
        yield from (STEP * number for number in range(1, ceil(last / STEP)))
        if 0.0 < last < LONGEST:
            yield last

    @cached_property
    def _settled(self) -> float:
        """When everything has come to rest, appeared and expired [s]."""
        times = [0.0]
        for timing in self.timed.timings.values():
            ends = (timing.appears, timing.expires, 0.0 if timing.motion is None else timing.motion.track.end)
            times.append(max(time for time in ends if time < inf))
        return max(times) + LOOK

    def _sooner(self, positions: Floats, looks: Floats, blocked: float, clear: float) -> float:
        """Return a time to begin at, between one that is blocked and one that is clear."""
        for _ in range(HALVINGS):
            middle = (blocked + clear) / 2.0
            if self._clear(positions, looks + middle):
                clear = middle
            else:
                blocked = middle
        return clear

    def _clear(self, positions: Floats, times: Floats) -> bool:
        """Say whether the robot keeps clear of what changes at configurations (s, n) at times (s,)."""
        if not len(times):
            return True
        known = self._pairs
        # Distances of interest change seldom, so that bounds of the last look hold for the next.
        latest = 2.0 ** ceil(log2(max(float(times[-1]), LOOK)))
        least = known.required + self._room
        reach = np.where(known.changes, least + known.error_at(latest, slice(None)), -inf)
        found = self._query.close_pairs(self.timed.positions(positions, times), reach)
        when, pair = times[found.sample], found.pair
        there = (when >= known.appears[pair]) & (when <= known.expires[pair])
        near = found.distance < least[pair] + known.error_at(when, pair)
        return not bool((there & near).any())

    @cached_property
    def _query(self) -> Query:
        return Query(self.timed.reduced, self.counts)

    @cached_property
    def _pairs(self) -> "_ChangingPairs":
        return _ChangingPairs.of(self.timed)


@dataclass(frozen=True, eq=False)
class _ChangingPairs:
    """What is known of the pairs of which one changes with time; windows of contact are left to the judge.

    Attributes:
        changes: Whether one of the pair does, shape (p,).
        required: Clearance that is required, shape (p,) [m].
        errors: Radius, velocity and acceleration of the error, shape (p, 3).
        appears: When both are there, shape (p,) [s].
        expires: When no longer, shape (p,) [s].
    """

    changes: Bools
    required: Floats
    errors: Floats
    appears: Floats
    expires: Floats

    @staticmethod
    def of(timed: TimedModel) -> "_ChangingPairs":
        pairs, bodies = timed.reduced.pairs, timed.reduced.bodies
        count = len(pairs.first)
        changes, errors = np.zeros(count, dtype=np.bool_), np.zeros((count, 3))
        appears, expires = np.full(count, -inf), np.full(count, inf)
        for pair, both in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
            for body in both:
                timing = timed.timings.get(bodies[int(body)].owner)
                if timing is not None:
                    changes[pair] = True
                    errors[pair] += (0.0, 0.0, 0.0) if timing.motion is None else timing.motion.error
                    appears[pair] = max(appears[pair], timing.appears)
                    expires[pair] = min(expires[pair], timing.expires)
        changes[[pair for pair, _ in pairs.allowances]] = False
        return _ChangingPairs(changes, pairs.required, errors, appears, expires)

    def error_at(self, time: Floats | float, pair: Ints | slice) -> Floats:
        """Return the error of pairs at times [m]."""
        radius, velocity, acceleration = self.errors[pair].T
        return radius + velocity * time + acceleration * np.square(time) / 2.0


def begun_later(trajectory: Trajectory, wait: float) -> Trajectory:
    """Return a motion that rests at its start for a time and then goes on as it was.

    Args:
        trajectory: From rest.
        wait: How long [s].
    """

    def from_rest(rows: Floats) -> Floats:
        return np.concatenate((rows[:1], rows))

    velocities, accelerations = trajectory.velocities, trajectory.accelerations
    return Trajectory(
        trajectory.joint_names,
        np.append(0.0, trajectory.times + wait),
        from_rest(trajectory.positions),
        None if velocities is None else from_rest(velocities),
        None if accelerations is None else from_rest(accelerations),
    )
