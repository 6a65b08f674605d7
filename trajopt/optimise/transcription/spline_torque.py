"""Torques along a spline over time, as shares of the effort limits."""

from dataclasses import dataclass

import numpy as np

from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.problem.motion import Motion
from trajopt.values.arrays import Floats, Ints, Printed, Rows


@dataclass(frozen=True, eq=False)
class SplineTorque(Printed):
    """Torques at some moments of a motion whose knots are the control points of a spline.

    Attributes:
        dynamics: With what is carried; its owner's, so one per thread.
        support: The control points that each moment depends on, shape (s, k).
        weights: Their factors in position, velocity and acceleration there, shape (3, s, k).
        effort: Limits, shape (n,) [Nm | N]; inf for none.
        listed: Share from which on a torque gets a row.
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
        """Evaluate the moments, and differentiate by the control points where a joint needs much."""
        states = np.einsum("rsk,skn->rsn", self.weights, motion.knots[self.support])
        share = self.dynamics.torque(*states) / self.effort
        moment, joint = np.nonzero(np.abs(share) >= self.listed)
        near, which = np.unique(moment, return_inverse=True)
        slopes = self.dynamics.torque_slopes(*states[:, near])
        by_state = np.stack((slopes.position, slopes.velocity, slopes.acceleration))[:, which, joint]
        jacobian = np.einsum("rmn,rmk->mkn", by_state / self.effort[joint, None], self.weights[:, moment])
        return Rows(share[moment, joint], jacobian, self.support[moment], joint, self.place[moment])
