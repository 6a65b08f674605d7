"""Recording: what a robot did, was committed to, meant to do and knew of the world, all through a run."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.events import Event
from trajopt.driving.guard import Seen
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel, reduce_model
from trajopt.values.arrays import Floats, Value, floats, several
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class TimedMotion(Value):
    """A motion on the clock of the recording.

    Attributes:
        since: When the robot was told to make it [s].
        begin: When it begins [s].
        trajectory: Of the group's joints; None where there is none from then on.
    """

    since: float
    begin: float
    trajectory: Trajectory | None


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Sighting(Value):
    """The world as it was told, and when.

    Attributes:
        since: When it was told [s].
        seen: What was.
    """

    since: float
    seen: Seen


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Moment(Value):
    """A moment of a run.

    Attributes:
        time: On the clock of the recording [s].
        positions: Where the group's joints were measured to be, shape (n,) [rad | m].
        stop: What the robot does if nothing more comes, to its rest; None where it stands.
        plan: What is left of the motion to the goal; None where there is none.
        sighting: The world as it was known.
        events: What had happened until then, in order.
    """

    time: float
    positions: Floats
    stop: Trajectory | None
    plan: Trajectory | None
    sighting: Sighting
    events: tuple[Event, ...]


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Recording(Value):
    """What happened in a run.

    Attributes:
        group: The group that moved.
        start: Positions of all of the robot's joints at the begin, shape (number of joints,) [rad | m].
        joint_names: The n joints of the group.
        times: When it was looked, increasing, shape (k,) [s].
        positions: Where the joints were measured to be, shape (k, n) [rad | m].
        committed: What was spliced in, in order; each ends at rest.
        intended: What the robot meant to do, in order.
        sightings: What was known of the world, in order; the first from the begin on.
        events: What happened, in order.
    """

    group: str
    start: Floats
    joint_names: tuple[str, ...]
    times: Floats
    positions: Floats
    committed: Sequence[TimedMotion]
    intended: Sequence[TimedMotion]
    sightings: Sequence[Sighting]
    events: Sequence[Event]

    def __post_init__(self) -> None:
        """Check that it fits together.

        Raises:
            ShapeError: If the numbers do not fit, or times do not increase.
            ProblemError: If nothing was known of the world, or lists are out of order.
        """
        times = floats("times", self.times, (None,))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "start", floats("start", self.start, (None,)))
        shape = (len(times), len(self.joint_names))
        object.__setattr__(self, "positions", floats("positions", self.positions, shape))
        if not len(times) or (np.diff(times) <= 0.0).any():
            raise ShapeError("times", "must increase, and be one at least")
        for name, kind in (
            ("committed", TimedMotion), ("intended", TimedMotion), ("sightings", Sighting), ("events", Event)
        ):  # fmt: skip
            object.__setattr__(self, name, several(name, getattr(self, name), kind))
        for name in ("committed", "intended", "sightings"):
            if (np.diff([each.since for each in getattr(self, name)]) < 0.0).any():
                raise ProblemError(f"{name} must be in the order of time")
        if not self.sightings:
            raise ProblemError("sightings must be one at least")

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.sightings[0].seen.scene.robot

    @property
    def begin(self) -> float:
        """When it begins [s]."""
        return float(self.times[0])

    @property
    def duration(self) -> float:
        """From the begin to the last look [s]."""
        return float(self.times[-1] - self.times[0])

    @checked
    def reduced(self, sighting: Sighting) -> ReducedModel:
        """Return the robot among what was seen; of all else than the group, as it stood at the begin."""
        return reduce_model(sighting.seen.scene, self.group, self.start)

    @checked
    def at(self, time: float) -> Moment:
        """Return a moment; between two looks the robot is drawn through.

        Args:
            time: On the clock of the recording; clipped to what was recorded [s].
        """
        now = min(max(time, self.begin), float(self.times[-1]))
        sighted = bisect_right(self.sightings, now, key=lambda each: each.since)
        return Moment(
            time=now,
            positions=self._positions_at(now),
            stop=self._stop(now),
            plan=self._plan(now),
            sighting=self.sightings[max(sighted - 1, 0)],
            events=tuple(self.events[: bisect_right(self.events, now, key=lambda each: each.time)]),
        )

    def _positions_at(self, now: float) -> Floats:
        """Return where the joints were measured to be, straight between two looks."""
        after = min(max(int(np.searchsorted(self.times, now)), 1), len(self.times) - 1)
        if not after:
            return self.positions[0]
        begin, end = self.times[after - 1 : after + 1].tolist()
        share = (now - begin) / (end - begin)
        return (1.0 - share) * self.positions[after - 1] + share * self.positions[after]

    def _stop(self, now: float) -> Trajectory | None:
        """Return what the robot was committed to."""
        last = bisect_right(self.committed, now, key=lambda each: each.since)
        first = last
        while first and (first == last or self.committed[first].begin > now):
            first -= 1
        motion = CommittedMotion(self.joint_names, self.positions[0])
        for each in self.committed[first:last]:
            if each.trajectory is not None:
                motion.splice(each.trajectory, each.begin, now=-np.inf)
        return motion.ahead(now, self.joint_names)

    def _plan(self, now: float) -> Trajectory | None:
        """Return what was left of the motion to the goal."""
        last = bisect_right(self.intended, now, key=lambda each: each.since)
        each = self.intended[last - 1] if last else None
        if each is None or each.trajectory is None or now >= each.begin + each.trajectory.duration:
            return None
        return each.trajectory.between(max(now - each.begin, 0.0), each.trajectory.duration)
