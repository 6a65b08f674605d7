"""The next joint targets of a policy, and the smooth motion through them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.driving.servo_task import Tool
from trajopt.geometry import Evaluator
from trajopt.problem.requirements.joints import LENGTH
from trajopt.robot.joints import JointLimits
from trajopt.timing.time_scaling import stop_at_the_end, tracking
from trajopt.values.arrays import Bools, Floats, Ints, Value
from trajopt.values.cached import cached_per_value
from trajopt.values.placement import Placement, as_rotation_vector
from trajopt.values.trajectory import Trajectory

INSET = 1e-4
"""Distance from position limits that a motion keeps if the actions do not, as it overshoots at their end
[rad | m]: ten times the repeatability of an arm.
"""
ONWARD = 20
"""Number of targets after the last action, at which the motion goes on: without them a motion to one or two
actions would reach them at a velocity and acceleration from which the next ones are missed, ever farther.
"""
GROWTH = 1.3
"""Ratio of successive intervals between them, so that they outlast the longest time constant."""
RECOVERY, PART = 0.2, 0.02
"""Within the first 0.2 s the jerk may change every 20 ms, so that a robot that brakes first ends that [s]."""
DAMPING = 1e-6
"""Damping of inverse kinematics near singularities, squared [m^2]."""
ITERATIONS = 20
REACHED = 1e-4
"""Largest distance of the tool from a pose that counts as reached, a radian counting as `LENGTH` [m]."""


@dataclass(frozen=True, eq=False)
class ActionChunk(Value):
    """The next joint targets (K, n) of a policy [rad | m], at times (K,) of the executor's clock [s].

    Attributes:
        onward: Velocity expected after the last action, shape (n,) [rad/s | m/s].
    """

    targets: Floats
    times: Floats
    onward: Floats

    @staticmethod
    def following(before: "ActionChunk | None", targets: Floats, times: Floats) -> "ActionChunk":
        """Return a chunk that goes on as from its last action but one, or from the last of the one before."""
        if len(times) == 1 and before is not None and before.times[-1] < times[0]:
            step, span = targets[0] - before.targets[-1], times[0] - before.times[-1]
        elif len(times) > 1:
            step, span = targets[-1] - targets[-2], times[-1] - times[-2]
        else:
            step, span = np.zeros(targets.shape[1]), 1.0
        return ActionChunk(targets, times, step / span)

    def after(self, time: float) -> "ActionChunk":
        later = self.times > time
        return ActionChunk(self.targets[later], self.times[later], self.onward)

    def up_to(self, limits: JointLimits) -> "ActionChunk | None":
        """Return the actions before the first that is beyond a position limit; None if that is the first."""
        beyond: Bools = np.any((self.targets < limits.lower) | (self.targets > limits.upper), axis=1)
        if not beyond.any():
            return self
        count = int(beyond.argmax())
        return ActionChunk.following(None, self.targets[:count], self.times[:count]) if count else None

    def slowed(self, begin: float, rate: float) -> "ActionChunk":
        return ActionChunk(self.targets, begin + (self.times - begin) / rate, rate * self.onward)

    def target(self, time: float) -> tuple[Floats, Floats]:
        """Return the linear interpolation of the targets at a time [s], and its slope; shape (n,) each."""
        if len(self.times) == 1 or time >= self.times[-1]:
            last: Floats = self.targets[-1]
            return last, np.zeros_like(last)
        at = max(int(self.times.searchsorted(time)), 1)
        span = float(self.times[at] - self.times[at - 1])
        slope: Floats = (self.targets[at] - self.targets[at - 1]) / span
        gone = max(time - float(self.times[at - 1]), 0.0)
        return self.targets[at - 1] + gone * slope, slope


@dataclass(frozen=True, eq=False)
class ActionMotion(Value):
    """A motion along a chunk of actions, with constant jerks between times.

    Attributes:
        times: Of begin, actions and some between them, since the begin, shape (k + 1,) [s].
        states: Positions, velocities and accelerations then, shape (3, k + 1, n).
        jerks: From each time to the next, shape (k, n).
        due: Indices in `times` of the actions, shape (K,).
        within: Number of actions up to the first time at which a limit is exceeded.
    """

    chunk: ActionChunk
    times: Floats
    states: Floats
    jerks: Floats
    due: Ints
    within: int

    def first(self, count: int, limits: JointLimits) -> Trajectory:
        end = int(self.due[count - 1]) + 1
        return stop_at_the_end(self.times[:end], self.states[:, :end], limits)


def along_actions(
    begin: Floats, time: float, chunk: ActionChunk, deviations: Sequence[float], limits: JointLimits
) -> ActionMotion:
    """Return the motion from a state that stays near the actions with small jerks.

    It minimises the sum over the actions, and further targets onward, of (q_k - a_k)^2 / deviation^2, and
    over all times of j_k^2 / J^2, where j_k are the constant jerks from one time to the next and J is the
    median of the jerk limits. The first deviation counts for which all actions are within the limits, or else
    most of them.

    Args:
        chunk: The actions, all later.
        deviations: Each weighs as much as a jerk J [rad | m].
        limits: With the jerk of each joint limited.
    """
    count, actions = len(chunk.times), np.append(0.0, chunk.times - time)
    parts = np.where(actions[:-1] < RECOVERY, np.ceil(np.diff(actions) / PART), 1.0).astype(np.int64)
    due = np.cumsum(parts)
    places = np.arange(float(parts.sum()) + 1.0)
    times: Floats = np.asarray(np.interp(places, np.append(0.0, due), actions), dtype=np.float64)
    later = np.cumsum((actions[-1] - actions[-2]) * GROWTH ** np.arange(ONWARD))
    last = chunk.targets[-1]
    onward = last + later[:, None] * np.clip(chunk.onward, -limits.velocity, limits.velocity)
    end, weights = len(times), np.array(deviations) / _median_jerk(limits)
    states, jerks, within = tracking(
        begin,
        np.append(times, times[-1] + later),
        np.append(due, np.arange(end, end + ONWARD)),
        inset(np.concatenate((chunk.targets, onward)), limits),
        weights,
        limits,
        counted=count,
    )
    return ActionMotion(chunk, times, states[:, :end], jerks[: end - 1], due, within)


def quick_enough(deviations: Sequence[float], duration: float, limits: JointLimits) -> tuple[float, ...]:
    """Return the first deviation, and those whose motions come near their targets in a duration [s].

    The time constant of a motion is the cubic root of deviation / jerk.
    """
    largest = _median_jerk(limits) * duration**3
    return tuple(each for each in deviations if each <= max(largest, deviations[0]))


@cached_per_value
def _median_jerk(limits: JointLimits) -> float:
    return float(np.median(limits.jerk))


def inset(targets: Floats, limits: JointLimits) -> Floats:
    inside = (targets >= limits.lower) & (targets <= limits.upper)
    lower, upper = _inset_limits(limits)
    return np.where(inside, np.minimum(np.maximum(targets, lower), upper), targets)


@cached_per_value
def _inset_limits(limits: JointLimits) -> tuple[Floats, Floats]:
    room = np.minimum(INSET, (limits.upper - limits.lower) / 4.0)
    return limits.lower + room, limits.upper - room


def joints_of(
    poses: Sequence[Placement], frame: str, begin: Floats, query: Evaluator, limits: JointLimits
) -> tuple[Floats, str]:
    """Return joint positions (K, n) of poses up to the first not reached, and the reason for it.

    Damped Gauss-Newton steps within the position limits. Source: Buss, Introduction to Inverse Kinematics
    with Jacobian Transpose, Pseudoinverse and Damped Least Squares methods, 2004, equation 11.

    Args:
        begin: Positions of the query's joints before, the group's n first.
    """
    joints = len(limits.joint_names)
    found, here, surroundings = list[Floats](), begin[:joints], begin[joints:]
    for number, pose in enumerate(poses):
        missed = np.inf
        for _ in range(ITERATIONS):
            tool = Tool.at(query, np.concatenate((here, surroundings)), frame, joints)
            at = tool.placement(frame)
            turned = as_rotation_vector(pose.rotation @ at.rotation.T)
            error = np.concatenate((pose.translation - at.translation, LENGTH * turned))
            missed = float(np.linalg.norm(error))
            if missed < REACHED / 10.0:
                break
            jacobian = tool.jacobian
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + DAMPING * np.eye(6), error)
            here = np.clip(here + step, limits.lower, limits.upper)
        if not missed <= REACHED:  # nor if it is not a number
            why = f"not reached: {1e3 * missed:.1f} mm remain" if np.isfinite(missed) else "not finite"
            return _rows(found, joints), f"tool pose {number} is {why}"
        found.append(here)
    return _rows(found, joints), ""


def _rows(found: list[Floats], joints: int) -> Floats:
    return np.array(found) if found else np.zeros((0, joints))
