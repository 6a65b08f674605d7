"""The next joint targets of a policy, and the smooth motion through them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.driving.servo_task import Tool
from trajopt.geometry import Evaluator
from trajopt.problem.requirements.joints import LENGTH
from trajopt.robot.joints import JointLimits
from trajopt.timing.time_scaling import stop_at_the_end, tracking
from trajopt.values.arrays import Bools, Floats, Value
from trajopt.values.cached import cached_per_value
from trajopt.values.placement import Placement, as_rotation_vector
from trajopt.values.trajectory import Trajectory

INSET = 1e-4
"""Distance from position limits that a motion keeps if the actions do not, as it overshoots at their end
[rad | m]: ten times the repeatability of an arm.
"""
DAMPING = 1e-6
"""Damping of inverse kinematics near singularities, squared [m^2]."""
ITERATIONS = 20
REACHED = 1e-4
"""Largest distance of the tool from a pose that counts as reached, a radian counting as `LENGTH` [m]."""


@dataclass(frozen=True, eq=False)
class ActionChunk(Value):
    """The next joint targets (K, n) of a policy [rad | m], at times (K,) of the executor's clock [s]."""

    targets: Floats
    times: Floats

    def after(self, time: float) -> "ActionChunk":
        later = self.times > time
        return ActionChunk(self.targets[later], self.times[later])

    def up_to(self, limits: JointLimits) -> "ActionChunk | None":
        """Return the actions before the first that is beyond a position limit; None if that is the first."""
        beyond: Bools = np.any((self.targets < limits.lower) | (self.targets > limits.upper), axis=1)
        count = int(beyond.argmax()) if beyond.any() else len(self.times)
        return ActionChunk(self.targets[:count], self.times[:count]) if count else None

    def slowed(self, begin: float, rate: float) -> "ActionChunk":
        return ActionChunk(self.targets, begin + (self.times - begin) / rate)

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
    """A motion along a chunk of actions, with constant jerks from one action to the next.

    Attributes:
        times: Of begin and actions, since the begin, shape (K + 1,) [s].
        states: Positions, velocities and accelerations then, shape (3, K + 1, n).
        jerks: From each time to the next, shape (K, n).
        within: Number of actions up to the first at which a limit is exceeded.
    """

    chunk: ActionChunk
    times: Floats
    states: Floats
    jerks: Floats
    within: int

    def first(self, count: int, limits: JointLimits) -> Trajectory:
        return stop_at_the_end(self.times[: count + 1], self.states[:, : count + 1], limits)


def along_actions(
    begin: Floats, time: float, chunk: ActionChunk, deviations: Sequence[float], limits: JointLimits
) -> ActionMotion:
    """Return the motion from a state that stays near the actions with small jerks.

    It minimises the sum over the actions of (q_k - a_k)^2 / deviation^2 + j_k^2 / J^2, where j_k are the
    constant jerks from one action to the next and J is the median of the jerk limits. The first deviation
    counts for which all actions are within the limits, or else most of them.

    Args:
        chunk: The actions, all later.
        deviations: Each weighs as much as a jerk J [rad | m].
        limits: With the jerk of each joint limited.
    """
    times = np.concatenate(((0.0,), chunk.times - time))
    weights = np.array(deviations) / _median_jerk(limits)
    return ActionMotion(chunk, times, *tracking(begin, times, inset(chunk.targets, limits), weights, limits))


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
