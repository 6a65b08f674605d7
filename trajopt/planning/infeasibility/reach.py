"""Proofs that a point is out of reach: bounds of the length of a chain of joints."""

import numpy as np

from trajopt.problem.requirements import FramePlacement, PointOnArc, PositionInRegion, Requirement
from trajopt.robot.joints import joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.likely_units import meant_at_distance
from trajopt.values.placement import Placement
from trajopt.values.printed import in_length
from trajopt.values.shapes.shapes import Plane, bounding_sphere

ENDLESS = 1e6
"""Replaces a range without limits [rad | m]."""


class Chain:
    """Lengths of the chains of a reduced model.

    A point cannot be farther from a joint's origin than the offsets of all joints between are long
    together, with the range of those that slide.
    """

    def __init__(self, reduced: ReducedModel) -> None:
        """Measure each joint's offset from the one before."""
        model, limits = reduced.model, reduced.limits
        self._reduced = reduced
        # Joints without limits turn; one that slid along with them would be far beyond any bound.
        lower, upper = np.maximum(limits.lower, -ENDLESS), np.minimum(limits.upper, ENDLESS)
        ends = np.stack([reduced.mimic_matrix @ side + reduced.mimic_offset for side in (lower, upper)])
        names = list(model.names)[1:]
        self._slides = np.array([joint_unit(model, name) == "m" for name in names], dtype=np.bool_)
        farthest = np.abs(np.where(self._slides, ends, 0.0)).max(axis=0, initial=0.0)
        offsets = [
            np.linalg.norm(model.jointPlacements[joint].translation) for joint in range(1, model.njoints)
        ]
        self._offset, self._slide = np.array(offsets, dtype=np.float64), farthest

    def joints(self, joint: int) -> list[int]:
        """Return the joints that carry a joint, outermost first, with itself."""
        return [int(each) for each in self._reduced.model.supports[joint]][1:]

    def longest(self, first: int, joint: int, point: Floats) -> float:
        """Bound the distance of a point from the origin of a joint further out [m].

        Args:
            first: The joint further out, one of those that carry `joint`.
            joint: The joint that carries the point.
            point: In the frame of `joint`, shape (3,) [m].
        """
        chain = self.joints(joint)
        after = chain[chain.index(first) + 1 :]
        between = sum(self._offset[each - 1] + self._slide[each - 1] for each in after)
        return float(between + self._slide[first - 1] + np.linalg.norm(point))

    def levers(self, body: int) -> Floats:
        """Bound the motion of any point of a body when a joint of the group moves, shape (n,) [m/rad | 1].

        Turning by an angle moves a point by at most the angle times its distance from the axis.
        """
        reduced = self._reduced
        fixed, levers = reduced.bodies[body], np.zeros(len(reduced.joint_names))
        if isinstance(fixed.shape, Plane) or fixed.joint == 0:
            return levers if fixed.joint == 0 else np.full_like(levers, np.inf)
        centre, radius = bounding_sphere(fixed.shape)
        return self.point_levers(fixed.joint, fixed.placement * centre, radius)

    def point_levers(self, carrier: int, point: Floats, radius: float = 0.0) -> Floats:
        """Bound the motion of points of a ball when a joint of the group moves, shape (n,) [m/rad | 1].

        Args:
            carrier: The joint that carries the ball; 0 for the world.
            point: Its centre in the joint's frame, shape (3,) [m].
            radius: Its radius [m].
        """
        levers, away = np.zeros(len(self._reduced.joint_names)), float(np.linalg.norm(point)) + radius
        for joint in reversed(self.joints(carrier)):
            away += self._slide[joint - 1]
            arm = 1.0 if self._slides[joint - 1] else away
            levers += np.abs(self._reduced.mimic_matrix[joint - 1]) * arm
            away += self._offset[joint - 1]
        return levers

    def turns(self, carrier: int) -> Floats:
        """Bound the rotation of a joint's children when a joint of the group moves, shape (n,) [rad/rad]."""
        turns = np.zeros(len(self._reduced.joint_names))
        for joint in self.joints(carrier):
            if not self._slides[joint - 1]:
                turns += np.abs(self._reduced.mimic_matrix[joint - 1])
        return turns


ACCURACY = 1e-6
"""A smaller distance beyond reach proves nothing [m]."""


def out_of_reach(required: Requirement, reduced: ReducedModel) -> str:
    """Return how far a requirement is out of reach, as a sentence; empty if there is no proof.

    The bound is the sum of the lengths of the chain, so it is generous: excluded goals are out of reach.
    """
    balls = _balls(required)
    if not balls or not isinstance(required, FramePlacement | PositionInRegion | PointOnArc):
        return ""
    reference, where = reduced.attachment(required.reference)
    carrier, place = reduced.attachment(required.frame)
    if reference != 0 or carrier == 0:
        return ""
    chain = Chain(reduced)
    first = chain.joints(carrier)[0]
    origin = reduced.model.jointPlacements[first].translation
    length = chain.longest(first, carrier, place * required.offset)
    missing = min(
        float(np.linalg.norm(where * centre - origin)) - radius - length for centre, radius in balls
    )
    if missing <= ACCURACY:
        return ""
    return (
        f"{required.frame} would have to be at least {length + missing:.3f} m from "
        f"{reduced.model.names[first]}, but the arm is only {length:.3f} m long from there: "
        f"{in_length(missing)} too short{meant_at_distance(length + missing, length)}"
    )


def _balls(required: Requirement) -> tuple[tuple[Floats, float], ...]:
    """Return balls in the reference that hold all possible places of the point; none if unbounded."""
    if isinstance(required, FramePlacement):
        radius = float(np.linalg.norm(required.position_tolerance))
        return ((required.placement.translation, radius),) if np.isfinite(radius) else ()
    if isinstance(required, PointOnArc):
        return ((required.centre.translation, required.radius + required.tolerance),)
    if isinstance(required, PositionInRegion):
        if any(isinstance(shape, Plane) for shape, _ in required.members):
            return ()
        spheres = [(bounding_sphere(shape), where) for shape, where in required.members]
        return tuple((_moved(where, centre), radius) for (centre, radius), where in spheres)
    return ()


def _moved(where: Placement, point: Floats) -> Floats:
    return where * point
