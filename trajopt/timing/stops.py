"""Stops along the path: how soon a motion can come to rest without leaving the path that was proven."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.native import timing
from trajopt.robot.limits import EXCESS, JointLimits
from trajopt.values.arrays import Value
from trajopt.values.trajectory import Trajectory

MOMENT = 0.02
"""Time between the moments at which braking may begin [s]: that much later it begins at most."""
STEP = 1e-3
"""Time step of the braking [s], the cycle of the fastest controllers."""
RAMP = 0.01
"""An acceleration takes at least so long to rise from nothing to its limit, where jerks could be larger [s]:
some steps, which show it."""
SHARES = (0.97, 0.8, 0.6, 0.4)
"""Shares of the limits that braking is tried with. The first leaves room for what lies between steps; the
others, where jerks are limited tightly, for letting go of the brake in time."""
KEPT_STEPS = (5, 3, 2, 1)
"""Each so many steps are a point of the motion: few are judged sooner; where what lies between them is not
within the limits, more are taken."""
KEPT = 0.9
"""Share of the jerk limits that is used: what lies between two steps is near to what is at them."""


@dataclass(frozen=True, eq=False)
class PathStop(Value):
    """A motion that comes to rest before its end.

    Attributes:
        trajectory: From the time that was asked for, at which its own clock shows 0, to rest.
        leaves: Until then it is the motion as it was, on the clock of that [s].
    """

    trajectory: Trajectory
    leaves: float


@dataclass(frozen=True, eq=False)
class StopsAlong(Value):
    """The earliest stops of a motion along its own path, each tabulated when it is first asked for.

    A braking motion follows the path while the rate r of its clock falls (`trajopt.timing.time_scaling`). In
    each step the slope w = r. is the least that the limits allow. With w = 0 the limits of acceleration
    always hold, as they hold for the motion and r is at most 1; so within them every other way to brake takes
    longer (Bobrow, Dubowsky and Gibson, "Time-optimal control of robotic manipulators along specified paths",
    International Journal of Robotics Research 4, 1985). At the end w rises so that the jerk stays limited: w
    >= -sqrt(2 r w.), with the largest w. there.

    Attributes:
        trajectory: The motion; it ends at rest.
        limits: Of its joints.
    """

    trajectory: Trajectory
    limits: JointLimits

    def earliest(self, time: float, *, after: float | None = None) -> PathStop:
        """Return the motion from a time on, brought to rest on its path.

        Args:
            time: On the motion, before its end [s].
            after: Until then it goes on as it was [s]; no longer than it must when None.
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
