"""Kinematics, distances and bounds of motion at many configurations.

`Problem.evaluator` makes the one for planning, for example on a GPU. The judge has its own kinematics and
distances, so a wrong evaluator cannot lead to a wrong proof.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Value


@dataclass(eq=False)
class WorkCounts:
    """Exact counts of the work done so far; the same on every machine.

    Attributes:
        forward_kinematics: Configurations at which all joints were placed.
        bounds: Bounds of distance by spheres, boxes and directions, evaluated before any measurement.
        distances: Calls of Coal's distance function.
    """

    forward_kinematics: int = 0
    bounds: int = 0
    distances: int = 0

    def since(self, before: "WorkCounts") -> "WorkCounts":
        """Return the work done since an earlier count."""
        return WorkCounts(
            self.forward_kinematics - before.forward_kinematics,
            self.bounds - before.bounds,
            self.distances - before.distances,
        )


@dataclass(frozen=True, eq=False)
class JointPlacements(Value):
    """Joint placements and Jacobians at S configurations of a reduced model with J joints.

    Attributes:
        rotation: Of each joint frame (the world first), shape (S, J, 3, 3).
        translation: Shape (S, J, 3) [m].
        jacobian: Spatial velocity at the world's origin (linear, angular) of each of the model's
            joints at unit speed, shape (S, 6, model joints).
    """

    rotation: Floats
    translation: Floats
    jacobian: Floats

    def take(self, index: Ints) -> "JointPlacements":
        """Return the placements of the configurations with these indices."""
        return JointPlacements(self.rotation[index], self.translation[index], self.jacobian[index])


@dataclass(frozen=True, eq=False)
class Contacts(Value):
    """Nearest points of pairs that come near each other, at many configurations.

    Attributes:
        sample: Configuration of each contact, shape (m,).
        pair: Index of the pair, shape (m,).
        distance: Signed: positive apart, negative in penetration, shape (m,) [m]; inside an exact
            mesh minus the way to its surface.
        normal: Unit vector from the first body to the second, Coal's own (rebuilt from the
            witness points it would flip in penetration), the other way inside an exact mesh, in
            the world, shape (m, 3).
        point_first: Witness point on the first body, in the world, shape (m, 3) [m].
        point_second: Witness point on the second body, in the world, shape (m, 3) [m].
        jacobian: Derivative of the distance by the group's positions, shape (m, n) [m/rad | 1].
    """

    sample: Ints
    pair: Ints
    distance: Floats
    normal: Floats
    point_first: Floats
    point_second: Floats
    jacobian: Floats


class Evaluator(Protocol):
    """Evaluates configurations of a reduced model; owns scratch memory, so one per thread."""

    reduced: ReducedModel
    counts: WorkCounts

    @property
    def dynamics(self) -> DynamicsQuery:
        """Inverse dynamics of the robot with its attached objects."""
        ...

    def kinematics(self, positions: Floats) -> JointPlacements:
        """Place all joints at configurations.

        Args:
            positions: The group's positions, shape (S, n) [rad | m].
        """
        ...

    def close_pairs(self, positions: Floats, reach: Floats, aim: Floats | None = None) -> Contacts:
        """Measure every pair nearer than its reach.

        Args:
            positions: S configurations of the group, shape (S, n) [rad | m].
            reach: Distance of interest, one for each pair, shape (p,) [m].
            aim: Clearance that the caller wants each pair to keep, shape (p,) [m]. A larger distance may be
                reported up to a third of its excess too small; all distances are exact when None.

        Returns:
            At least one contact for each configuration and pair with a signed distance below the reach, the
            nearest included, in any order.
        """
        ...

    def displacement(self, start: Floats, end: Floats) -> Floats:
        """Bound how far any point of a body is from its place at other configurations.

        Args:
            start: S configurations, shape (S, n) [rad | m].
            end: As many others, shape (S, n).

        Returns:
            Largest bound over all bodies that move, shape (S,) [m].
        """
        ...


class MakesEvaluator(Protocol):
    """Makes evaluators, as `trajopt.geometry.evaluator` does."""

    def __call__(self, reduced: ReducedModel, counts: WorkCounts | None = None, /) -> Evaluator:
        """Return an evaluator for one thread."""
        ...


def point_jacobian(reduced: ReducedModel, jacobian: Floats, joints: Ints, points: Floats) -> Floats:
    """Return Jacobians of points carried by joints, by the group's positions.

    The velocity of a point p is v + w x p with (v, w) the spatial velocity at the origin.

    Args:
        jacobian: Of `JointPlacements`, one for each point, shape (m, 6, model joints).
        joints: The joint that carries each point, shape (m,).
        points: In the world, shape (m, 3) [m].

    Returns:
        Shape (m, 3, n) [m/rad | m/m].
    """
    linear, angular = jacobian[:, :3], jacobian[:, 3:]
    moved = linear + np.cross(angular, points[:, :, None], axisa=1, axisb=1, axisc=1)
    return (moved * reduced.derived_of_robot(_supports)[joints][:, None, :]) @ reduced.mimic_matrix


def angular_jacobian(reduced: ReducedModel, jacobian: Floats, joint: int) -> Floats:
    """Return Jacobians of a joint's angular velocity in the world, shape (m, 3, n)."""
    return (jacobian[:, 3:] * reduced.derived_of_robot(_supports)[joint]) @ reduced.mimic_matrix


def _supports(reduced: ReducedModel) -> Floats:
    model = reduced.model
    supports = np.zeros((model.njoints, model.nv))
    for joint in range(1, model.njoints):
        for ancestor in list(model.supports[joint])[1:]:
            supports[joint, model.joints[ancestor].idx_v] = 1.0
    return supports
