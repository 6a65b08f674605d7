"""RRT-Connect of OMPL between two configurations, with the query as what tells free from not.

Source: Kuffner and LaValle, ICRA 2000; Sucan, Moll and Kavraki, IEEE RAM 2012.
"""

from typing import cast

import numpy as np
from ompl import base, geometric, util

from trajopt.arrays import Floats
from trajopt.planning.seeds.source import Check, NoSeed
from trajopt.query import Query

SHORTENED = 20_000
"""Configurations that shortening may look at."""
STEP = 0.03
"""Between two configurations that are looked at no body moves farther [m]."""
KEPT = 0.5
"""Part of each pair's margin that is kept, above what is required."""
TURN = np.pi
"""No joint is searched farther beyond its start and goal, whatever its limits [rad | m]."""
RANGE = 1.0
"""Longest branch of the trees, in ordinary steps of the joints."""
FIRST_LOOK = 8
"""A line is looked at in as many places first: most lines that touch touch there."""
SURE = 1e-8
"""Bodies may come so much nearer than at the start and goal: no place is measured twice the same [m]."""
IDLE = 100
"""OMPL is stopped when it asked so often whether to stop and looked at no configuration in between: it
waits for something that will not come, 10 ms each time, or draws the same configuration over and over."""


def search(
    query: Query,
    start: Floats,
    goal: Floats,
    *,
    scale: Floats,
    rng: np.random.Generator,
    check: Check,
    checked: int,
) -> Floats:
    """Return the corners of a path that is clear of everything.

    Args:
        query: Of the robot and its surroundings.
        start: Where it begins, shape (n,) [rad | m].
        goal: Where it ends, shape (n,).
        scale: A step of ordinary size in each joint, shape (n,): the tree's unit of length.
        rng: Seeds OMPL, whose generator is one for the whole process.
        check: Called all the time; may raise to stop.
        checked: Configurations that are looked at before giving up.

    Returns:
        Shape (k, n), start and goal included.

    Raises:
        NoSeed: If no path was found, or an end is taken to be occupied: OMPL would wait for another.
    """
    free = _Free(query, np.stack((start, goal)), scale, check, checked)
    if free.between(start, goal):
        return np.stack((start, goal))
    free.raise_what_is_occupied(start, goal)
    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(int(rng.integers(1, 2**31)))
    setup = geometric.SimpleSetup(_space(query, start, goal, scale))
    information = setup.getSpaceInformation()
    motions = _Motions(information, free)
    information.setMotionValidator(motions)
    try:
        return _shortened(setup, free, start, goal)
    finally:
        # Both hold each other, one of them in C++, where no garbage is collected.
        information.setMotionValidator(base.MotionValidator(information))


def _shortened(setup: geometric.SimpleSetup, free: "_Free", start: Floats, goal: Floats) -> Floats:
    """Search and shorten."""
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(lambda state: free.between(q := free.positions(state), q))
    begin, end = (_state(information, free.scaled(positions)) for positions in (start, goal))
    setup.setStartAndGoalStates(begin, end)
    planner = geometric.RRTConnect(information)
    planner.setRange(RANGE)
    setup.setPlanner(planner)
    setup.solve(base.PlannerTerminationCondition(free.used_up))
    free.raise_what_stopped()
    if not setup.haveExactSolutionPath():
        if free.idle:
            raise NoSeed("the sampling planner looked at no more configurations, and found no path")
        raise NoSeed(f"the sampling planner found no path among {free.allowed} configurations")
    free.left = SHORTENED
    setup.simplifySolution(base.PlannerTerminationCondition(free.used_up))
    free.raise_what_stopped()
    return np.array([free.positions(state) for state in setup.getSolutionPath().getStates()])


class _Free:
    """Tells free from not, and when to stop."""

    def __init__(self, query: Query, ends: Floats, scale: Floats, check: Check, checked: int) -> None:
        """Measure both ends: nothing need be farther from anything than it is there."""
        self.left = self.allowed = checked
        self._query, self._check, self._scale = query, check, scale
        self._stopped: Exception | None = None
        self._asked, self._asked_at = 0, checked
        pairs = query.reduced.pairs
        self._reach = pairs.required + KEPT * (pairs.margin - pairs.required)
        # As the tree will see them: scaled and back.
        contacts = query.close_pairs(self.scaled(ends) * scale, self._reach)
        np.minimum.at(self._reach, contacts.pair, contacts.distance - SURE)

    def between(self, start: Floats, end: Floats) -> bool:
        """Say whether the straight line between two configurations keeps clear, looked at every `STEP`."""
        swept = float(self._query.displacement(start[None, :], end[None, :])[0])
        samples = np.linspace(start, end, int(np.ceil(swept / STEP)) + 1)
        coarse = samples[:: max(len(samples) // FIRST_LOOK, 1)]
        return self._clear(coarse) and (len(coarse) == len(samples) or self._clear(samples))

    def _clear(self, samples: Floats) -> bool:
        self.left -= len(samples)
        return len(self._query.close_pairs(samples, self._reach).pair) == 0

    def used_up(self) -> bool:
        """Say whether to stop; what is raised must not pass through C++."""
        if self._stopped is None:
            try:
                self._check()
            except Exception as stopped:
                self._stopped = stopped
        self._asked = self._asked + 1 if self.left == self._asked_at else 0
        self._asked_at = self.left
        return self._stopped is not None or self.left <= 0 or self.idle

    @property
    def idle(self) -> bool:
        """Whether nothing was looked at for long: a count of configurations would never end that."""
        return self._asked >= IDLE

    def raise_what_is_occupied(self, start: Floats, goal: Floats) -> None:
        """Raise `NoSeed` if the tree could not begin or end where it is to."""
        for name, positions in (("start", start), ("goal", goal)):
            seen = self.scaled(positions) * self._scale
            if not self.between(seen, seen):
                raise NoSeed(f"the sampling planner takes the {name} to be occupied")

    def raise_what_stopped(self) -> None:
        """Raise what `check` raised."""
        if self._stopped is not None:
            raise self._stopped

    def scaled(self, positions: Floats) -> Floats:
        """Return positions in ordinary steps."""
        return positions / self._scale

    def positions(self, state: base.State) -> Floats:
        """Return a state's positions, shape (n,)."""
        values = cast("base.RealVectorStateType", state)
        return np.array([values[joint] for joint in range(len(self._scale))]) * self._scale


class _Motions(base.MotionValidator):
    """Straight lines between states, all samples of one in one call."""

    def __init__(self, information: base.SpaceInformation, free: _Free) -> None:
        """Note who tells."""
        super().__init__(information)
        self._free = free

    def checkMotion(self, first: base.State, second: base.State) -> bool:
        """Say whether a line is free."""
        return self._free.between(self._free.positions(first), self._free.positions(second))


def _state(information: base.SpaceInformation, positions: Floats) -> base.RealVectorStateType:
    state = cast("base.RealVectorStateType", information.allocState())
    for joint, position in enumerate(positions.tolist()):
        state[joint] = position
    return state


def _space(query: Query, start: Floats, goal: Floats, scale: Floats) -> base.RealVectorStateSpace:
    limits = query.reduced.limits
    nearer, farther = np.minimum(start, goal), np.maximum(start, goal)
    # Both ends lie within the bounds, be it by a hair beyond a limit: OMPL waits for others if they do not.
    low = np.minimum(np.maximum(nearer - TURN, limits.lower), nearer) / scale
    high = np.maximum(np.minimum(farther + TURN, limits.upper), farther) / scale
    bounds = base.RealVectorBounds(len(low))
    for joint in range(len(low)):
        bounds.setLow(joint, float(low[joint]))
        bounds.setHigh(joint, float(high[joint]))
    space = base.RealVectorStateSpace(len(low))
    space.setBounds(bounds)
    return space
