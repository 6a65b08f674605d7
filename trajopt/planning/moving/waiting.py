"""Waiting: the same motion begun later, among things that change with time.

A motion that begins at rest may begin at any later time. Sampled times are looked at, in order; what seems
clear is for the judge to prove.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, inf

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.trajectory import Trajectory
from trajopt.planning.moving.looks import LOOK, Looks

STEP = 0.05
"""Beginnings are tried in steps of this [s]; then halved between the last that was blocked and the next."""
HALVINGS = 4
"""So a motion begins within 3 ms of the earliest time that is clear."""
MOST = 3
"""So many beginnings of one motion are judged: what lies between looks may be in the way of the first."""
JOLT = 1e-3
"""A motion may begin with an acceleration: it is reached from rest in so long, while nothing gets on [s]."""
LONGEST = 60.0
"""Nothing waits longer [s]: whoever has so much time asks again."""


@dataclass(eq=False)
class Waiting:
    """Finds when a motion can begin; one for each thread.

    Attributes:
        looks: Looks at configurations among what changes.
        dwell: How long the robot stays where a motion ends [s].
    """

    looks: Looks
    dwell: float = 0.0

    def beginnings(self, trajectory: Trajectory, *, latest: float = inf) -> Iterator[Trajectory]:
        """Yield a motion begun as early as seems clear, at rest until then, and a few times a little later.

        Args:
            trajectory: Of the group's joints.
            latest: It is begun no later than so [s].
        """
        self.looks.leave_room(trajectory(np.zeros(1)))
        if self._clear(trajectory, 0.0):
            yield trajectory
        if trajectory(0.0, 1).any():
            return
        blocked, yielded = 0.0, 0
        for wait in self._later(latest):
            standing: Floats = np.arange(blocked, wait, LOOK, dtype=np.float64)
            if yielded == MOST or not self._stands_clear(trajectory(np.zeros(1)), standing):
                return
            if self._clear(trajectory, wait):
                yield begun_later(trajectory, wait if yielded else self._sooner(trajectory, blocked, wait))
                yielded += 1
            blocked = wait

    def _later(self, latest: float) -> Iterator[float]:
        """Yield times to begin at, until nothing changes any more."""
        last = min(self.looks.settled, LONGEST, self.looks.timed.until, latest)
        yield from (STEP * number for number in range(1, ceil(last / STEP)))
        if 0.0 < last < LONGEST:
            yield last

    def _sooner(self, trajectory: Trajectory, blocked: float, clear: float) -> float:
        """Return a time to begin at, between one that is blocked and one that is clear."""
        for _ in range(HALVINGS):
            middle = (blocked + clear) / 2.0
            if self._clear(trajectory, middle):
                clear = middle
            else:
                blocked = middle
        return clear

    def _clear(self, trajectory: Trajectory, wait: float) -> bool:
        """Say whether a motion that is begun after a wait [s] keeps clear of what changes.

        Besides evenly spaced times it is looked at the very moments at which things appear and expire.
        """
        duration = trajectory.duration + self.dwell
        even = np.linspace(0.0, duration, max(2, ceil(duration / LOOK) + 1))
        looks: Floats = np.concatenate((even, np.clip(self.looks.moments - wait, 0.0, duration)))
        return self.looks.all_clear(trajectory(looks), looks + wait)

    def _stands_clear(self, start: Floats, times: Floats) -> bool:
        """Say whether the robot keeps clear of what changes while it stands at the start, (1, n)."""
        return not len(times) or self.looks.all_clear(np.tile(start, (len(times), 1)), times)


def begun_later(trajectory: Trajectory, wait: float) -> Trajectory:
    """Return a motion that rests at its start for a time and then goes on as it was.

    Where it begins with an acceleration, that is reached at the end of the wait: by a quintic from rest to
    rest with this acceleration at its end, inside which it is nowhere larger.

    Args:
        trajectory: With no velocity at its start.
        wait: How long [s].
    """
    positions, velocities, accelerations = (
        trajectory.positions, trajectory.velocities, trajectory.accelerations
    )  # fmt: skip
    before = [0.0]
    if accelerations is not None and accelerations[0].any():
        before.append(wait - min(JOLT, wait / 2.0))
    still = np.zeros((len(before), positions.shape[1]))
    return Trajectory(
        trajectory.joint_names,
        np.concatenate((before, trajectory.times + wait)),
        np.concatenate((still + positions[0], positions)),
        None if velocities is None else np.concatenate((still, velocities)),
        None if accelerations is None else np.concatenate((still, accelerations)),
    )
