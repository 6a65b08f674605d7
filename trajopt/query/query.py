"""Query: what is asked of a robot among its obstacles, the same of the compiled body and the plain one."""

from abc import ABC, abstractmethod

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.model.reduced import ReducedModel
from trajopt.query.contacts import Contacts
from trajopt.query.kinematics import Counts, Kinematics


class Query(ABC):
    """Numbers of given configurations of a reduced model; owns scratch memory, so one per thread.

    Attributes:
        reduced: The robot and its surroundings.
        counts: The work done so far.
    """

    def __init__(self, reduced: ReducedModel, counts: Counts | None = None) -> None:
        """Note which joints carry which."""
        self.reduced = reduced
        self.counts = Counts() if counts is None else counts
        self._supports = reduced.derived(_supports)

    @abstractmethod
    def kinematics(self, positions: Floats) -> Kinematics:
        """Place all joints at configurations.

        Args:
            positions: The group's positions, shape (S, n) [rad | m].
        """

    @abstractmethod
    def near(self, positions: Floats, reach: Floats) -> Contacts:
        """Measure every pair that is nearer than its reach.

        Args:
            positions: S configurations of the group, shape (S, n) [rad | m]. Asking again at as
                many that lie near the last ones is cheaper, and answers the same.
            reach: Distance of interest, one for each pair, shape (p,) [m].

        Returns:
            One contact for each configuration and pair with a signed distance below the reach, in
            no particular order.
        """

    @abstractmethod
    def displacement(self, start: Floats, end: Floats) -> Floats:
        """Bound how far any point of a body is from where it is at other configurations.

        The bound |dc| + |dR|_F / sqrt(2) r holds for the chord between the two placements: c is
        the body's centre, r the radius of its bounding sphere.

        Args:
            start: S configurations, shape (S, n) [rad | m].
            end: As many others, shape (S, n).

        Returns:
            Largest bound over all bodies that move, shape (S,) [m].
        """

    def point_jacobian(self, jacobian: Floats, joints: Ints, points: Floats) -> Floats:
        """Return Jacobians of points carried by joints, by the group's positions.

        The velocity of a point p is v + w x p with (v, w) the spatial velocity at the origin.

        Args:
            jacobian: Of `Kinematics`, one for each point, shape (m, 6, model joints).
            joints: The joint that carries each point, shape (m,).
            points: In the world, shape (m, 3) [m].

        Returns:
            Shape (m, 3, n) [m/rad | m/m].
        """
        linear, angular = jacobian[:, :3], jacobian[:, 3:]
        moved = linear + np.cross(angular, points[:, :, None], axisa=1, axisb=1, axisc=1)
        return (moved * self._supports[joints][:, None, :]) @ self.reduced.mimic_matrix

    def angular_jacobian(self, jacobian: Floats, joint: int) -> Floats:
        """Return Jacobians of a joint's angular velocity in the world, shape (m, 3, n)."""
        return (jacobian[:, 3:] * self._supports[joint]) @ self.reduced.mimic_matrix


def _supports(reduced: ReducedModel) -> Floats:
    """Return 1 where a joint carries another, shape (joints, model joints)."""
    model = reduced.model
    supports = np.zeros((model.njoints, model.nv))
    for joint in range(1, model.njoints):
        for ancestor in list(model.supports[joint])[1:]:
            supports[joint, model.joints[ancestor].idx_v] = 1.0
    return supports
