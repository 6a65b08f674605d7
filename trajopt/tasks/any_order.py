"""Stages in any order: order and postures are searched together."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.geometry import WorkCounts, evaluator
from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.kinematics.validity import clear
from trajopt.planning.status import Status
from trajopt.problem.problem import Problem
from trajopt.robot.configuration import ConfigurationLike, stated_configuration
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.straight import to_configuration
from trajopt.tasks.search import Item, TaskSearch, TaskStage, TaskState, Way, as_items, choosing, in_sequence
from trajopt.tasks.sequence import StageRefusal
from trajopt.tasks.stages import Dwell, MoveTo, held_after_each
from trajopt.tasks.tour import Tours
from trajopt.timing.time_scaling import travel_time
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.errors import ProblemError, shown

POSTURES = 12
"""Most configurations of an item: an arm of six joints has eight branches, the rest are free turns about
the tool axis.
"""
ROUNDS = 6
"""Most searches for an order, each with more of the true times."""
STRIDE = 0.05
"""Distance of the configurations checked on the straight way between two postures [rad | m]."""
NO_WAY = 1e3
"""Cost of a way without a motion [s]: longer than any motion."""


@dataclass(frozen=True, eq=False)
class PlacedItem:
    """An item with a configuration for each of its moves.

    Attributes:
        moves: Configuration of the arm at the end of each move, shape (k, n).
        inside: Bound of the time from the first to the last [s].
    """

    moves: Floats
    inside: float


@dataclass(frozen=True, eq=False)
class AnyOrder(Value):
    """Items in the order, and in the postures, that take the least time.

    Each item begins with `MoveTo`, followed by more of these or `Dwell`.

    Attributes:
        then: Configuration to which the arm goes afterwards, for the choice of the order; anywhere if None.
    """

    items: Sequence[Item]
    name: str = ""
    then: ConfigurationLike | None = None
    default_name = "any order"

    def __post_init__(self) -> None:
        items = as_items(self.items)
        for number, item in enumerate(items, start=1):
            if not isinstance(item[0], MoveTo):
                raise ProblemError(
                    f"item {number} begins with {type(item[0]).__name__}: items in any order "
                    "begin with MoveTo"
                )
            for stage in item:
                if isinstance(stage, MoveTo) and stage.group:
                    raise ProblemError(f"item {number}: items in any order move the group of the task")
                if not isinstance(stage, MoveTo | Dwell):
                    raise ProblemError(
                        f"item {number} has a {type(stage).__name__}: items in any order "
                        "have MoveTo and Dwell only"
                    )
        object.__setattr__(self, "items", items)

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        self._end(scene, group)
        for _ in held_after_each(self.items, scene, group, held):
            pass
        return held

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        items = as_items(self.items)
        placed: list[list[PlacedItem]] = []
        for item in items:
            found = postures(item, search, state)
            if isinstance(found, StageRefusal):
                yield found
                return
            placed.append(found)
        reduced = search.reduced(state.scene, state.positions)
        rests = any(isinstance(stage, Dwell) for item in items for stage in item)
        end = self._end(state.scene, search.group)
        chosen = _Ordering(search, reduced, placed, rests, end).searched()
        order = [(n, "") for n, _ in chosen]
        pinned = [stage for n, at in chosen for stage in _pinned(items[n], at)]
        for stages in (pinned, [stage for n, _ in chosen for stage in items[n]]):
            yield from choosing(in_sequence(stages, search, state), self.name, order)

    def _end(self, scene: Scene, group: str) -> Floats | None:
        if self.then is None:
            return None
        robot = scene.robot
        return stated_configuration(robot, "then", self.then, group=group)[
            robot.index(robot.group(group).joints)
        ]


@dataclass(frozen=True, eq=False)
class _Pinned:
    move: MoveTo
    positions: Floats

    @property
    def name(self) -> str:
        return self.move.name

    @property
    def default_name(self) -> str:
        return self.move.default_name

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        return self.move.held_after(scene, group, held)

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        reduced = search.reduced(state.scene, state.positions)
        yield self.move.leg(state, reduced.all_positions(self.positions))


def _pinned(item: Sequence[TaskStage], placed: PlacedItem) -> Iterator[TaskStage]:
    rows = iter(placed.moves)
    for stage in item:
        yield _Pinned(stage, readonly(next(rows))) if isinstance(stage, MoveTo) else stage


def postures(
    item: Sequence[TaskStage], search: TaskSearch, state: TaskState
) -> list[PlacedItem] | StageRefusal:
    """Return the postures of an item: a configuration for each of its moves."""
    reduced = search.reduced(state.scene, state.positions)
    moves = [stage for stage in item if isinstance(stage, MoveTo)]
    first = moves[0]
    found = search.configurations(reduced, first.wanted(state.scene, search.group), first.name)
    if isinstance(found, StageRefusal):
        return found
    rows = np.array(found[:POSTURES])[:, None]
    counts = WorkCounts()
    query = evaluator(reduced, counts)
    for move in moves[1:]:
        goals = move.wanted(state.scene, search.group)
        projected = Projection(reduced, goals, query)(rows[:, -1])
        met = (projected.violation == 0.0) & clear(query, projected.positions, reduced.pairs.required)
        if not met.any():
            search.tracker.count_work(counts)
            near = f"no free configuration was found near those of {shown(moves[0].name)}"
            return StageRefusal(move.name, Status.NO_INVERSE_KINEMATICS, near)
        rows = np.concatenate((rows, projected.positions[:, None]), axis=1)[met]
    search.tracker.count_work(counts)
    limits = reduced.limits
    return [PlacedItem(row, float(travel_time(row[:-1], row[1:], limits, rests=True).sum())) for row in rows]


@dataclass(frozen=True, eq=False)
class _Ordering:
    """Search for the order and the postures of items; the arm ends anywhere if `end` is None."""

    search: TaskSearch
    reduced: ReducedModel
    placed: list[list[PlacedItem]]
    rests: bool
    end: Floats | None

    def searched(self) -> list[tuple[int, PlacedItem]]:
        """Bound the times between items; plan the best order's ways that are not free, and repeat."""
        nodes = [(group, item) for group, items in enumerate(self.placed) for item in items]
        groups = np.array([group for group, _ in nodes])
        entries = np.array([item.moves[0] for _, item in nodes])
        exits = np.array([item.moves[-1] for _, item in nodes])
        inside = np.array([item.inside for _, item in nodes])
        begin = self.reduced.start_positions
        start = self._time(begin, entries) + inside
        between = self._time(exits[:, None], entries[None]) + inside
        end = np.zeros(len(nodes)) if self.end is None else self._time(exits, self.end)
        tours = Tours(groups, start, between, end)
        known: set[tuple[int, int]] = set()
        tour = tours.shortest(self.search.rng)
        for _ in range(ROUNDS):
            ways = [
                way for way in zip(tour[:-1].tolist(), tour[1:].tolist(), strict=True) if way not in known
            ]
            known.update(ways)
            blocked = [
                way for way, free in zip(ways, self._free(exits, entries, ways), strict=True) if not free
            ]
            if not blocked:
                break
            for before, after in blocked:
                between[before, after] = self._planned(exits[before], entries[after]) + inside[after]
            tour = tours.shortest(self.search.rng)
        return [nodes[node] for node in tour]

    def _time(self, start: Floats, end: Floats) -> Floats:
        return travel_time(start, end, self.reduced.limits, rests=self.rests)

    def _free(self, exits: Floats, entries: Floats, ways: Sequence[tuple[int, int]]) -> list[bool]:
        counts = WorkCounts()
        query = evaluator(self.reduced, counts)
        free: list[bool] = []
        for before, after in ways:
            far = float(np.abs(entries[after] - exits[before]).max())
            shares = np.linspace(0.0, 1.0, 2 + int(far / STRIDE))[:, None]
            rows = exits[before] + shares * (entries[after] - exits[before])
            free.append(bool(clear(query, rows, self.reduced.pairs.required).all()))
            self.search.tracker.check(counts)
        self.search.tracker.count_work(counts)
        return free

    def _planned(self, start: Floats, end: Floats) -> float:
        reduced, search = self.reduced, self.search
        goal = to_configuration(reduced.scene, search.group, reduced.all_positions(end))
        problem = Problem(
            scene=reduced.scene,
            group=search.group,
            start=reduced.all_positions(start),
            goal=goal,
            constraints=search.constraints,
            velocity_scaling=search.options.velocity_scaling,
            acceleration_scaling=search.options.acceleration_scaling,
            tool_speed=search.options.tool_speed,
        )
        result = search.plan(problem)
        return result.require().trajectory.duration if result.verified else NO_WAY
