"""Stops: along the proven path, or of each joint as fast as its limits allow."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.native import timing
from trajopt.robot.joints import EXCESS, JointLimits
from trajopt.values.arrays import Floats, Value
from trajopt.values.cached import cached_per_value
from trajopt.values.trajectory import Trajectory

MOMENT = 0.02
"""Interval between the times at which braking may begin [s]."""
STEP = 1e-3
"""Time step of the braking, the cycle of the fastest controllers [s]."""
RAMP = 0.01
"""Shortest time in which an acceleration rises from zero to its limit if jerk limits allow less; a few steps,
which resolve it [s].
"""
SHARES = (0.97, 0.8, 0.6, 0.4)
"""Shares of the limits that braking is tried with. The first leaves room for extremes between steps; the
others leave time to release the brake under tight jerk limits.
"""
KEPT_STEPS = (5, 3, 2, 1)
"""Steps per point of the stop motion, as few points are judged faster; decreased if the limits are exceeded
between points.
"""
KEPT = 0.9
"""Share of the jerk limits that is used, as a reserve for extremes between steps."""


@dataclass(frozen=True, eq=False)
class PathStop(Value):
    """A motion that comes to rest before its end.

    Attributes:
        trajectory: From the requested time, at which its own clock shows 0, to rest.
        leaves: Time up to which it equals the original motion, on the clock of the original [s].
    """

    trajectory: Trajectory
    leaves: float


@dataclass(frozen=True, eq=False)
class StopsAlong(Value):
    """The earliest stops of a motion along its own path, tabulated on first use.

    A braking motion follows the path while its clock rate r falls (`trajopt.timing.time_scaling`). Each step
    takes the smallest slope w = r. that the limits allow. With w = 0 the acceleration limits always hold, as
    they hold for the motion and r is at most 1; so no other feasible braking is shorter (Bobrow, Dubowsky and
    Gibson, "Time-optimal control of robotic manipulators along specified paths", International Journal of
    Robotics Research 4, 1985). At the end w rises within the jerk limits: w >= -sqrt(2 r w.), with the
    largest feasible w.

    Attributes:
        trajectory: The motion; it ends at rest.
    """

    trajectory: Trajectory
    limits: JointLimits

    def earliest(self, time: float, *, after: float | None = None) -> PathStop:
        """Return the motion from a given time on, stopped along its path.

        Args:
            time: Time of the motion, before its end [s].
            after: Time until which it continues unchanged [s]; the earliest possible by default.
        """
        found, names = (
            self._core.earliest(time, time if after is None else after),
            self.trajectory.joint_names,
        )
        if found is None:
            duration = self.trajectory.duration
            return PathStop(self.trajectory.between(time, duration), duration)
        *points, leaves = found
        return PathStop(Trajectory(names, *points), leaves)

    @cached_property
    def _core(self) -> timing.Stops:
        own = self.trajectory.coefficients
        quintics = np.concatenate((np.zeros((6 - len(own), *own.shape[1:])), own))
        return timing.Stops(
            self.trajectory.times,
            quintics,
            self.limits.acceleration,
            self.limits.jerk,
            shares=SHARES,
            every=KEPT_STEPS,
            ramp=RAMP,
            kept=KEPT,
            step=STEP,
            moment=MOMENT,
            excess=EXCESS,
        )


TICK = 1e-3
"""Pieces of a stop last multiples of this, the cycle of the fastest controllers [s].

In much shorter pieces the jerk of a polynomial is lost to rounding.
"""


def stop_from(begin: Floats, limits: JointLimits) -> Trajectory:
    """Return a motion that stops the joints as fast as their limits allow.

    It has three pieces of constant jerk: ramp up, hold and ramp down the deceleration. All joints brake
    together, which nearly preserves the direction of motion; if this violates a limit, each brakes alone.

    Args:
        begin: Positions, velocities and accelerations, shape (3, n).
        limits: Joint limits, with finite acceleration and jerk limits.
    """
    times, rows = timing.stop_from(begin, _rows(limits), TICK, EXCESS)
    return Trajectory(limits.joint_names, times, *rows)


def stop_after(begin: Floats, end: Floats, duration: float, limits: JointLimits) -> Trajectory:
    """Return a motion of one piece, followed by the stop of `stop_from`.

    Args:
        begin: Positions, velocities and accelerations at the start, shape (3, n).
        end: Those at the end of the piece, shape (3, n).
        duration: Duration of the piece [s].
        limits: Joint limits, with finite acceleration and jerk limits.
    """
    times, rows = timing.stop_from(end, _rows(limits), TICK, EXCESS)
    whole = np.concatenate((begin[:, None], rows), axis=1)
    return Trajectory(limits.joint_names, np.append(0.0, duration + times), *whole)


@cached_per_value
def _rows(limits: JointLimits) -> Floats:
    return np.stack((limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk))
