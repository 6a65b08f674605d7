"""Logbook: what whoever drives a robot does, looked at after each cycle, for a view and for a recording."""

from collections.abc import Sequence
from threading import Lock
from typing import Protocol, runtime_checkable

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion, of_joints
from trajopt.driving.events import Event
from trajopt.driving.executor import Executor
from trajopt.driving.guard import Seen
from trajopt.driving.intention import Intention
from trajopt.driving.recording import Moment, Recording, Sighting, TimedMotion
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

LATEST = 64
"""The last moment is made of so many entries of each kind: more than a robot is ever committed to at once."""


@runtime_checkable
class Watched(Protocol):
    """Whoever drives a robot: a `Supervisor` or a `Servo`."""

    @property
    def executor(self) -> Executor:
        """What drives the robot."""
        ...

    @property
    def problem(self) -> Problem:
        """What is asked of it."""
        ...

    @property
    def events(self) -> Sequence[Event]:
        """What happened, in order."""
        ...

    @property
    def seen(self) -> Seen:
        """The world as it was last told."""
        ...

    @property
    def committed(self) -> CommittedMotion:
        """What the robot will do whatever comes."""
        ...

    @property
    def intended(self) -> Intention | None:
        """The motion to the goal that it is on."""
        ...


class Logbook:
    """What happened so far; `look` is called after each cycle of who is watched.

    It may be read in other threads.
    """

    def __init__(self) -> None:
        """Begin empty."""
        self._watched: Watched | None = None
        self._times: list[float] = []
        self._positions: list[Floats] = []
        self._committed: list[TimedMotion] = []
        self._intended: list[TimedMotion] = []
        self._sightings: list[Sighting] = []
        self._kept: tuple[Trajectory, ...] = ()
        self._start: Floats = np.zeros(0)
        self._columns: list[int] = []
        self._lock = Lock()

    @checked
    def look(self, watched: Watched) -> None:
        """Write down what is new.

        Raises:
            ProblemError: If it is another one than before.
        """
        with self._lock:
            if self._watched is None:
                self._begin(watched)
            elif watched is not self._watched:
                raise ProblemError("a logbook is of one robot: begin another one")
            self._look(watched)

    def _look(self, watched: Watched) -> None:
        executor, now = watched.executor, watched.executor.now()
        if not self._times or now > self._times[-1]:
            self._times.append(now)
            self._positions.append(executor.state().positions[self._columns])
        if not self._sightings or watched.seen is not self._sightings[-1].seen:
            self._sightings.append(Sighting(since=now if self._sightings else -np.inf, seen=watched.seen))
        self._note_motions(watched, now)

    @property
    def looks(self) -> int:
        """How many times were written down."""
        return len(self._times)

    @property
    def duration(self) -> float:
        """From the first look to the last [s]; 0 before."""
        return self._times[-1] - self._times[0] if self._times else 0.0

    @property
    def recording(self) -> Recording:
        """Everything so far.

        Raises:
            ProblemError: If nothing was looked at.
        """
        return self._recording(0)

    @property
    def moment(self) -> Moment:
        """The last moment that was looked at.

        Raises:
            ProblemError: If none was.
        """
        return self._recording(LATEST).at(np.inf)

    def _begin(self, watched: Watched) -> None:
        self._watched, problem, driven = watched, watched.problem, watched.executor.joint_names
        self._columns = [driven.index(name) for name in problem.reduced.joint_names]
        robot, start = problem.scene.robot, np.array(problem.start_positions)
        start[robot.index(driven)] = watched.executor.state().commanded
        self._start = robot.followed(start)

    def _note_motions(self, watched: Watched, now: float) -> None:
        """Write down what was spliced in since the last look, and a new way to the goal."""
        names, pieces = watched.problem.reduced.joint_names, watched.committed.pieces
        for begin, motion in pieces:
            if not any(motion is known for known in self._kept):
                self._committed.append(
                    TimedMotion(since=now, begin=begin, trajectory=of_joints(motion, names))
                )
        self._kept = tuple(motion for _, motion in pieces)
        intended, last = watched.intended, self._intended[-1] if self._intended else None
        motion = None if intended is None else intended.trajectory
        if motion is not (None if last is None else last.trajectory):
            begin = now if intended is None else intended.begin
            self._intended.append(TimedMotion(since=now, begin=begin, trajectory=motion))

    def _recording(self, latest: int) -> Recording:
        """Return the last entries of each kind, all where it is 0; of what was seen and happened, all."""
        with self._lock:
            watched = self._watched
            if watched is None:
                raise ProblemError("nothing was looked at yet")
            return Recording(
                group=watched.problem.group,
                start=self._start,
                joint_names=watched.problem.reduced.joint_names,
                times=np.array(self._times[-latest:]),
                positions=np.array(self._positions[-latest:]),
                committed=self._committed[-latest:],
                intended=self._intended[-latest:],
                sightings=self._sightings,
                events=tuple(watched.events),
            )
