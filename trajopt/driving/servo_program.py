"""The program of a servo's tick: the velocities that follow a command best, of those that can be stopped.

In a tick the acceleration of each joint changes linearly from its present value to a new one, a. The unknown
is the velocity w at which the joint settles afterwards: w = v + a t / 2, where v is the velocity at the end
of the tick, and t, at least a tick, is the time in which the jerk limit lets the acceleration vanish. As w
increases with a, limits of a are limits of w. While w stays within the velocity limit, so does v.

Uniform braking after the delay takes the time b in which the joints lose their present speed, so the distance
of an obstacle may shrink by its share 1 / (delay + b) per second. On a straight line b / 2 would do; as
joints turn, the velocity of the nearest points changes on the way. Speeds away from obstacles are not
limited.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.geometry import JointPlacements, evaluator
from trajopt.geometry.geometry import BoundingBoxes
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.optimise.solvers.subproblem import BandedSteps
from trajopt.robot.joints import EXCESS, JointLimits
from trajopt.scene.bounds import pair_levers
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import ChangingPairs
from trajopt.timing.time_scaling import TICK
from trajopt.values.arrays import Floats, Loss, Rows, Value
from trajopt.values.cached import cached_per_value
from trajopt.values.trajectory import Trajectory


class BodySpeeds:
    """Approach speeds of pairs of bodies, in a configuration and for velocities within bounds."""

    def __init__(self, reduced: ReducedModel) -> None:
        model, boxes = reduced.model, BoundingBoxes.of(reduced)
        self._mimic, self._pairs, self._levers = reduced.mimic_matrix, reduced.pairs, pair_levers(reduced)
        self._joint, self._centre, self._radius = boxes.joint, boxes.centre[:, :, None], boxes.radius
        self._carried = np.zeros((model.nv, model.njoints))
        for joint in range(1, model.njoints):
            for carrier in list(model.supports[joint])[1:]:
                self._carried[int(model.joints[carrier].idx_v), joint] = 1.0

    def nearer(self, placed: JointPlacements, lower: Floats, upper: Floats) -> Floats:
        """Bound the approach speed of each pair, shape (p,) [m/s].

        At the middle of the bounds no point of a body is faster than its centre plus its angular speed times
        its radius; the rest is bounded by levers.

        Args:
            lower: Least velocities of the joints, shape (n,) [rad/s | m/s].
            upper: Shape (n,).
        """
        rates = self._mimic @ ((lower + upper) / 2.0)
        twist = (placed.jacobian[0] * rates) @ self._carried
        linear, angular = twist[:3, self._joint].T, twist[3:, self._joint].T
        turned = (placed.rotation[0, self._joint] @ self._centre)[:, :, 0]
        centre = turned + placed.translation[0, self._joint]
        ahead, behind = (1, 2, 0), (2, 0, 1)
        moved = linear + angular[:, ahead] * centre[:, behind] - angular[:, behind] * centre[:, ahead]
        sizes = np.sqrt(np.stack((moved, angular)) ** 2 @ np.ones(3))
        speed = sizes[0] + sizes[1] * self._radius
        middle = speed[self._pairs.first] + speed[self._pairs.second]
        by_levers = self._levers @ np.stack((np.maximum(-lower, upper), (upper - lower) / 2.0), axis=1)
        return np.minimum(by_levers[:, 0], middle + by_levers[:, 1])


PENALTY = 1e4
"""Penalty of approaching too fast; ignoring a command costs 1."""
DAMPING = 1e-6
"""Weight of the joint velocities, each relative to its limit, to decide between equivalent velocities."""
ACCURACY = 1e-10
"""Accuracy of the program's value: the weight above times the square of a hundredth of a limit."""
INSET = 1e-5
"""Distance from the position limits at which joints turn back, for rounding [rad | m]."""
SURE = 1e-5
"""Bodies this much nearer to each other than required are too near by any measurement [m]."""
STEP = 1e-4
"""Time step of the difference that gives the velocity of dynamic obstacles [s]."""


@dataclass(frozen=True, eq=False)
class VelocityTask(Value):
    """The task of a command: matrix @ w close to the target, where w are the joint velocities."""

    matrix: Floats
    target: Floats


@dataclass(frozen=True, eq=False)
class ApproachLimits(Value):
    """Limits on approach speeds: jacobian @ w >= lower, where w are the joint velocities."""

    jacobian: Floats
    lower: Floats

    def that_can_break(self, lower: Floats, upper: Floats) -> "ApproachLimits":
        """Return the rows that velocities between bounds, shape (n,) each, can violate."""
        least = np.minimum(self.jacobian * lower, self.jacobian * upper).sum(axis=1)
        rows = least < self.lower
        return ApproachLimits(self.jacobian[rows], self.lower[rows])


class Braking:
    """Velocities of joints after a tick, and the time in which they stop."""

    def __init__(self, limits: JointLimits, period: float) -> None:
        """Prepare the limits.

        Args:
            limits: With the jerk of each joint limited.
            period: Time between ticks [s].
        """
        self.limits, self.period = limits, period
        # Building up and releasing the braking acceleration has the effect of a delay. A loop with two lags
        # does not overshoot if the outer lag is four times the inner one, which is a tick.
        self.delay = limits.acceleration / limits.jerk / 2.0 + 4.0 * period

    def time(self, velocities: Floats) -> float:
        slowest = float((np.abs(velocities) / self.limits.acceleration).max())
        return slowest + float(self.delay.max())

    def bounds(self, state: Floats) -> tuple[Floats, Floats]:
        limits, period = self.limits, self.period
        position, _, acceleration = state
        most, change = limits.acceleration, limits.jerk * period
        reached = np.stack((acceleration - change, acceleration + change))
        least, greatest = self.settled(state, np.minimum(np.maximum(reached, -most), most))
        room = np.stack((position - limits.lower, limits.upper - position))
        down, up = np.minimum(limits.velocity * (1.0 - EXCESS), self._brakeable(room))
        lower, upper = np.minimum(np.maximum(np.stack((-down, up)), least), greatest)
        return lower, upper

    def settled(self, state: Floats, acceleration: Floats) -> Floats:
        """Return the velocities that joints settle at after accelerations at the tick's end, (..., n)."""
        gone = np.maximum(np.abs(acceleration) / self.limits.jerk + TICK, self.period)
        return state[1] + self.period * (state[2] + acceleration) / 2.0 + acceleration * gone / 2.0

    def acceleration(self, state: Floats, settled: Floats) -> Floats:
        jerk, half = self.limits.jerk, (self.period + TICK) / 2.0
        change = settled - state[1] - self.period * state[2] / 2.0
        size = np.abs(change)
        longer = jerk * (np.sqrt(half**2 + 2.0 * size / jerk) - half)
        return np.sign(change) * np.minimum(size / self.period, longer)

    def after(self, state: Floats, settled: Floats) -> Floats:
        most, period = self.limits.acceleration, self.period
        then = np.minimum(np.maximum(self.acceleration(state, settled), -most), most)
        position, velocity, before = state
        return np.stack(
            (
                position + period * (velocity + period * (2.0 * before + then) / 6.0),
                velocity + period * (before + then) / 2.0,
                then,
            )
        )

    def _brakeable(self, distance: Floats) -> Floats:
        """Return the largest velocities w at distances w t + w^2 / 2a, (..., n), where t is the delay."""
        most = self.limits.acceleration
        delayed = most * self.delay
        distance = np.maximum(distance - INSET, 0.0)
        return np.sqrt(delayed**2 + 2.0 * most * distance) - delayed


class ApproachQuery:
    """Distances of a robot from its surroundings, and the allowed approach speeds."""

    def __init__(self, reduced: ReducedModel, braking: Braking, clearance: float) -> None:
        timed = reduced.timed
        whole = reduced if timed is None else timed.reduced
        self.query = evaluator(whole)
        self._timed, self._braking = timed, braking
        self._changing = None if timed is None else ChangingPairs.of(timed)
        self._clearance = np.asarray(whole.pairs.required) + clearance
        self._required = np.array(whole.pairs.required)
        self._required[[pair for pair, _ in whole.pairs.allowances]] = -np.inf
        self._joints = len(reduced.joint_names)
        self._speeds = BodySpeeds(whole)

    def positions(self, positions: Floats, time: float) -> Floats:
        if self._timed is None:
            return positions
        return self._timed.positions(positions[None], np.array((time,)))[0]

    def contact(self, motion: Trajectory, time: float) -> float:
        """Return the time of the first point of a motion at which bodies are surely too near to each other.

        Prediction errors and accepted contacts do not count; between the points nothing is measured.

        Args:
            time: At which the motion begins [s].

        Returns:
            Since the begin; infinite if there is no such point [s].
        """
        rows, times = motion.positions, time + motion.times
        if self._timed is not None:
            rows = self._timed.positions(rows, times)
        near = self.query.close_pairs(rows, self._required)
        close = near.distance < self._required[near.pair] - SURE
        if self._changing is not None:
            clock, changing = times[near.sample], self._changing
            close &= (changing.appears[near.pair] <= clock) & (clock <= changing.expires[near.pair])
        return float(motion.times[near.sample[close]].min(initial=np.inf))

    def limits(
        self, state: Floats, time: float, bounds: tuple[Floats, Floats] | None = None
    ) -> ApproachLimits:
        """Return the allowed approach speeds of all pairs that may be too fast.

        Args:
            state: Positions, velocities and accelerations of the group's joints, shape (3, n).
            bounds: Velocities at which joints can settle, shape (n,) each [rad/s | m/s]; if None, all that
                their limits allow while they brake.
        """
        braking, joints = self._braking, self._joints
        limits = braking.limits
        positions, stop_time = self.positions(state[0], time), braking.time(state[1])
        rates = np.zeros(len(positions))
        if self._timed is not None:
            after = self._timed.driven.at(np.array((time, time + STEP)))
            rates[joints:] = (after[1] - after[0]) / STEP
        lower, upper = rates.copy(), rates.copy()
        if bounds is None:
            upper[:joints] = np.minimum(np.abs(state[1]) + limits.acceleration * stop_time, limits.velocity)
            lower[:joints] = -upper[:joints]
        else:
            lower[:joints], upper[:joints] = bounds
        fastest = self._speeds.nearer(self.query.kinematics(positions[None]), lower, upper)
        reach, growth = self._clearance + stop_time * fastest, np.zeros(len(self._clearance))
        if self._changing is not None:
            _, velocity, acceleration = self._changing.errors.T
            error, growth = self._changing.error_at(time, slice(None)), velocity + acceleration * time
            present = (self._changing.appears <= time + stop_time) & (time <= self._changing.expires)
            reach = np.where(present, reach + error + growth * stop_time, -np.inf)
        else:
            error = growth
        near = self.query.close_pairs(positions[None], reach)
        distance = np.maximum(near.distance - (self._clearance + error)[near.pair], 0.0)
        jacobian = np.ascontiguousarray(near.jacobian[:, :joints])
        deceleration = np.abs(jacobian) @ limits.acceleration
        allowed = np.minimum(distance / stop_time, np.sqrt(2.0 * deceleration * distance))
        obstacle = near.jacobian[:, joints:] @ rates[joints:] - growth[near.pair]
        found = ApproachLimits(jacobian, -allowed - obstacle)
        return found if bounds is None else found.that_can_break(*bounds)


def settle(
    task: VelocityTask, approach: ApproachLimits, lower: Floats, upper: Floats, limits: JointLimits
) -> Floats | None:
    """Return the velocities between bounds (n,) that follow a task best; None without a solution."""
    middle, joints = (lower + upper) / 2.0, len(lower)
    wanted = len(task.target)
    matrix = np.concatenate((task.matrix, _relative(limits)))
    value, weight = matrix @ middle, np.full(wanted + joints, DAMPING)
    value[:wanted] -= task.target
    weight[:wanted] = 1.0
    costs = CostRows("command", _rows(value, matrix), weight, Loss.SQUARED)
    kept = ConstraintRows(
        "clearance",
        _rows(approach.jacobian @ middle, approach.jacobian),
        approach.lower,
        np.full(len(approach.lower), np.inf),
        0.0,
    )
    at = Linearisation(middle[None], (costs,), (kept,), np.zeros(0, dtype=np.int64))
    moves = (upper - lower > EXCESS * limits.velocity)[None]
    step = (
        BandedSteps()
        .program(moves, at, PENALTY)
        .solve((lower - middle)[None], (upper - middle)[None], ACCURACY)
    )
    return None if step is None else np.minimum(np.maximum(middle + step.dx[0], lower), upper)


@cached_per_value
def _relative(limits: JointLimits) -> Floats:
    return np.diag(1.0 / limits.velocity)


def _rows(value: Floats, jacobian: Floats) -> Rows:
    count = np.zeros(len(value), dtype=np.int64)
    return Rows(value, jacobian[:, None, :], count[:, None], count, np.zeros(len(value)))
