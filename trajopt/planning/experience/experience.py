"""Experience: motions that were planned, remembered for problems much like theirs."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from threading import RLock

import numpy as np
from numpy.typing import ArrayLike

from trajopt.planning.experience.likeness import Likeness, likeness, scenes_apart
from trajopt.planning.experience.storage import InProcessStorage, Memory, Storage
from trajopt.planning.plan_arguments import Recalled
from trajopt.planning.result import Result
from trajopt.planning.seeds import SeedKind
from trajopt.planning.seeds.source import with_knots
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, floats
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.errors.arguments import checked

FAR = 0.3
"""How far a problem may be from one that is remembered: the largest difference of a joint at the start
[rad | m], plus that of a number of the goal, plus how far apart the objects are in the mean [m]. A metre
counts as a radian: by that an arm of a metre moves its hand as far. Three tenths of it are more than an arm
is wide: what was free before tells little then."""
ANEW = FAR / 2.0
"""A motion from a memory nearer than this is not remembered beside it: that one will do again."""
FORGIVEN = 3
"""A memory that failed so often in a row is forgotten: what stands in its way now is no accident."""
LOOKED_AT = 8
"""So many memories, nearest in start and goal, have their scenes compared."""


@dataclass(frozen=True)
class _Group:
    """Memories that are comparable, stacked: they are looked through with each plan."""

    numbers: Sequence[int]
    starts: Floats
    goals: Floats
    scenes: Sequence[Floats]


@checked
@dataclass(eq=False)
class Experience:
    """Remembers motions, and what came of remembering them: `plan(problem, experience=experience)`.

    Of a problem in a still world that begins at rest, without waypoints, the most similar one that was
    solved is looked up, and its path tried first. What is found from it is judged like any other motion; if
    nothing is, the usual tries follow. Threads and, with a warehouse, processes may share one.

    Attributes:
        storage: Where it is kept; in this process alone unless stated. `Warehouse.experience` keeps it in a
            file.
        most: Memories at most; then what has not won for longest is forgotten.
        learning: Whether it changes; without, equal calls have equal answers.
    """

    storage: Storage = field(default_factory=InProcessStorage)
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
        """Return how many motions are remembered."""
        with self._lock:
            self._look()
            return len(self._known)

    @property
    def version(self) -> int:
        """How often it has changed."""
        return self.storage.version

    @checked
    def recall(self, problem: Problem) -> Recalled:
        """Return the path of the motion that solved the most similar problem, if one is similar enough."""
        with self._lock:
            self._look()
            near = _nearest(self._groups, problem) if comparable(problem) else None
            if near is None:
                return Recalled(self._version)
            return Recalled(self._version, (near[1],), (self._known[near[1]].knots,))

    @checked
    def learn(self, problem: Problem, result: Result, recalled: Recalled, given: int = 0) -> None:
        """Remember a motion, and whether what was recalled has led to it; see `Remembers.learn`."""
        if not self.learning or not comparable(problem):
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

    @checked
    def remember(self, problem: Problem, path: ArrayLike) -> bool:
        """Remember a path that solved a problem elsewhere, unless a problem this near is remembered already.

        Args:
            problem: What it solved, with one goal.
            path: Points from start to end, shape (k, n) with k at least 2 [rad | m].

        Returns:
            Whether it is remembered now; it is not where `learning` is off, either, or where motions of such
            problems are never remembered.

        Raises:
            ShapeError: If the path is not one of the group's joints.
        """
        points = floats("path", path, (None, len(problem.reduced.joint_names)))
        if len(points) < 2:
            raise ShapeError("path", f"must have at least 2 points, has {len(points)}")
        if not self.learning or not comparable(problem):
            return False
        with self._lock:
            self._look()
            near = _nearest(self._groups, problem)
            if near is not None and near[0] <= ANEW:
                return False
            new = _memory(problem, with_knots(points, problem.knots))
            self._change(new, (), self._in_excess(()))
            return True

    def _in_excess(self, kept: Collection[int], gone: Sequence[int] = ()) -> Sequence[int]:
        """Return the number of the memory that one more takes the place of, where there is no room.

        Args:
            kept: Memories that stay.
            gone: Those that go anyway.
        """
        if len(self._known) - len(gone) < self.most:
            return ()
        left = [each for number, each in self._known.items() if number not in (*gone, *kept)]
        return [min(left, key=lambda each: (each.used, each.number)).number] if left else ()

    def _change(self, new: Memory | None, after: Sequence[Memory], gone: Sequence[int]) -> None:
        """Change what is kept; if nobody else did meanwhile, what is known here needs no reading anew."""
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
        """Return the motion of a result as a memory, if it is worth one."""
        if not result.verified or result.path is None or not comparable(result.problem):
            return None
        if won:
            near = _nearest(self._groups, result.problem)
            if near is not None and near[0] <= ANEW:
                return None
        return _memory(result.problem, result.path.knots)

    def _look(self) -> None:
        """Read the memories where another thread or process has changed them."""
        version = self.storage.version
        if version == self._version:
            return
        self._known = dict(self.storage.all())
        self._groups = {}
        self._stack({memory.key for memory in self._known.values()})
        self._version = version

    def _stack(self, keys: Collection[str]) -> None:
        """Stack the memories of some keys anew."""
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
    """Return a path as a memory that has no number yet."""
    like = likeness(problem)
    return Memory(number=0, key=like.key, start=like.start, goal=like.goal, scene=like.scene, knots=knots)


def _after(memory: Memory, *, won: bool, version: int) -> Memory:
    """Return a memory after it was tried once more."""
    if won:
        return replace(memory, wins=memory.wins + 1, failures=0, used=version)
    return replace(memory, failures=memory.failures + 1)


def comparable(problem: Problem) -> bool:
    """Say whether a problem is one that motions are remembered of."""
    return not problem.waypoints and not problem.scene.changing and not problem.starts_moving


def _nearest(groups: Mapping[str, _Group], problem: Problem) -> tuple[float, int] | None:
    """Return how far the nearest memory is, and its number; None where none is near enough."""
    found = list[tuple[float, int]]()
    for alone in (problem.alternatives or {"": problem}).values():
        like = likeness(alone)
        group = groups.get(like.key)
        if group is not None:
            found += _near(group, like)
    return min(found, default=None)


def _near(group: _Group, like: Likeness) -> list[tuple[float, int]]:
    """Return how far memories of a group are that are near enough, and their numbers."""
    apart = _largest(group.starts - like.start) + _largest(group.goals - like.goal)
    first = [int(place) for place in np.argsort(apart, kind="stable")[:LOOKED_AT] if apart[place] <= FAR]
    whole = [
        (float(apart[place]) + scenes_apart(group.scenes[place], like.scene), group.numbers[place])
        for place in first
    ]
    return [each for each in whole if each[0] <= FAR]


def _largest(rows: Floats) -> Floats:
    """Return the largest size in each row; 0 where rows are empty."""
    return np.abs(rows).max(axis=1, initial=0.0)


def _won(result: Result, place: int, paths: int) -> bool | None:
    """Say whether the motion came from a path that was tried first; None where that was not attempted.

    Args:
        result: What planning answered.
        place: The place of the path among those.
        paths: How many they were.
    """
    of_it = [
        each for each in result.attempts if each.kind is SeedKind.GIVEN and (each.number - 1) % paths == place
    ]
    if not of_it:
        return None
    return result.won is not None and any(each.number == result.won.number for each in of_it)
