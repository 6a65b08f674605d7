"""The program of a servo's tick: the velocities that follow a command best, of those that can be stopped.

In a tick the acceleration of each joint changes linearly from its present value to a new one, a. The unknown
is the velocity w at which the joint settles afterwards: w = v + a t / 2, where v is the velocity at the end
of the tick, and t, at least a tick, is the time in which the jerk limit lets the acceleration vanish. As w
increases with a, limits of a are limits of w. While w stays within the velocity limit, so does v.

Uniform braking after the delay takes the time b in which the joints lose their present speed, so the distance
of an obstacle may shrink by its share 1 / (delay + b) per second. On a straight line b / 2 would do; as
joints turn, the velocity of the nearest points changes on the way.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.geometry import JointPlacements, evaluator
from trajopt.geometry.geometry import BoundingBoxes
from trajopt.native import servo
from trajopt.optimise.solvers.subproblem import REGULARISATION, BandedSteps
from trajopt.robot.joints import EXCESS, JointLimits
from trajopt.scene.bounds import pair_levers
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import ChangingPairs
from trajopt.timing.time_scaling import TICK, limit_rows
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory


class BodySpeeds:
    """Approach speeds of pairs of bodies, in a configuration and for velocities within bounds."""

    def __init__(self, reduced: ReducedModel) -> None:
        model, boxes, pairs = reduced.model, BoundingBoxes.of(reduced), reduced.pairs
        carried = np.zeros((model.nv, model.njoints))
        for joint in range(1, model.njoints):
            for carrier in list(model.supports[joint])[1:]:
                carried[int(model.joints[carrier].idx_v), joint] = 1.0
        self._core = servo.BodySpeeds(
            boxes.joint.astype(np.int64),
            boxes.centre,
            boxes.radius,
            carried,
            np.asarray(pairs.first, dtype=np.int64),
            np.asarray(pairs.second, dtype=np.int64),
            np.ascontiguousarray(reduced.mimic_matrix),
            np.ascontiguousarray(pair_levers(reduced)),
        )

    def nearer(self, placed: JointPlacements, lower: Floats, upper: Floats) -> Floats:
        """Bound the approach speed of each pair, shape (p,) [m/s].

        At the middle of the bounds no point of a body is faster than its centre plus its angular speed times
        its radius; the rest is bounded by levers.

        Args:
            lower: Least velocities of the joints, shape (n,) [rad/s | m/s].
            upper: Shape (n,).
        """
        first = placed.rotation[0], placed.translation[0], placed.jacobian[0]
        return self._core.nearer(*first, lower, upper)


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
        self._core = servo.Braking(limit_rows(limits), self.delay, period, TICK, EXCESS, INSET)

    def time(self, velocities: Floats) -> float:
        return self._core.time(velocities)

    def bounds(self, state: Floats) -> tuple[Floats, Floats]:
        """Return the velocities at which joints can settle, from a state of shape (3, n)."""
        return self._core.bounds(state)

    def after(self, state: Floats, settled: Floats) -> Floats:
        """Return the state after the tick, shape (3, n), for velocities at which the joints settle."""
        return self._core.after(state, settled)


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
        return ApproachLimits(jacobian, -allowed - obstacle)


def settle(
    task: VelocityTask, approach: ApproachLimits, lower: Floats, upper: Floats, limits: JointLimits
) -> Floats | None:
    """Return the velocities between bounds (n,) that follow a task best; None without a solution."""
    return servo.settle(
        task.matrix,
        task.target,
        approach.jacobian,
        approach.lower,
        lower,
        upper,
        limits.velocity,
        (DAMPING, PENALTY, EXCESS, ACCURACY, REGULARISATION),
        BandedSteps().max_iterations,
    )
