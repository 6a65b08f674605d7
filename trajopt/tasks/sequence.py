"""Several planned motions, in order: their times, and the whole as one motion."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Generic, Protocol, TypeVar

import numpy as np

from trajopt.planning.budget import Stop
from trajopt.planning.result import Result, SavedResult
from trajopt.planning.status import Certainty, OutcomeSummary, Status
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import whole_robot
from trajopt.scene.scene import Scene
from trajopt.scene.track import Track
from trajopt.timing.time_scaling import after_standing, standing
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.errors import PlanningFailed, ProblemError, ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement
from trajopt.values.trajectory import MEETING, Trajectory
from trajopt.verify.certificate import Certificate, joined

SAMPLE = 0.02
"""Time between two placements of an object in the hand, between which it moves straight [s]."""


class PlannedSegment(Protocol):
    """One motion with its rest."""

    result: Result

    @property
    @abstractmethod
    def title(self) -> str:
        """The names of its stages."""

    @property
    @abstractmethod
    def rest(self) -> float:
        """Rest at its end [s]."""

    @property
    def scene(self) -> Scene:
        """The scene in which it was planned."""
        return self.result.problem.scene

    @property
    def trajectory(self) -> Trajectory:
        """The motion of its group."""
        return self.result.require().trajectory

    @property
    def duration(self) -> float:
        """Of motion and rest [s]."""
        return self.trajectory.duration + self.rest

    @checked
    def positions(self, time: float) -> Floats:
        """Return positions of all joints at a time."""
        return self.result.problem.reduced.all_positions(self.trajectory(time))

    @property
    def end(self) -> Floats:
        """Positions of all joints at its end [rad | m]."""
        return self.positions(self.trajectory.duration)


@dataclass(frozen=True)
class StageTime:
    """When a stage takes place.

    Attributes:
        begin: Its begin since the start of the task [s].
    """

    name: str
    begin: float
    end: float

    def __str__(self) -> str:
        return f"{self.begin:8.2f} s {self.end - self.begin:8.2f} s  {self.name}"


@dataclass(frozen=True)
class CandidateNames:
    """Names of the grasp, the place and the object that a motion belongs to; empty for none."""

    grasp: str = ""
    place: str = ""
    object: str = ""


NO_NAMES = CandidateNames()


@dataclass(frozen=True, eq=False)
class StageRefusal(Value):
    """The reason why one way to do a stage was rejected.

    Attributes:
        result: The planning result; None if no motion was planned.
        names: The rejected grasp and place, and their object.
    """

    stage: str
    status: Status
    reason: str
    result: Result | None = None
    names: CandidateNames = NO_NAMES

    def __str__(self) -> str:
        part = "" if self.names.object in self.stage else f"part {self.names.object}"
        which = ", ".join(name for name in (part, self.names.grasp, self.names.place) if name)
        return ": ".join(part for part in (self.stage, which, self.reason) if part)

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {"stage": self.stage, "status": self.status.name, "reason": self.reason, **vars(self.names)}


@dataclass(frozen=True)
class StageNode:
    """A stage in the tree of a task, or several that are one alternative.

    Attributes:
        choice: Of an alternative, in words: whether it was chosen, and its cost.
    """

    name: str
    choice: str = ""
    items: "tuple[StageNode, ...]" = ()

    @property
    def taken(self) -> tuple[str, ...]:
        """Names of the stages without items that a plan does."""
        if self.choice and not self.choice.startswith("chosen"):
            return ()
        return tuple(name for item in self.items for name in item.taken) if self.items else (self.name,)


@dataclass(frozen=True)
class StageRow:
    """A line of the tree of stages: a stage, one of its steps, or a rejected way with its reason.

    Attributes:
        depth: Number of stages around it.
        time: Without a name; None outside the plan.
        clearance: Least proven clearance of its motions [m]; infinity without any.
    """

    text: str
    depth: int = 0
    time: StageTime | None = None
    clearance: float = inf

    def indented(self) -> str:
        """Return the text, indented by its depth."""
        return "  " * self.depth + self.text

    def __str__(self) -> str:
        return f"{self.time or ''!s:23}{self.indented()}"


Part = TypeVar("Part", bound=PlannedSegment)


@dataclass(frozen=True, eq=False, kw_only=True)
class MotionSequence(SavedResult, Generic[Part]):
    """Planned motions in order, or why there are none.

    Attributes:
        final_scene: The scene after, with the clock at the end of the last motion; the scene before without a
            plan.
        start: Positions of all joints before, shape (number of joints,) [rad | m].
        status: Without a plan, of the way that failed at the last stage.
        segments: The motions, in order; empty without a plan.
        refusals: The rejected ways to do stages, with reasons, in the order of the search.
        failed: Last stage, in the order of the task, at which a way failed; empty with a plan.
        cpu_seconds: Process time of each stage of planning [s].
        stopped: The cause of an early end of planning; None without one.
        outline: The stages of a task, choices with their alternatives.
    """

    name: str
    scene: Scene
    final_scene: Scene
    start: Floats
    group: str
    status: Status
    segments: tuple[Part, ...]
    counts: Mapping[str, int]
    cpu_seconds: Mapping[str, float]
    refusals: tuple[StageRefusal, ...]
    failed: str = ""
    stopped: Stop | None = None
    outline: tuple[StageNode, ...] = ()

    def __post_init__(self) -> None:
        here = self.start
        for index, segment in enumerate(self.segments):
            away = float(np.abs(segment.positions(0.0) - here).max(initial=0.0))
            if away > MEETING:
                raise ShapeError("segments", f"motion {index} begins {away:.3g} rad or m away from the arm")
            here = segment.end

    @property
    def verified(self) -> bool:
        """Whether there is a plan, each motion of which the judge verified in the scene of its time."""
        return self.status is Status.SOLVED

    def require(self) -> tuple[Part, ...]:
        """Return the motions.

        Raises:
            PlanningFailed: Without a verified plan; carries this result.
        """
        if not self.verified:
            raise PlanningFailed(str(self.explain()), self)
        return self.segments

    @property
    def reason(self) -> str:
        """The outcome in a sentence."""
        if self.verified:
            count = len(self.segments)
            return f"{shown(self.name)} takes {self.duration:.2f} s in {count} motion{'s' * (count != 1)}"
        refusal = next((item for item in self.refusals if item.stage == self.failed), None)
        return f"{self.status.name}: {refusal or 'the search ended before a way was found or rejected'}"

    def explain(self) -> OutcomeSummary:
        """Return the cycle times of the stages, or the reasons of the rejected ways, for printing."""
        ended = "" if self.stopped is None else "; the search was not finished"
        blocked = not self.verified and any(self._is_of_the_start(item) for item in self.refusals)
        grounds = f"ways tried and rejected: {len(self.refusals)}{ended}"
        if self.verified:
            grounds = "the judge verified every motion in the scene of its time"
        elif blocked:
            grounds = "every way begins at that configuration, where it was measured"
        return OutcomeSummary(
            status=self.status,
            reason=self.reason,
            certainty=Certainty.PROVEN if self.verified or blocked else Certainty.EVIDENCE,
            grounds=grounds,
            details=tuple(map(str if self.verified else StageRow.indented, self.tree))
            if len(self.refusals) > 1 or self.verified
            else (),
        )

    def _is_of_the_start(self, refusal: StageRefusal) -> bool:
        """Return whether a proof about the configuration before all motions refutes every way."""
        of_start = (Status.START_IN_COLLISION, Status.START_OUT_OF_LIMITS)
        result = refusal.result
        if result is None or refusal.status not in of_start or result.certainty is not Certainty.PROVEN:
            return False
        reduced = result.problem.reduced
        same = dict(reduced.scene.objects) == dict(self.scene.objects)
        return same and np.array_equal(reduced.start, self.start)

    @property
    def causes(self) -> tuple[str, ...]:
        """The rejected ways with their reasons, in words; ways of a stage with the same status together."""
        return tuple(words for _, words in self._causes)

    @property
    def _causes(self) -> list[tuple[str, str]]:
        found: dict[tuple[str, Status], list[StageRefusal]] = {}
        for item in self.refusals:
            found.setdefault((item.stage, item.status), []).append(item)
        return [
            (stage, f"{items[0]}{f' ({len(items)} ways)' if len(items) > 1 else ''}")
            for (stage, _), items in found.items()
        ]

    @cached_property
    def _spans(self) -> list[tuple[float, float, float]]:
        """Begin and end of each motion [s], and its least proven clearance [m]."""
        return [
            (begin, begin + each.duration, each.result.require().certificate.clearance)
            for begin, each in zip(self.begins.tolist(), self.segments, strict=True)
        ]

    @property
    def tree(self) -> tuple[StageRow, ...]:
        """The stages with time and clearance, items below theirs, and the rejected ways."""
        times, word = (self.stages, "rejected: ") if self.verified else ((), "")
        causes = [(stage, word + reason) for stage, reason in self._causes]
        nodes = self.outline or tuple(StageNode(item.name) for item in times)
        rows = [row for node in nodes for row in self._rows(node, 0, times, causes)]
        return (*rows, *(StageRow(words) for _, words in causes))

    def _rows(
        self, node: StageNode, depth: int, times: Sequence[StageTime], causes: list[tuple[str, str]]
    ) -> list[StageRow]:
        """Return the rows of a node; its causes are taken out of the list."""
        own = [item for item in times if _within(item.name, node)]
        steps = [item for item in own if item.name != node.name]
        tried = [words for stage, words in causes if _within(stage, node)]
        causes[:] = [item for item in causes if not _within(item[0], node)]
        below = [row for item in node.items for row in self._rows(item, depth + 1, times, causes)]
        taken = [*own, *(row.time for row in below if row.time is not None)]
        heads = bool(taken or below or node.choice)
        text = f"{node.name} ({node.choice})" if node.choice else node.name
        return [
            *([self._row(text, depth, taken)] if heads else []),
            *(self._row(item.name.removeprefix(f"{node.name}: "), depth + 1, [item]) for item in steps),
            *(StageRow(words, depth + heads) for words in tried),
            *below,
        ]

    def _row(self, text: str, depth: int, taken: Sequence[StageTime]) -> StageRow:
        if not taken:
            return StageRow(text, depth)
        begin, end = min(item.begin for item in taken), max(item.end for item in taken)
        own = [least for since, until, least in self._spans if since < end - 1e-9 and begin + 1e-9 < until]
        return StageRow(text, depth, StageTime("", begin, end), min(own, default=inf))

    @property
    def duration(self) -> float:
        return sum(segment.duration for segment in self.require())

    @property
    def final_positions(self) -> Floats:
        """Positions of all joints after, shape (number of joints,) [rad | m]."""
        segments = self.require()
        return segments[-1].end if segments else self.start

    @property
    def final_state(self) -> Mapping[str, float]:
        joints = self.final_scene.robot.joint_names
        return dict(zip(joints, map(float, self.final_positions), strict=True))

    @property
    def begins(self) -> Floats:
        """Begin of each motion, shape (number of motions,) [s]."""
        return readonly(np.cumsum([0.0, *(segment.duration for segment in self.require())])[:-1])

    @property
    def stages(self) -> tuple[StageTime, ...]:
        """Begin and end of each stage that moves or rests, in order."""
        return tuple(
            StageTime(segment.title, begin, begin + segment.duration)
            for segment, begin in zip(self.require(), self.begins.tolist(), strict=True)
        )

    @cached_property
    def trajectory(self) -> Trajectory:
        """The whole as one motion of all joints that move in it, rests included."""
        segments, robot = self._motions(), self.scene.robot
        moved = {name for segment in segments for name in segment.result.problem.reduced.joint_names}
        joints = tuple(name for name in robot.joint_names if name in moved)
        parts = [_of_joints(segment, joints) for segment in segments]
        whole = parts[0]
        for before, part in zip(segments, parts[1:], strict=False):
            whole = after_standing(whole, before.rest, part) if before.rest else whole.followed_by(part)
        return standing(whole, segments[-1].rest) if segments[-1].rest else whole

    @property
    def certificate(self) -> Certificate:
        """The checks of all motions, each in the scene of its time."""
        return joined(
            (segment.title, begin, segment.result.require().certificate)
            for segment, begin in zip(self._motions(), self.begins.tolist(), strict=True)
        )

    def _motions(self) -> tuple[Part, ...]:
        segments = self.require()
        if not segments:
            raise ProblemError(f"{shown(self.name)} has no motion: it has no trajectory and no certificate")
        return segments

    def as_dict(self) -> dict[str, object]:
        return {
            "name": self.name,
            "status": self.status.name,
            "verified": self.verified,
            "message": str(self.explain()),
            "stages": [vars(item) for item in (self.stages if self.verified else ())],
            "segments": [
                {"title": item.title, "rest": item.rest, **item.result.as_dict()} for item in self.segments
            ],
            "refusals": [item.as_dict() for item in self.refusals],
            "counts": dict(self.counts),
            "cpu_seconds": {**self.cpu_seconds, "total": sum(self.cpu_seconds.values())},
            "stopped": None if self.stopped is None else self.stopped.name,
        }

    @property
    def whole(self) -> tuple[ReducedModel, Trajectory]:
        return whole_robot(self.scene_on_tracks(), self.trajectory.joint_names, self.start), self.trajectory

    @checked
    def scene_on_tracks(self, loose: Sequence[str] = ()) -> Scene:
        """Return the scene before, with tracks for the objects that the sequence moves.

        Args:
            loose: Objects without a track.

        Raises:
            PlanningFailed: Without a verified plan.
        """
        segments, scene = self.require(), self.scene
        scenes = [
            (begin, segment, segment.result.problem.scene)
            for begin, segment in zip(self.begins.tolist(), segments, strict=True)
        ]
        for name in scene.objects:
            if name in loose or name in scene.changing or _stands(name, scenes):
                continue
            track = _track(name, scenes)
            if scene.holder(name).link != WORLD:
                scene = scene.detach(name, at=self.start)
            scene = scene.with_motion(name, track)
            for link in sorted({link for _, _, each in scenes for link in each.objects[name].touch_links}):
                scene = scene.allow(link, name)
        return scene


def _within(name: str, node: StageNode) -> bool:
    return f"{name}: ".startswith(f"{node.name}: ")


def _stands(name: str, scenes: Sequence[tuple[float, PlannedSegment, Scene]]) -> bool:
    places = [scene.placement_of(name, segment.positions(0.0)) for _, segment, scene in scenes]
    inside = all(scene.holder(name).link == WORLD for _, _, scene in scenes)
    return inside and all(np.array_equal(place.homogeneous, places[0].homogeneous) for place in places)


def _track(name: str, scenes: Sequence[tuple[float, PlannedSegment, Scene]]) -> Track:
    times, placements = list[float](), list[Placement]()
    for begin, segment, scene in scenes:
        held = scene.holder(name).link != WORLD
        count = max(2, int(segment.duration / SAMPLE)) if held else 2
        for time in np.linspace(0.0, segment.duration, count).tolist():
            if not times or begin + time > times[-1] + 1e-9:
                times.append(begin + time)
                placements.append(scene.placement_of(name, segment.positions(time)))
    return Track.through(times, placements)


def _of_joints(segment: PlannedSegment, joints: tuple[str, ...]) -> Trajectory:
    moving, reduced = segment.result.require().trajectory, segment.result.problem.reduced
    assert moving.velocities is not None
    assert moving.accelerations is not None
    columns = [joints.index(name) for name in moving.joint_names]
    still = reduced.all_positions(moving.positions[0])[reduced.scene.robot.index(joints)]
    positions = np.tile(still, (len(moving.times), 1))
    velocities, accelerations = np.zeros_like(positions), np.zeros_like(positions)
    positions[:, columns] = moving.positions
    velocities[:, columns], accelerations[:, columns] = moving.velocities, moving.accelerations
    return Trajectory(
        joints, moving.times, readonly(positions), readonly(velocities), readonly(accelerations)
    )
