"""A baseline: RRT-Connect over OMPL's space of configurations and times, with Pinocchio and Coal behind it.

ompl 2.0.1 has `SpaceTimeStateSpace`, but neither ST-RRT* (`STRRTstar`), which is made for it, nor a way
to give the space a sampler of one's own. So this is `RRTConnect` over it, both of whose trees test edges
in the right direction of time. What makes it do:

* Coordinates are joint positions over speed limits [s]. An edge is refused that is not forward in time or
  on which a joint would be faster than its limit; there is no limit on acceleration, so that its motions
  are shorter than any arm's could be.
* Edges are tested at configurations 0.05 rad and 40 ms apart at most, and half as far from each other
  each time the judge refuses a motion.
* Goal states are the goal at 40 times, evenly between the least time (all joints at their limits) and a
  horizon. The horizon begins at twice the least time and a second, and grows by half each time a share of
  the CPU time is used up without a motion. Once there is a motion, the horizon is 0.9 of its duration,
  and so on.

A second kind rests at every corner: each edge is a quintic from rest to rest, within the limits of speed,
acceleration and jerk, and its motions are judged by everything. They are longer, but an arm can do them.
"""

import time
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pinocchio as pin
from ompl import base, geometric, util

import trajopt as to
from trajopt.geometry.geometry import collision_geometry
from trajopt.problem.requirements import JointPositions
from trajopt.verify import CheckKind, Judge, Specification

util.setLogLevel(util.LogLevel.LOG_NONE)

RADIANS, SECONDS = 0.05, 0.04
"""Between two tests along an edge, at first [rad | s]."""
RANGE = 0.5
"""Longest extension of a tree in the distance of the space, which is half the seconds of motion and half
those of time, as a share of the least time between start and goal."""
ARRIVALS = 40
SHARE = 0.15
"""Of the CPU time, before the horizon grows."""
SHORTER = 0.9
PEAKS = (15.0 / 8.0, 10.0 / np.sqrt(3.0), 60.0)
"""Largest speed, acceleration and jerk of a quintic from rest to rest: a unit of way in a unit of time."""
UNJUDGED = {"acceleration", "jerk"}
"""Limits that straight edges cannot keep; they are not checked."""


class Checker:
    """Says whether configurations at times are free, by Pinocchio's broad phase and Coal."""

    def __init__(self, problem: to.Problem) -> None:
        """Copy the bodies and the pairs that have to keep apart."""
        timed = problem.reduced.timed
        if timed is None:
            raise ValueError("nothing in the scene changes with time")
        self._timed, reduced = timed, timed.reduced
        self._model, self._data = reduced.model, reduced.model.createData()
        self._geometry = pin.GeometryModel()
        for body in reduced.bodies:
            where = pin.SE3(body.placement.rotation, body.placement.translation)
            item = pin.GeometryObject(body.name, body.joint, where, collision_geometry(body.shape))
            self._geometry.addGeometryObject(item)
        for first, second in zip(reduced.pairs.first.tolist(), reduced.pairs.second.tolist(), strict=True):
            self._geometry.addCollisionPair(pin.CollisionPair(first, second))
        self._manager = pin.BroadPhaseManager_DynamicAABBTreeCollisionManager(
            self._model, self._geometry, pin.GeometryData(self._geometry)
        )

    def free(self, positions: np.ndarray, times: np.ndarray) -> bool:
        """Say whether the arm is free at all configurations (s, n) at times (s,)."""
        among = self._timed.positions(positions, times)
        for row in among[_middle_first(len(among))]:
            configuration = self._timed.reduced.configuration(row)
            if pin.computeCollisions(self._model, self._data, self._manager, configuration, True):
                return False
        return True


def _middle_first(count: int) -> list[int]:
    """Return 0 to count - 1, both ends first, then so that the largest gaps are looked into first."""
    order, step = list(dict.fromkeys((count - 1, 0))), 1 << max(count - 1, 1).bit_length()
    seen = set(order)
    while step > 1:
        step //= 2
        new = [place for place in range(0, count, step) if place not in seen]
        order += new
        seen.update(new)
    return order


class Forward(base.MotionValidator):
    """Accepts edges that are forward in time, no faster than the arm, and free."""

    def __init__(self, space: base.SpaceInformation, rrt: "SpaceTimeRrt") -> None:
        """Know the search."""
        super().__init__(space)
        self._rrt = rrt

    def checkMotion(self, first: object, second: object, *_: object) -> bool:
        """Say whether an edge is possible."""
        (x, begin), (y, end) = self._rrt.read(first), self._rrt.read(second)
        if end <= begin or self._rrt.shortest(x, y) > end - begin:
            return False
        return self._rrt.edge_free(x, begin, y, end)


@dataclass
class Found:
    """What was found.

    Attributes:
        trajectory: The shortest motion that the judge proves, as far as it is judged; None if there is none.
        cpu: CPU time used, judging left out [s].
        first: The same until the first proven motion [s].
        refused: Motions that the judge refused.
    """

    trajectory: to.Trajectory | None = None
    cpu: float = 0.0
    first: float | None = None
    refused: int = 0
    reasons: list[str] = field(default_factory=list)


class SpaceTimeRrt:
    """Searches for motions of one problem with a goal of joint positions."""

    def __init__(self, problem: to.Problem, latest: float, *, resting: bool = False) -> None:
        """Build the space.

        Args:
            problem: With one goal, of joint positions.
            latest: No motion ends later [s].
            resting: Whether it rests at every corner.
        """
        (goal,) = problem.goals
        if not isinstance(goal, JointPositions):
            raise TypeError("the goal must be joint positions")
        self.problem, self.latest, self._resting = problem, latest, resting
        self._names = problem.reduced.joint_names
        # A millionth slower than the limits, for rounding.
        self._speed = problem.limits.velocity * (1.0 - 1e-6)
        self.start = problem.reduced.start_positions / self._speed
        self.goal = np.array([goal.positions[name] for name in self._names]) / self._speed
        self._checker, self._judge = Checker(problem), Judge(problem.reduced)
        self._resolution = 1.0
        vectors = base.RealVectorStateSpace(len(self._names))
        bounds = base.RealVectorBounds(len(self._names))
        for joint, (low, high) in enumerate(
            zip(problem.limits.lower / self._speed, problem.limits.upper / self._speed, strict=True)
        ):
            bounds.setLow(joint, float(low))
            bounds.setHigh(joint, float(high))
        vectors.setBounds(bounds)
        self._vectors = vectors

    @property
    def least(self) -> float:
        """Least time between start and goal [s]."""
        return self.shortest(self.start, self.goal)

    def shortest(self, x: np.ndarray, y: np.ndarray) -> float:
        """Return the least time of an edge [s]."""
        way = np.abs(y - x)
        if not self._resting:
            return float(way.max())
        limits, turned = self.problem.limits, way * self._speed
        orders = (self._speed, limits.acceleration, limits.jerk)
        needs = [
            (peak * turned / limit).max() ** (1.0 / order)
            for order, (peak, limit) in enumerate(zip(PEAKS, orders, strict=True), start=1)
        ]
        return (1.0 + 1e-6) * float(max(needs))

    def read(self, state: object) -> tuple[np.ndarray, float]:
        """Return a state's coordinates and time."""
        values = state[0]
        return np.array([values[joint] for joint in range(len(self._names))]), state[1].position

    def edge_free(self, x: np.ndarray, begin: float, y: np.ndarray, end: float) -> bool:
        """Say whether an edge is free, as far as it is tested."""
        turned = float((np.abs(y - x) * self._speed).max())
        most = max(turned / RADIANS, (end - begin) / SECONDS) / self._resolution
        share = np.linspace(0.0, 1.0, 2 + int(most))
        gone = share**3 * (10.0 - 15.0 * share + 6.0 * share**2) if self._resting else share
        return self._checker.free((x + gone[:, None] * (y - x)) * self._speed, begin + share * (end - begin))

    def solve(self, seconds: float, *, improve: bool = False) -> Found:
        """Search for so much CPU time [s]; with `improve` for ever shorter motions until it is used up."""
        found, horizon = Found(), min(2.0 * self.least + 1.0, self.latest)
        while found.cpu < seconds and horizon > self.least:
            used = time.process_time()
            path = self._searched(horizon, used + min(seconds - found.cpu, SHARE * seconds))
            found.cpu += time.process_time() - used
            if path is None:
                if found.trajectory is None:
                    horizon = min(1.5 * horizon, self.latest)
                continue
            refusal = self._refusal(path)
            if refusal is None:
                found.trajectory, found.first = path, found.first or found.cpu
                horizon = SHORTER * path.duration
                if not improve:
                    break
            else:
                found.refused += 1
                found.reasons.append(refusal)
                self._resolution /= 2.0
        return found

    def _searched(self, horizon: float, until: float) -> to.Trajectory | None:
        """Search for a motion that ends before a horizon, until the process has used so much CPU time."""
        space = base.SpaceTimeStateSpace(self._vectors, float(np.sqrt(len(self._names))), 0.5)
        space.setTimeBounds(0.0, horizon)
        information = base.SpaceInformation(space)
        information.setStateValidityChecker(lambda _: True)  # edges test their ends, when they are possible
        information.setMotionValidator(Forward(information, self))
        information.setup()
        goals = base.GoalStates(information)
        arrivals = np.linspace(max(self.least * (1.0 + 1e-9), horizon / ARRIVALS), horizon, ARRIVALS)
        for arrival in np.random.default_rng(0).permutation(arrivals).tolist():
            if self._checker.free(self.goal[None] * self._speed, np.array((arrival,))):
                goals.addState(self._state(space, self.goal, arrival))
        if not goals.getStateCount():
            return None
        definition = base.ProblemDefinition(information)
        definition.addStartState(self._state(space, self.start, 0.0))
        definition.setGoal(goals)
        planner = geometric.RRTConnect(information)
        planner.setRange(RANGE * self.least)
        planner.setProblemDefinition(definition)
        planner.setup()
        planner.solve(base.PlannerTerminationCondition(lambda: time.process_time() >= until))
        if not definition.hasExactSolution():
            return None
        solution = definition.getSolutionPath()  # held while its states are read
        states = [self.read(state) for state in solution.getStates()]
        kept = [states[0], *(later for earlier, later in pairwise(states) if later[1] > earlier[1])]
        points = np.array([x for x, _ in kept]) * self._speed
        times, still = np.array([moment for _, moment in kept]), np.zeros_like(points)
        rests = (still, still.copy()) if self._resting else ()
        return to.Trajectory(self._names, times, points, *rests)

    @staticmethod
    def _state(space: base.SpaceTimeStateSpace, x: np.ndarray, moment: float) -> object:
        state = space.allocState()
        space.copyFromReals(state, [*x.tolist(), moment])
        return state

    def _refusal(self, path: to.Trajectory) -> str | None:
        """Return the judge's objection to a motion, without acceleration limits; None if proven."""
        certificate = self._judge.certify(path, Specification(goals=self.problem.goals))
        wrong = [
            check.detail
            for check in certificate.failed
            if self._resting
            or not (check.name in UNJUDGED or "at rest" in check.name or check.kind is CheckKind.TORQUE)
        ]
        return "; ".join(wrong) or None
