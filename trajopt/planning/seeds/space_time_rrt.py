"""RRT-Connect over configurations and times, among dynamic obstacles.

Sources: Kuffner and LaValle, ICRA 2000; Grothe, Hartmann, Orthey and Toussaint, ICRA 2022 (space-time).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil

import numpy as np

from trajopt.geometry import DynamicObstacles
from trajopt.optimise.kinematics.projection import turning_joints
from trajopt.optimise.transcription.space_time import ObstacleMargins
from trajopt.planning.seeds.sampled import STEP, SURE, TURN
from trajopt.robot.joints import JointLimits
from trajopt.values.arrays import Bools, Floats, Printed
from trajopt.values.trajectory import Trajectory

SPEED = 0.7
"""Share of the velocity limits that branches use; the rest is for accelerations."""
PARTS = 12
"""Fewest branches of a path: to pass several obstacles it needs corners."""
NUDGE = 0.1
"""Joint motion for which the travel of bodies is measured [rad | m]."""
MOMENTS = 400
"""Times at which the travel of obstacles is sampled."""
INTERVAL = 0.02
"""Sampling interval of a goal that is seldom free [s]: at 1 m/s obstacles move by 2 cm."""
ROOTS = 8
"""Goal times in the second tree at first, and branches between two further ones."""
SHORTCUTS = 40


class Exhausted(Exception):
    """The budget of configuration checks is used up."""


@dataclass(eq=False)
class SpaceTimeProblem(Printed):
    """The problem of a search in space and time.

    Attributes:
        start: At time 0, shape (n,) [rad | m].
        latest: Latest end [s].
        dwell: Time at rest at the end [s].
        check: Called between pieces of work; may raise to stop.
    """

    margins: ObstacleMargins
    limits: JointLimits
    start: Floats
    goal: Floats
    latest: float
    dwell: float
    checks: int
    check: Callable[[], None]

    def least(self, change: Floats) -> Floats:
        """Return the least times of changes of position, shape (..., n) -> (...) [s]."""
        return (np.abs(change) / (SPEED * self.limits.velocity)).max(axis=-1)

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        low, high = np.minimum(self.start, self.goal), np.maximum(self.start, self.goal)
        turning = turning_joints(self._obstacles.timed.reduced)[: len(low)]
        # A sliding joint may go as far as it can and still reach the goal in time.
        spare = SPEED * self.limits.velocity * self.latest - (high - low)
        beyond = np.where(turning, TURN, np.maximum(spare, 0.0) / 2.0)
        lowest, highest = (
            np.maximum(low - beyond, self.limits.lower),
            np.minimum(high + beyond, self.limits.upper),
        )
        return np.minimum(lowest, low), np.maximum(highest, high)

    @cached_property
    def kept(self) -> Floats:
        """Distance that each pair keeps, no more than at the ends, but for errors, shape (p,) [m]."""
        pairs, known = self._obstacles.timed.reduced.pairs, self._obstacles.pairs
        kept = np.where(known.changes, known.required, (pairs.required + pairs.margin) / 2.0)
        ends = self._obstacles.timed.positions(np.stack((self.start, self.goal)), np.zeros(2))
        found = self._obstacles.query.close_pairs(ends, kept)
        touching = (found.sample == 0) | ~known.changes[found.pair]
        np.minimum.at(kept, found.pair[touching], found.distance[touching] - SURE)
        return kept

    @property
    def _obstacles(self) -> DynamicObstacles:
        return self.margins.rows

    def spend(self, count: int) -> None:
        self.check()
        self.checks -= count
        if self.checks < 0:
            raise Exhausted

    def free(self, states: Floats) -> int:
        clear = self.clear(states)
        return len(clear) if clear.all() else int(np.argmin(clear))

    def clear(self, states: Floats) -> Bools:
        """Return the mask of free states (s, n + 1), of positions and time [s]."""
        self.spend(len(states))
        return self._obstacles.clear(states[:, :-1], states[:, -1], self.kept, until=self.latest)

    def looks(self, first: Floats, last: Floats) -> Floats:
        """Return the states of a straight branch checked, but for its first, shape (s, n + 1).

        Between two of them robot and obstacles approach by about a step at most.
        """
        change = np.abs(last - first)
        swept = float(change[:-1] @ self._rates + change[-1] * self._speed)
        count = max(ceil(swept / STEP), 1)
        states = first + (last - first) * (np.arange(1, count + 1) / count)[:, None]
        states[-1] = last
        return states

    @cached_property
    def _rates(self) -> Floats:
        """Travel of bodies by each joint at the start, approximately, shape (n,) [m/rad | 1]."""
        nudge = NUDGE * np.eye(len(self.start))
        timed, begin = self._obstacles.timed, np.zeros(len(nudge))
        first = timed.positions(np.tile(self.start, (len(nudge), 1)), begin)
        return self._obstacles.query.displacement(first, timed.positions(self.start + nudge, begin)) / NUDGE

    @cached_property
    def _speed(self) -> float:
        """Bound of the speed of obstacles plus the growth of their errors [m/s]."""
        times = np.linspace(0.0, self.latest, MOMENTS)
        moved = float(self._obstacles.moved(np.tile(self.start, (MOMENTS, 1)), times).max())
        begin, end = (self._obstacles.pairs.error_at(time, slice(None)) for time in (0.0, self.latest))
        radii = end - begin
        return (moved * (MOMENTS - 1) + float(radii.max(initial=0.0))) / self.latest


@dataclass(eq=False)
class _Tree:
    """Tree of states that are reachable from its roots, or from which these are reachable.

    Attributes:
        side: 1 for a tree forward in time, -1 for one backward.
        parents: The state before each; -1 of a root.
    """

    stage: SpaceTimeProblem
    side: float
    states: Floats
    parents: list[int] = field(default_factory=list[int])

    def add(self, state: Floats, parent: int) -> int:
        self.states = np.vstack((self.states, state))
        self.parents.append(parent)
        return len(self.parents) - 1

    def nearest(self, state: Floats) -> int:
        change = state - self.states
        ahead, least = self.side * change[:, -1], self.stage.least(change[:, :-1])
        costs = np.where((ahead > 0.0) & (least <= ahead), ahead + least, np.inf)
        best = int(np.argmin(costs))
        return best if np.isfinite(costs[best]) else -1

    def extended(self, parent: int, towards: Floats) -> int:
        """Grow a branch from a state towards another as far as it is free; return its end, -1 if nowhere."""
        first = self.states[parent]
        share = self.stage.latest / (PARTS * abs(float(towards[-1] - first[-1])))
        looks = self.stage.looks(first, towards if share >= 1.0 else first + share * (towards - first))
        free = self.stage.free(looks)
        return self.add(looks[free - 1], parent) if free else -1

    def way(self, number: int) -> Floats:
        found: list[int] = []
        while number >= 0:
            found.append(number)
            number = self.parents[number]
        return self.states[found[::-1]]


def searched(stage: SpaceTimeProblem, names: tuple[str, ...], rng: np.random.Generator) -> Trajectory | None:
    """Return a motion of constant speeds through space and time, if one is found."""
    first = np.append(stage.start, 0.0)
    forward = _Tree(stage, 1.0, np.empty((0, len(first))))
    backward = _Tree(stage, -1.0, np.empty((0, len(first))))
    forward.add(first, -1)
    soonest = float(stage.least(stage.goal - stage.start))
    if stage.latest < soonest:
        return None
    try:
        for time in np.linspace(soonest, stage.latest, ROOTS).tolist():
            _rooted(backward, time)
        if not len(backward.states) and not _rooted_seldom(backward, soonest):
            return None
        states = _connected(forward, backward, soonest, rng)
        states = _shortened(states, stage, rng)
    except Exhausted:
        return None
    return Trajectory(names, states[:, -1], states[:, :-1])


def _rooted(tree: _Tree, time: float) -> None:
    stage, root = tree.stage, np.append(tree.stage.goal, time)
    stays = stage.margins.spare_staying(stage.goal, time, stage.dwell)
    if (stays >= 0.0).all() and stage.free(root[None]) == 1:
        tree.add(root, -1)


def _rooted_seldom(tree: _Tree, soonest: float) -> bool:
    stage = tree.stage
    times: Floats = np.append(np.arange(soonest, stage.latest, INTERVAL), stage.latest)
    states = np.column_stack((np.tile(stage.goal, (len(times), 1)), times))
    for time in times[stage.clear(states)].tolist():
        if len(tree.states) < ROOTS:
            _rooted(tree, time)
    return len(tree.states) > 0


def _connected(forward: _Tree, backward: _Tree, soonest: float, rng: np.random.Generator) -> Floats:
    stage, turn = forward.stage, 0
    while True:
        turn += 1
        stage.spend(1)
        if turn % ROOTS == 0:
            _rooted(backward, float(rng.uniform(soonest, stage.latest)))
            continue
        grown, other = (forward, backward) if turn % 2 else (backward, forward)
        target = _sample(stage, rng)
        near = -1 if target is None else grown.nearest(target)
        new = -1 if target is None or near < 0 else grown.extended(near, target)
        met = -1 if new < 0 else _met(other, grown.states[new])
        if met >= 0:
            there, back = (new, met) if grown is forward else (met, new)
            return np.vstack((forward.way(there), backward.way(back)[-2::-1]))


def _sample(stage: SpaceTimeProblem, rng: np.random.Generator) -> Floats | None:
    positions = rng.uniform(*stage.box)
    sooner, later = stage.least(positions - stage.start), stage.latest - stage.least(stage.goal - positions)
    return None if later < sooner else np.append(positions, rng.uniform(sooner, later))


def _met(tree: _Tree, state: Floats) -> int:
    """Grow a tree towards a state; return the state if it is reached, else -1."""
    near = tree.nearest(state)
    while near >= 0:
        near = tree.extended(near, state)
        if near >= 0 and tree.states[near, -1] == state[-1]:
            return near
    return -1


def _shortened(states: Floats, stage: SpaceTimeProblem, rng: np.random.Generator) -> Floats:
    for _ in range(SHORTCUTS):
        begin, end = np.sort(rng.uniform(0.0, states[-1, -1], 2))
        ends = _between(states, np.array((begin, end)))
        looks = stage.looks(*ends)
        if stage.least(ends[1, :-1] - ends[0, :-1]) <= end - begin and stage.free(looks) == len(looks):
            outside = (states[:, -1] < begin), (states[:, -1] > end)
            states = np.vstack((states[outside[0]], ends, states[outside[1]]))
    return states


def _between(states: Floats, times: Floats) -> Floats:
    found = np.empty((len(times), states.shape[1]))
    for column in range(states.shape[1]):
        found[:, column] = np.interp(times, states[:, -1], states[:, column])
    return found
