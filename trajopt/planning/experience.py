"""Experience: remembered motions for similar problems."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum
from hashlib import sha256
from math import isfinite
from threading import RLock
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike

from trajopt.planning.result import Recalled, Result
from trajopt.planning.seeds import SeedKind
from trajopt.planning.seeds.source import with_knots
from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, floats, readonly
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.errors.arguments import checked_class
from trajopt.values.placement import WORLD
from trajopt.values.shapes.shapes import bounding_box

FARTHEST = 10.0
"""Extent to which walls and floors are cut: beyond the reach of arms it distinguishes no motions [m]."""
UNLIKE = 1.0
"""Displacement that an object without a counterpart counts as: the reach of an arm [m]."""


@dataclass(frozen=True)
class _Likeness:
    """Data by which a problem is compared; fields as in `Memory`."""

    key: str
    start: Floats
    goal: Floats
    scene: Floats


def _likeness(problem: Problem) -> _Likeness:
    """Return the data by which a problem with one goal is compared."""
    reduced = problem.reduced
    numbers, words = list[float](), list[str]()
    for part in _parts(problem.goals):
        (numbers if isinstance(part, float) else words).append(part)  # pyright: ignore[reportArgumentType]
    kinds = [part for part in _parts(problem.constraints) if isinstance(part, str)]
    carried = sorted(
        f"{name} on {holder}"
        for name in problem.scene.objects
        if (holder := problem.scene.holder(name).link) != WORLD
    )
    robot = (problem.scene.robot.name, *reduced.joint_names)
    whole = "\n".join((*robot, "goal", *words, "constraints", *kinds, "carried", *carried))
    return _Likeness(
        sha256(whole.encode()).hexdigest(),
        reduced.start_positions,
        readonly(np.array(numbers)),
        _scene_signature(problem.scene),
    )


def _scene_signature(scene: Scene) -> Floats:
    """Return centre and half edges of the box around each object of the world, shape (objects, 6) [m].

    Names do not matter, so that a camera may rename its detections.
    """
    rows = list[Floats]()
    for name, item in scene.objects.items():
        holder = scene.holder(name)
        if holder.link != WORLD or not item.parts:
            continue
        lower, upper = np.full(3, np.inf), np.full(3, -np.inf)
        for shape, where in item.parts:
            low, high = (np.clip(corner, -FARTHEST, FARTHEST) for corner in bounding_box(shape))
            at = holder.placement * where
            centre = at.rotation @ ((low + high) / 2.0) + at.translation
            half = np.abs(at.rotation) @ ((high - low) / 2.0)
            lower, upper = np.minimum(lower, centre - half), np.maximum(upper, centre + half)
        rows.append(np.concatenate(((lower + upper) / 2.0, (upper - lower) / 2.0)))
    return readonly(np.array(rows).reshape(-1, 6))


def _scenes_apart(first: Floats, second: Floats) -> float:
    """Return the mean distance of the objects of two scenes, each from the most similar one [m]."""
    count = len(first) + len(second)
    if not count:
        return 0.0
    if not len(first) or not len(second):
        return UNLIKE
    apart = np.minimum(np.linalg.norm(first[:, None] - second[None], axis=2), UNLIKE)
    return float(apart.min(axis=1).sum() + apart.min(axis=0).sum()) / count


def _parts(value: object) -> Iterator[str | float]:
    match value:
        case bool() | None | str():
            yield repr(value)
        case int() | float() | np.integer() | np.floating():
            yield float(value) if isfinite(value) else str(value)
        case Enum():
            yield value.name
        case np.ndarray():
            yield f"array {value.shape}"
            yield from _parts(cast("list[Any]", value.tolist()))
        case Mapping():
            for key, each in cast("Mapping[object, object]", value).items():
                yield str(key)
                yield from _parts(each)
        case _:
            yield type(value).__qualname__
            for each in _members(value):
                yield from _parts(each)


def _members(value: object) -> Sequence[object]:
    if isinstance(value, Sequence):
        members = cast("Sequence[object]", value)
        return (f"{len(members)} of", *members)
    return [getattr(value, item.name) for item in fields(value)] if is_dataclass(value) else ()


@dataclass(frozen=True, eq=False, kw_only=True)
class Memory(Value):
    """A motion that solved a problem, and its record of success.

    Attributes:
        number: Never given again.
        key: Must be equal for another problem: robot, group, and the kinds of the requirements.
        start: Shape (n,) [rad | m].
        goal: The numbers of the goal: positions, placements, tolerances, shape (g,).
        scene: Centre and half edges of the box around each object, shape (objects, 6) [m].
        knots: The path, shape (k, n) [rad | m].
        failures: Failures since its last win.
    """

    number: int
    key: str
    start: Floats
    goal: Floats
    scene: Floats
    knots: Floats
    wins: int = 0
    failures: int = 0
    used: int = 0


class Storage(Protocol):
    """Storage of memories; `trajopt.server.warehouse.Warehouse` has one in its file."""

    @property
    def version(self) -> int:
        """Number of its changes."""
        ...

    def all(self) -> Mapping[int, Memory]:
        """Return all memories by number."""
        ...

    def change(
        self, *, new: Memory | None = None, changed: Iterable[Memory] = (), gone: Iterable[int] = ()
    ) -> tuple[int, Memory | None]:
        """Add, change and remove memories in one step.

        Args:
            new: One to add; it gets the next number.

        Returns:
            The version afterwards, and the new memory with its number.
        """
        ...


class _InProcessStorage:
    """Memories that end with the process."""

    def __init__(self) -> None:
        self._memories: dict[int, Memory] = {}
        self._version, self._last = 0, 0

    @property
    def version(self) -> int:
        return self._version

    def all(self) -> Mapping[int, Memory]:
        return dict(self._memories)

    def change(
        self, *, new: Memory | None = None, changed: Iterable[Memory] = (), gone: Iterable[int] = ()
    ) -> tuple[int, Memory | None]:
        self._version += 1
        for each in changed:
            if each.number in self._memories:
                self._memories[each.number] = each
        for number in gone:
            self._memories.pop(number, None)
        if new is not None:
            self._last += 1
            new = replace(new, number=self._last, used=self._version)
            self._memories[self._last] = new
        return self._version, new


FAR = 0.3
"""Largest distance of a problem from a remembered one: the largest difference of a joint at the start [rad
| m], plus that of a number of the goal, plus the mean distance of the objects [m]. A metre counts as a
radian.
"""
SAME = FAR / 2.0
"""A motion from a nearer memory is not remembered: that memory suffices."""
FORGIVEN = 3
"""Consecutive failures after which a memory is forgotten: the obstacle in its way is permanent."""
COMPARED = 8
"""Memories, nearest in start and goal, whose scenes are compared."""


@dataclass(frozen=True)
class _Group:
    """Memories that are comparable, stacked: they are looked through with each plan."""

    numbers: Sequence[int]
    starts: Floats
    goals: Floats
    scenes: Sequence[Floats]


@checked_class
@dataclass(eq=False)
class Experience:
    """Remembers motions and their successes: `plan(problem, experience=experience)`.

    For a problem in a static scene that begins at rest, without waypoints, the path of the most similar
    solved problem is tried first. Threads may share one, with a warehouse processes too.

    Attributes:
        storage: This process alone by default. `Warehouse.experience` keeps memories in a file.
        most: Most memories; the one with the oldest success is forgotten first.
        learning: Whether it changes; if not, equal calls have equal answers.
    """

    storage: Storage = field(default_factory=_InProcessStorage)
    most: int = 1000
    learning: bool = True
    _known: dict[int, Memory] = field(init=False, repr=False, default_factory=dict[int, Memory])
    _groups: dict[str, _Group] = field(init=False, repr=False, default_factory=dict[str, _Group])
    _version: int = field(init=False, repr=False, default=-1)
    _lock: RLock = field(init=False, repr=False, default_factory=RLock)

    def __post_init__(self) -> None:
        """Check the bound.

        Raises:
            ProblemError: If nothing could be remembered.
        """
        if self.most < 1:
            raise ProblemError(f"most must be at least 1, is {self.most}")

    def __len__(self) -> int:
        with self._lock:
            self._look()
            return len(self._known)

    @property
    def version(self) -> int:
        return self.storage.version

    def recall(self, problem: Problem) -> Recalled:
        """Return paths to try first for a problem."""
        with self._lock:
            self._look()
            near = _nearest(self._groups, problem) if _comparable(problem) else None
            if near is None:
                return Recalled(self._version)
            return Recalled(self._version, (near[1],), (self._known[near[1]].knots,))

    def learn(self, problem: Problem, result: Result, recalled: Recalled, given: int = 0) -> None:
        """Remember a motion, and whether the recalled path has led to it.

        Args:
            given: Number of seeds that were tried before the recalled path.
        """
        if not self.learning or not _comparable(problem):
            return
        with self._lock:
            self._look()
            tried = {
                number: won
                for place, number in enumerate(recalled.memories, start=given)
                if number in self._known
                and (won := _won(result, place, given + len(recalled.memories))) is not None
            }
            after = [
                _after(self._known[number], won=won, version=self._version + 1)
                for number, won in tried.items()
            ]
            gone = [each.number for each in after if each.failures >= FORGIVEN]
            new = self._new(result, won=any(tried.values()))
            if new is not None:
                gone += self._in_excess(tried, gone)
            if new is not None or after:
                self._change(new, after, gone)

    def remember(self, problem: Problem, path: ArrayLike) -> bool:
        """Remember a path that solved a problem elsewhere, unless a similar problem is remembered already.

        Args:
            problem: With one goal.
            path: Points from start to end, shape (k, n) with k at least 2 [rad | m].

        Returns:
            Whether it is remembered now.

        Raises:
            ShapeError: If the path does not fit the group's joints.
        """
        points = floats("path", path, (None, len(problem.reduced.joint_names)))
        if len(points) < 2:
            raise ShapeError("path", f"must have at least 2 points, has {len(points)}")
        if not self.learning or not _comparable(problem):
            return False
        with self._lock:
            self._look()
            near = _nearest(self._groups, problem)
            if near is not None and near[0] <= SAME:
                return False
            new = _memory(problem, with_knots(points, problem.knots))
            self._change(new, (), self._in_excess(()))
            return True

    def _in_excess(self, kept: Collection[int], gone: Sequence[int] = ()) -> Sequence[int]:
        if len(self._known) - len(gone) < self.most:
            return ()
        left = [each for number, each in self._known.items() if number not in (*gone, *kept)]
        return [min(left, key=lambda each: (each.used, each.number)).number] if left else ()

    def _change(self, new: Memory | None, after: Sequence[Memory], gone: Sequence[int]) -> None:
        version, learnt = self.storage.change(new=new, changed=after, gone=gone)
        if version != self._version + 1:
            return
        self._version = version
        self._known |= {each.number: each for each in after}
        altered = {self._known.pop(number).key for number in gone}
        if learnt is not None:
            self._known[learnt.number] = learnt
            altered.add(learnt.key)
        self._stack(altered)

    def _new(self, result: Result, *, won: bool) -> Memory | None:
        if not result.verified or result.path is None or not _comparable(result.problem):
            return None
        if won:
            near = _nearest(self._groups, result.problem)
            if near is not None and near[0] <= SAME:
                return None
        return _memory(result.problem, result.path.knots)

    def _look(self) -> None:
        version = self.storage.version
        if version == self._version:
            return
        self._known = dict(self.storage.all())
        self._groups = {}
        self._stack({memory.key for memory in self._known.values()})
        self._version = version

    def _stack(self, keys: Collection[str]) -> None:
        by_key: dict[str, list[Memory]] = {key: [] for key in keys}
        for memory in self._known.values():
            if memory.key in by_key:
                by_key[memory.key].append(memory)
        for key, each in by_key.items():
            self._groups.pop(key, None)
            if each:
                numbers = [one.number for one in each]
                starts, goals = np.stack([one.start for one in each]), np.stack([one.goal for one in each])
                self._groups[key] = _Group(numbers, starts, goals, [one.scene for one in each])


def _memory(problem: Problem, knots: Floats) -> Memory:
    like = _likeness(problem)
    return Memory(number=0, key=like.key, start=like.start, goal=like.goal, scene=like.scene, knots=knots)


def _after(memory: Memory, *, won: bool, version: int) -> Memory:
    if won:
        return replace(memory, wins=memory.wins + 1, failures=0, used=version)
    return replace(memory, failures=memory.failures + 1)


def _comparable(problem: Problem) -> bool:
    return not problem.waypoints and not problem.scene.changing and not problem.starts_moving


def _nearest(groups: Mapping[str, _Group], problem: Problem) -> tuple[float, int] | None:
    found = list[tuple[float, int]]()
    for alone in (problem.alternatives or {"": problem}).values():
        like = _likeness(alone)
        group = groups.get(like.key)
        if group is not None:
            found += _near(group, like)
    return min(found, default=None)


def _near(group: _Group, like: _Likeness) -> list[tuple[float, int]]:
    apart = _largest(group.starts - like.start) + _largest(group.goals - like.goal)
    first = [int(place) for place in np.argsort(apart, kind="stable")[:COMPARED] if apart[place] <= FAR]
    whole = [
        (float(apart[place]) + _scenes_apart(group.scenes[place], like.scene), group.numbers[place])
        for place in first
    ]
    return [each for each in whole if each[0] <= FAR]


def _largest(rows: Floats) -> Floats:
    return np.abs(rows).max(axis=1, initial=0.0)


def _won(result: Result, place: int, paths: int) -> bool | None:
    of_it = [
        each for each in result.attempts if each.kind is SeedKind.GIVEN and (each.number - 1) % paths == place
    ]
    if not of_it:
        return None
    return result.won is not None and any(each.number == result.won.number for each in of_it)
