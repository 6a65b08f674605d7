"""Terms of a spline in time: derivatives of its positions, torques, and clearance from dynamic obstacles.

A derivative lies between its control points D^r c / T^r, linear in the control points c: bounds on these
bound the rate at all times.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.geometry import DynamicObstacles
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.terms.clearance import ACTIVATION
from trajopt.problem.motion import Motion, MotionInTime
from trajopt.values.arrays import Floats, Ints, Printed, Rows, Value
from trajopt.values.errors import ProblemError


@dataclass(frozen=True, eq=False)
class SplineRate(Value):
    """Control points of a derivative by time, one component a joint, as shares of its limit.

    Joints without a limit have no rows. The motion's knots are the control points of the spline.

    Attributes:
        name: The limit: "velocity limit".
        support: The control points that each of the derivative's depends on, shape (m, k).
        weight: Their factors in the derivative by the spline's parameter, shape (m, k).
        limit: Of the derivative by the spline's parameter, shape (n,); inf for none.
        place: Of each along the motion, in knots of a polyline, shape (m,).
    """

    name: str
    support: Ints
    weight: Floats
    limit: Floats
    place: Floats

    def linearise(self, motion: Motion) -> Rows:
        limited = np.flatnonzero(np.isfinite(self.limit))
        count, size = len(self.support), len(limited)
        factor = self.weight[:, None, :] / self.limit[limited][None, :, None]
        value = np.einsum("mjk,mkj->mj", factor, motion.knots[self.support][:, :, limited])
        jacobian = np.zeros((count, size, self.support.shape[1], motion.knots.shape[1]))
        jacobian[:, np.arange(size), :, limited] = np.swapaxes(factor, 0, 1)
        return Rows(
            value.ravel(),
            jacobian.reshape(count * size, *jacobian.shape[2:]),
            np.repeat(self.support, size, axis=0),
            np.tile(limited.astype(np.int64), count),
            np.repeat(self.place, size),
        )


@dataclass(frozen=True, eq=False)
class SplineTorque(Printed):
    """Torques at some moments of a motion whose knots are the control points of a spline.

    Attributes:
        dynamics: With the payload; its owner's, so one per thread.
        support: The control points that each moment depends on, shape (s, k).
        weights: Their factors in position, velocity and acceleration there, shape (3, s, k).
        listed: Share from which a torque gets a row.
        place: Of each moment along the motion, in knots of a polyline, shape (s,).
    """

    dynamics: DynamicsQuery
    support: Ints
    weights: Floats
    effort: Floats
    listed: float
    place: Floats
    name = "torque limit"

    def linearise(self, motion: Motion) -> Rows:
        states = np.einsum("rsk,skn->rsn", self.weights, motion.knots[self.support])
        share = self.dynamics.torque(*states) / self.effort
        moment, joint = np.nonzero(np.abs(share) >= self.listed)
        near, which = np.unique(moment, return_inverse=True)
        slopes = self.dynamics.torque_slopes(*states[:, near])
        by_state = np.stack((slopes.position, slopes.velocity, slopes.acceleration))[:, which, joint]
        jacobian = np.einsum("rmn,rmk->mkn", by_state / self.effort[joint, None], self.weights[:, moment])
        return Rows(share[moment, joint], jacobian, self.support[moment], joint, self.place[moment])


@dataclass(frozen=True, eq=False)
class ClearanceInTime(Printed):
    """Distance less error and margin of every pair that is near at a time at which both are present [m].

    Linearised as `Clearance`, with each obstacle at its place at the sample's time. Components are pair
    indices of the timed model.

    Attributes:
        margin: Clearance to keep, shape (p,) [m].
        duration: Of the motion [s].
    """

    obstacles: DynamicObstacles
    margin: Floats
    duration: float
    name = "clearance in time"
    units = ("m",)

    @cached_property
    def kept(self) -> Floats:
        """The margin of every pair, -inf for those that do not change, shape (p,) [m]."""
        return np.where(self.obstacles.pairs.changes, self.margin, -np.inf)

    @cached_property
    def reach(self) -> Floats:
        """Distance of interest of every pair, -inf for those that do not change, shape (p,) [m]."""
        return self.kept + ACTIVATION + self.obstacles.pairs.error_at(self.duration, slice(None))

    def linearise(self, motion: Motion) -> Rows:
        if not isinstance(motion, MotionInTime):
            raise ProblemError(f"{self.name}: the motion has no times")
        found = self.obstacles.contacts(
            motion.positions, motion.times, self.kept, within=ACTIVATION, until=self.duration
        )
        near = found.present
        return motion.rows(
            found.sample[near], found.least_spare[near], found.jacobian[near], found.pair[near]
        )
