"""The program of a servo's tick: which velocities follow a command best, of those that can still be stopped.

A tick changes the acceleration of each joint evenly, from the one that it has to another, a. What is solved
for is the velocity w that the joint settles at from there: w = v + a t / 2, where v is the velocity at the
tick's end and t is how long the jerk limit lets the acceleration take to be gone, and at least a tick. As w
grows with a, limits of a are limits of w; and while w stays within the velocity limit, v does too, for no
acceleration can bring v farther than w before it is gone.

How fast something may come nearer to where it has to stay away from, follows from how much room there is:
after the delay, braking evenly takes the time b in which the joints can lose the speed that they have, so the
room may shrink by its (delay + b)-th part a second. On a straight way half of b would do; but on the way the
joints turn, and what comes nearer there is not what comes nearer now. Nothing is said of what gets away: it
leaves at full speed.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.geometry import JointPlacements, Query
from trajopt.geometry.geometry import BoundingBoxes
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.optimise.solvers.banded import BandedSteps
from trajopt.robot.limits import EXCESS, JointLimits
from trajopt.scene.deviation import pair_levers
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.timed import ChangingPairs, timed_model
from trajopt.timing.joint_stops import TICK
from trajopt.values.arrays import Floats, Loss, Rows, Value


class BodySpeeds:
    """How fast pairs of bodies can come nearer, in a configuration and for velocities within bounds."""

    def __init__(self, reduced: ReducedModel) -> None:
        """Lay out the bodies.

        Args:
            reduced: Robot and scene.
        """
        model, boxes = reduced.model, BoundingBoxes.of(reduced)
        self._mimic, self._pairs, self._levers = reduced.mimic_matrix, reduced.pairs, pair_levers(reduced)
        self._joint, self._centre, self._radius = boxes.joint, boxes.centre[:, :, None], boxes.radius
        self._carried = np.zeros((model.nv, model.njoints))
        for joint in range(1, model.njoints):
            for carrier in list(model.supports[joint])[1:]:
                self._carried[int(model.joints[carrier].idx_v), joint] = 1.0

    def nearer(self, placed: JointPlacements, lower: Floats, upper: Floats) -> Floats:
        """Bound how fast the bodies of each pair can come nearer, shape (p,) [m/s].

        At the middle of the bounds no point of a body is faster than its centre, and its turning times its
        radius, make it; the rest is bounded by levers, which hold everywhere.

        Args:
            placed: Where the joints are, in one configuration.
            lower: Least velocities of the joints, shape (n,) [rad/s | m/s].
            upper: Largest, likewise.
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
"""Of coming nearer than is allowed: far more than following a command can ever be worth, whose cost is 1 when
nothing of it is done."""
STILLNESS = 1e-6
"""Weight of the joints' velocities, each by its limit: it decides where the command leaves a choice, and
costs a millionth of what is commanded."""
ACCURACY = 1e-10
"""Of the program's value: as small a part of the weight above as the square of a hundredth of a limit."""
INSET = 1e-5
"""Joints turn back so far inside their position limits: rounding does not carry them out [rad | m]."""
STEP = 1e-4
"""Time over which the velocity of what moves by itself is taken as a difference [s]."""


@dataclass(frozen=True, eq=False)
class VelocityTask(Value):
    """What a command asks of the joints' velocities w: matrix @ w near to the target.

    Attributes:
        matrix: Shape (k, n).
        target: Shape (k,).
    """

    matrix: Floats
    target: Floats


@dataclass(frozen=True, eq=False)
class ApproachLimits(Value):
    """What must not come nearer than room allows: jacobian @ w >= lower.

    Attributes:
        jacobian: Shape (m, n).
        lower: Shape (m,).
    """

    jacobian: Floats
    lower: Floats

    def that_can_break(self, lower: Floats, upper: Floats) -> "ApproachLimits":
        """Return the rows that velocities between bounds, shape (n,) each, can break."""
        least = np.minimum(self.jacobian * lower, self.jacobian * upper).sum(axis=1)
        rows = least < self.lower
        return ApproachLimits(self.jacobian[rows], self.lower[rows])


class Braking:
    """What joints can do in a tick, and how soon they can stop."""

    def __init__(self, limits: JointLimits, period: float) -> None:
        """Take the limits.

        Args:
            limits: With the jerk of each joint limited.
            period: Of a tick [s].
        """
        self.limits, self.period = limits, period
        # While a brake is put on and let go of, joints go as far as if they braked all at once so much later.
        # Two lags one after the other do not overshoot where the outer is four times as long as the inner,
        # which is a tick.
        self.delay = limits.acceleration / limits.jerk / 2.0 + 4.0 * period

    def time(self, velocities: Floats) -> float:
        """Return how long it takes until the joints stand, with the delay [s]."""
        slowest = float((np.abs(velocities) / self.limits.acceleration).max())
        return slowest + float(self.delay.max())

    def bounds(self, state: Floats) -> tuple[Floats, Floats]:
        """Return between what velocities the joints can settle, and still brake before their limits.

        Args:
            state: Positions, velocities and accelerations, shape (3, n).
        """
        limits, period = self.limits, self.period
        position, _, acceleration = state
        most, change = limits.acceleration, limits.jerk * period
        least = self.settled(state, np.maximum(-most, np.minimum(acceleration - change, most)))
        greatest = self.settled(state, np.minimum(most, np.maximum(acceleration + change, -most)))
        fastest = limits.velocity * (1.0 - EXCESS)
        up = np.minimum(fastest, self._brakeable(limits.upper - position))
        down = np.minimum(fastest, self._brakeable(position - limits.lower))
        return np.clip(-down, least, greatest), np.clip(up, least, greatest)

    def settled(self, state: Floats, acceleration: Floats) -> Floats:
        """Return the velocities that joints settle at, which have these accelerations at the tick's end."""
        gone = np.maximum(np.abs(acceleration) / self.limits.jerk + TICK, self.period)
        return state[1] + self.period * (state[2] + acceleration) / 2.0 + acceleration * gone / 2.0

    def acceleration(self, state: Floats, settled: Floats) -> Floats:
        """Return the accelerations at the tick's end from which joints settle at velocities."""
        jerk, half = self.limits.jerk, (self.period + TICK) / 2.0
        change = settled - state[1] - self.period * state[2] / 2.0
        size = np.abs(change)
        longer = jerk * (np.sqrt(half**2 + 2.0 * size / jerk) - half)
        return np.sign(change) * np.minimum(size / self.period, longer)

    def _brakeable(self, room: Floats) -> Floats:
        """Return how fast joints may be with so much room: room = w t + w^2 / 2a, t the delay."""
        most = self.limits.acceleration
        delayed = most * self.delay
        room = np.maximum(room - INSET, 0.0)
        return np.sqrt(delayed**2 + 2.0 * most * room) - delayed


class Surroundings:
    """What a robot keeps apart from, and how fast it may come nearer."""

    def __init__(self, reduced: ReducedModel, braking: Braking, kept: float) -> None:
        """Prepare to measure.

        Args:
            reduced: Robot and scene; the scene's clock shows 0 when `approach` is told time 0.
            braking: Of the group's joints.
            kept: How much farther than required all keep apart [m].
        """
        timed = timed_model(reduced)
        among = reduced if timed is None else timed.reduced
        self.query = Query(among)
        self._timed, self._braking = timed, braking
        self._changing = None if timed is None else ChangingPairs.of(timed)
        self._kept = np.asarray(among.pairs.required) + kept
        self._joints = len(reduced.joint_names)
        self._speeds = BodySpeeds(among)

    def positions(self, positions: Floats, time: float) -> Floats:
        """Return the positions of the query's joints, for those of the group (n,) at a time [s]."""
        if self._timed is None:
            return positions
        return self._timed.positions(positions[None], np.array((time,)))[0]

    def approach(
        self, state: Floats, time: float, bounds: tuple[Floats, Floats] | None = None
    ) -> ApproachLimits:
        """Measure what is near, and return how fast it may come nearer.

        Only what can be too fast is measured: all else has room for any velocities within the bounds.

        Args:
            state: Positions, velocities and accelerations of the group's joints, shape (3, n).
            time: On the scene's clock [s].
            bounds: Between what velocities joints can settle, shape (n,) each [rad/s | m/s]; when None, any
                that their limits allow while they are stopped.
        """
        braking, joints = self._braking, self._joints
        limits = braking.limits
        places, late = self.positions(state[0], time), braking.time(state[1])
        rates = np.zeros(len(places))
        if self._timed is not None:
            after = self._timed.driven.at(np.array((time, time + STEP)))
            rates[joints:] = (after[1] - after[0]) / STEP
        lower, upper = rates.copy(), rates.copy()
        if bounds is None:
            upper[:joints] = np.minimum(np.abs(state[1]) + limits.acceleration * late, limits.velocity)
            lower[:joints] = -upper[:joints]
        else:
            lower[:joints], upper[:joints] = bounds
        nearest = self._speeds.nearer(self.query.kinematics(places[None]), lower, upper)
        reach, grows = self._kept + late * nearest, np.zeros(len(self._kept))
        if self._changing is not None:
            _, velocity, acceleration = self._changing.errors.T
            error, grows = self._changing.error_at(time, slice(None)), velocity + acceleration * time
            there = (self._changing.appears <= time + late) & (time <= self._changing.expires)
            reach = np.where(there, reach + error + grows * late, -np.inf)
        else:
            error = grows
        near = self.query.close_pairs(places[None], reach)
        room = np.maximum(near.distance - (self._kept + error)[near.pair], 0.0)
        jacobian = np.ascontiguousarray(near.jacobian[:, :joints])
        brake = np.abs(jacobian) @ limits.acceleration
        nearer = np.minimum(room / late, np.sqrt(2.0 * brake * room))
        by_itself = near.jacobian[:, joints:] @ rates[joints:] - grows[near.pair]
        found = ApproachLimits(jacobian, -nearer - by_itself)
        return found if bounds is None else found.that_can_break(*bounds)


def settle(
    task: VelocityTask, approach: ApproachLimits, lower: Floats, upper: Floats, limits: JointLimits
) -> Floats | None:
    """Return the velocities between bounds that follow a task best, or None where there is no answer.

    Args:
        task: What is commanded.
        approach: What must not come nearer; where it cannot be held, it is broken by as little as can be.
        lower: Shape (n,) [rad/s | m/s].
        upper: Likewise.
        limits: Of the joints.
    """
    middle, joints = (lower + upper) / 2.0, len(lower)
    matrix = np.concatenate((task.matrix, np.diag(1.0 / limits.velocity)))
    value = matrix @ middle - np.concatenate((task.target, np.zeros(joints)))
    weight = np.concatenate((np.ones(len(task.target)), np.full(joints, STILLNESS)))
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
    return None if step is None else np.clip(middle + step.dx[0], lower, upper)


def _rows(value: Floats, jacobian: Floats) -> Rows:
    count = np.zeros(len(value), dtype=np.int64)
    return Rows(value, jacobian[:, None, :], count[:, None], count, np.zeros(len(value)))
