"""Recording of a run, and its logbook."""

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from threading import Lock
from typing import cast

import numpy as np

from trajopt.driving.commit_loop import CommitLoop
from trajopt.driving.committed_motion import CommittedMotion, of_joints
from trajopt.driving.events import Event, EventKind
from trajopt.driving.guard import ActionOutcome, Decision
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.problem.file_kinds import check_fields, check_value, model_kinds
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, floats, several
from trajopt.values.documents.codec import Kinds, Reader, Writer
from trajopt.values.documents.document import Node, read_document, write_json
from trajopt.values.errors import ProblemError, ShapeError, TrajoptError, shown
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.trajectory import Trajectory


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class RecordedMotion(Value):
    """A motion on the clock of the recording.

    Attributes:
        trajectory: Of the group's joints; None if there is none from then on.
    """

    since: float
    begin: float
    trajectory: Trajectory | None


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Sighting(Value):
    """A reported world, and when it was reported [s]."""

    since: float
    world: WorldSnapshot


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class RecordedDecision(Value):
    """A decision of a guard."""

    time: float
    decision: Decision


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class RecordedMoment(Value):
    """The state of a run at a time.

    Attributes:
        positions: Measured positions of the group's joints, shape (n,) [rad | m].
        stop: The committed motion, to rest; None at rest.
        plan: The rest of the motion to the goal, if any.
    """

    time: float
    positions: Floats
    stop: Trajectory | None
    plan: Trajectory | None
    sighting: Sighting
    events: tuple[Event, ...]


@checked_class
@dataclass(frozen=True, eq=False, kw_only=True)
class Recording(Value):
    """The recording of a run; sequences are in order of time.

    Attributes:
        start: Positions of all joints of the robot at the beginning, shape (number of joints,) [rad | m].
        times: Of the samples, increasing, shape (k,) [s].
        positions: Measured positions of the joints, shape (k, n) [rad | m].
        sightings: Reported worlds; the first from the beginning.
    """

    group: str
    start: Floats
    joint_names: tuple[str, ...]
    times: Floats
    positions: Floats
    committed: Sequence[RecordedMotion]
    intended: Sequence[RecordedMotion]
    sightings: Sequence[Sighting]
    events: Sequence[Event]
    decisions: Sequence[RecordedDecision] = ()

    def __post_init__(self) -> None:
        times = floats("times", self.times, (None,))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "start", floats("start", self.start, (None,)))
        shape = (len(times), len(self.joint_names))
        object.__setattr__(self, "positions", floats("positions", self.positions, shape))
        if not len(times) or (np.diff(times) <= 0.0).any():
            raise ShapeError("times", "must be at least one, and increase")
        kinds = {
            "committed": RecordedMotion,
            "intended": RecordedMotion,
            "sightings": Sighting,
            "events": Event,
            "decisions": RecordedDecision,
        }
        for name, kind in kinds.items():
            object.__setattr__(self, name, several(name, getattr(self, name), kind))
        for name in ("committed", "intended", "sightings"):
            if (np.diff([each.since for each in getattr(self, name)]) < 0.0).any():
                raise ProblemError(f"{name} must be sorted by time")
        if not self.sightings:
            raise ProblemError("sightings must have at least one element")

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.sightings[0].world.scene.robot

    @property
    def begin(self) -> float:
        """Time of the first sample [s]."""
        return float(self.times[0])

    @property
    def duration(self) -> float:
        return float(self.times[-1] - self.times[0])

    def reduced(self, sighting: Sighting) -> ReducedModel:
        return reduce_model(sighting.world.scene, self.group, self.start)

    def at(self, time: float) -> RecordedMoment:
        """Return the state at a time, interpolated between samples."""
        now = min(max(time, self.begin), float(self.times[-1]))
        sighted = bisect_right(self.sightings, now, key=lambda each: each.since)
        return RecordedMoment(
            time=now,
            positions=self._positions_at(now),
            stop=self._stop(now),
            plan=self._plan(now),
            sighting=self.sightings[max(sighted - 1, 0)],
            events=tuple(self.events[: bisect_right(self.events, now, key=lambda each: each.time)]),
        )

    def _positions_at(self, now: float) -> Floats:
        after = min(max(int(np.searchsorted(self.times, now)), 1), len(self.times) - 1)
        if not after:
            return self.positions[0]
        begin, end = self.times[after - 1 : after + 1].tolist()
        share = (now - begin) / (end - begin)
        return (1.0 - share) * self.positions[after - 1] + share * self.positions[after]

    def _stop(self, now: float) -> Trajectory | None:
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
        last = bisect_right(self.intended, now, key=lambda each: each.since)
        each = self.intended[last - 1] if last else None
        if each is None or each.trajectory is None or now >= each.begin + each.trajectory.duration:
            return None
        return each.trajectory.between(max(now - each.begin, 0.0), each.trajectory.duration)


LATEST = 64
"""Entries of each kind from which the last state is made: more than are ever committed at a time."""


@checked_class
class Logbook:
    """Records a run; call `look` after each cycle. It may be read in other threads."""

    def __init__(self) -> None:
        self._watched: CommitLoop | None = None
        self._times: list[float] = []
        self._positions: list[Floats] = []
        self._committed: list[RecordedMotion] = []
        self._intended: list[RecordedMotion] = []
        self._sightings: list[Sighting] = []
        self._decisions: list[RecordedDecision] = []
        self._kept: tuple[Trajectory, ...] = ()
        self._start: Floats = np.zeros(0)
        self._columns: list[int] = []
        self._lock = Lock()

    def look(self, watched: CommitLoop) -> None:
        """Record the present state."""
        with self._lock:
            if self._watched is None:
                self._watched, problem, driven = watched, watched.problem, watched.executor.joint_names
                self._columns = [driven.index(name) for name in problem.reduced.joint_names]
                robot, start = problem.scene.robot, np.array(problem.start_positions)
                start[robot.index(driven)] = watched.executor.state().commanded
                self._start = robot.followed(start)
            elif watched is not self._watched:
                raise ProblemError("a logbook records one driver; make another logbook")
            self._look(watched)

    def note(self, decision: Decision) -> None:
        """Record a decision of the guard, after a first `look`."""
        with self._lock:
            if self._watched is None:
                raise ProblemError("the logbook has no sample; call look before note")
            time = self._watched.executor.now()
            self._decisions.append(RecordedDecision(time=time, decision=decision))

    def _look(self, watched: CommitLoop) -> None:
        executor, now = watched.executor, watched.executor.now()
        if not self._times or now > self._times[-1]:
            self._times.append(now)
            self._positions.append(executor.state().positions[self._columns])
        if not self._sightings or watched.world is not self._sightings[-1].world:
            self._sightings.append(Sighting(since=now if self._sightings else -np.inf, world=watched.world))
        self._note_motions(watched, now)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self._times)

    @property
    def duration(self) -> float:
        return self._times[-1] - self._times[0] if self._times else 0.0

    @property
    def recording(self) -> Recording:
        """The recording until now, of at least one sample."""
        return self._recording(0)

    @property
    def moment(self) -> RecordedMoment:
        """The state at the last sample."""
        return self._recording(LATEST).at(np.inf)

    def _note_motions(self, watched: CommitLoop, now: float) -> None:
        names, pieces = watched.problem.reduced.joint_names, watched.committed.pieces
        for begin, motion in pieces:
            if not any(motion is known for known in self._kept):
                self._committed.append(
                    RecordedMotion(since=now, begin=begin, trajectory=of_joints(motion, names))
                )
        self._kept = tuple(motion for _, motion in pieces)
        intended, last = watched.intended, self._intended[-1] if self._intended else None
        motion = None if intended is None else intended.trajectory
        if motion is not (None if last is None else last.trajectory):
            begin = now if intended is None else intended.begin
            self._intended.append(RecordedMotion(since=now, begin=begin, trajectory=motion))

    def _recording(self, latest: int) -> Recording:
        with self._lock:
            watched = self._watched
            if watched is None:
                raise ProblemError("the logbook has no sample; call look after each cycle")
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
                decisions=tuple(self._decisions),
            )


FORMAT, VERSION = "trajopt recording", 1

OWN_KINDS = (RecordedMotion, RecordedDecision, Decision, ActionOutcome, Event, EventKind)
PARTS = tuple(name for name in (item.name for item in fields(Recording)) if name != "sightings")
WORLD = tuple(name for name in (item.name for item in fields(Scene)) if name != "robot")


@cache
def recording_kinds() -> Kinds:
    own = {kind.__name__: kind for kind in OWN_KINDS}
    return {**model_kinds(), **own, "TimedMotion": RecordedMotion, "Kind": EventKind}


@dataclass(frozen=True, eq=False)
class RecordingFile(Value):
    """A recording on disk, which needs its robot to be read.

        {
         "format": "trajopt recording",
         "version": 1,
         "robot": {"name": "panda", "joints": ["panda_joint1", ...], "source": {...}},
         "sightings": [{"since": 0.0, "stamp": 0.0, "scene": {"objects": {...}, "margin": 0.01, ...}}, ...],
         "group": "panda_arm", "times": {"array": [...], "type": "float64"}, "committed": [...], ...
        }

    It has the fields of `Recording`; `trajopt.values.documents.codec` describes the JSON of values.
    """

    robot_name: str
    source: Mapping[str, object] | None
    document: Node

    @staticmethod
    def is_one(path: Path | str) -> bool:
        """Return whether a file is a recording in JSON."""
        return Path(path).suffix == ".json" and read_document(path).has("format")

    @staticmethod
    def open(path: Path | str) -> "RecordingFile":
        """Open a file."""
        document = read_document(path)
        if document["format"].text("") != FORMAT:
            raise document.error(f"is not a recording: its format is not {FORMAT!r}")
        document.only(("format", "version", "robot", "sightings", *PARTS))
        if document["version"].number() != VERSION:
            raise document["version"].error(f"is {document['version'].number():g}, must be {VERSION}")
        robot = document["robot"].only(("name", "joints", "source"))
        source = robot["source"].value
        if source is not None and not isinstance(source, dict):
            raise robot["source"].error("must be a mapping")
        return RecordingFile(robot["name"].text(), cast("dict[str, object] | None", source), document)

    def read(self, robot: Robot) -> Recording:
        document = self.document
        joints = tuple(each.text() for each in document["robot"]["joints"].elements())
        if joints != robot.joint_names:
            raise document["robot"].error(
                f"is {shown(self.robot_name)}, whose joints differ from those of {shown(robot.name)}"
            )
        reader = Reader(recording_kinds(), check_fields, check_value)
        parts = {name: reader.value(document[name]) for name in PARTS if document.has(name)}
        sightings = [_sighting(reader, each, robot) for each in document["sightings"].elements()]
        try:
            return Recording(**parts, sightings=sightings)
        except TrajoptError as error:
            raise document.error(str(error)) from error


@checked
def read_recording(path: Path | str, robot: Robot) -> Recording:
    """Read a recording from a file.

    Raises:
        FileFormatError: If the robot is another one, or the file does not have the format.
    """
    return RecordingFile.open(path).read(robot)


@checked
def write_recording(
    path: Path | str, recording: Recording, source: Mapping[str, object] | None = None
) -> None:
    """Write a recording as JSON."""
    robot = recording.robot
    about = {"name": robot.name, "joints": list(robot.joint_names), "source": source}
    writer = Writer(recording_kinds())
    sightings = [
        {
            "since": writer.document(each.since, "since"),
            "stamp": each.world.stamp,
            "scene": {name: writer.document(getattr(each.world.scene, name), name) for name in WORLD},
        }
        for each in recording.sightings
    ]
    parts = {name: writer.document(getattr(recording, name), name) for name in PARTS}
    document = {"format": FORMAT, "version": VERSION, "robot": about, "sightings": sightings, **parts}
    write_json(path, document, indent=None)


def _sighting(reader: Reader, node: Node, robot: Robot) -> Sighting:
    node.only(("since", "stamp", "scene"))
    parts = {name: reader.value(node["scene"].only(WORLD)[name]) for name in WORLD}
    try:
        world = WorldSnapshot(Scene(robot=robot, **parts), node["stamp"].number())
        return Sighting(since=reader.value(node["since"]), world=world)
    except (TrajoptError, TypeError) as error:
        raise node.error(str(error)) from error
