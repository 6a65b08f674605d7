"""Configurations in which a motion along a curve can begin."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.cartesian.on_curve import OnCurve
from trajopt.kinematics.goal_candidates import goal_candidates
from trajopt.model.requirements import Requirement, axis_alignment, frame_placement
from trajopt.query import Counts

CONE = 1e-4
"""How well the axis of a free spin is aligned before Newton's method takes over [rad]."""


def beginnings(on_curve: OnCurve, *, most: int, rng: np.random.Generator, counts: Counts) -> Floats:
    """Search clear configurations at the beginning of the curve, nearest to the start first, shape (b, n).

    Args:
        on_curve: The curve and the arm.
        most: How many at most.
        rng: Draws the starts of the search.
        counts: Takes the work done.
    """
    found = goal_candidates(on_curve.reduced, _at_beginning(on_curve), rng=rng, counts=counts)
    if not found.free:
        return np.empty((0, len(on_curve.reduced.joint_names)))
    drawn = np.array(found.free[:most])
    exact = on_curve(drawn, np.zeros(len(drawn)))
    return exact.positions[exact.held]


def _at_beginning(on_curve: OnCurve) -> tuple[Requirement, ...]:
    """What must hold there, in requirements that the search knows well."""
    need = on_curve.required
    place = need.curve.placement(0.0)
    turned = need.rotation_tolerance if need.spin is None else np.inf
    placed = frame_placement(
        need.frame,
        place,
        reference=need.reference,
        offset=need.offset,
        position_tolerance=need.position_tolerance,
        rotation_tolerance=turned,
    )
    if need.spin is None or np.isinf(need.rotation_tolerance):
        return (placed,)
    direction = place.rotation @ need.spin
    return (
        placed,
        axis_alignment(
            need.frame, axis=need.spin, direction=direction, reference=need.reference, tolerance=CONE
        ),
    )
