"""The judge's check of `AxisAlignment`: an axis of a frame within a cone about a direction."""

import numpy as np

from trajopt.problem.requirements import AxisAlignment
from trajopt.values.arrays import Floats
from trajopt.verify.certificate import Check
from trajopt.verify.checks.quantities import Quantity, check_requirement, quantities
from trajopt.verify.checks.requirement import Component, When, proof_at_end, requirement_check
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.relative_motion import RelativeMotion
from trajopt.verify.search.interval_proof import Excess, prove_over_time


@quantities.register
def _(requirement: AxisAlignment, motion: Motion) -> tuple[Quantity, ...]:
    moving = RelativeMotion(motion, requirement.frame, reference=requirement.reference, offset=np.zeros(3))
    return (
        Quantity(
            kind="axis",
            name="angle to the direction",
            subject=requirement.frame,
            unit="rad",
            limit=requirement.tolerance,
            states=lambda times: moving.placements(times)[0] @ requirement.axis,
            number=lambda axes: _angles(axes, requirement.direction),
            bound=None,
        ),
    )


@check_requirement.register
def _(requirement: AxisAlignment, motion: Motion, when: When) -> tuple[Check, ...]:
    moving = RelativeMotion(motion, requirement.frame, reference=requirement.reference, offset=np.zeros(3))

    def axes(times: Floats) -> Floats:
        return moving.placements(times)[0] @ requirement.axis

    def excess(begin: Floats, end: Floats) -> Excess:
        times = np.concatenate((begin, (begin + end) / 2, end))
        angles = np.stack(np.split(_angles(axes(times), requirement.direction), 3))
        bounds = moving.bounds(begin, end)
        bulge = (bounds.turn_acceleration + bounds.turn_rate**2) * (end - begin) ** 2 / 8.0
        upper = np.minimum(angles[1] + bounds.turn, _chord_bound(angles[[0, 2]].max(axis=0), bulge))
        worst = angles.argmax(axis=0)
        rows = np.arange(len(begin))
        tolerance = requirement.tolerance
        return Excess(
            angles[worst, rows] - tolerance,
            times.reshape(3, -1)[worst, rows],
            upper - tolerance,
        )

    if when is When.END:
        reached = _angles(axes(np.array((motion.duration,))), requirement.direction)[0]
        proof = proof_at_end(motion, float(reached) - requirement.tolerance)
    else:
        proof = prove_over_time(motion, excess)
    angle = float(_angles(axes(np.array((proof.time,))), requirement.direction)[0])
    return (
        requirement_check(
            when,
            kind="axis",
            subject=requirement.frame,
            unit="rad",
            component=Component("angle to the direction", angle, requirement.tolerance),
            proof=proof,
        ),
    )


def _angles(axes: Floats, direction: Floats) -> Floats:
    """Angles between axes (c, 3) and a direction (3,), both of length one, accurate near 0 and pi."""
    return np.arctan2(np.linalg.norm(np.cross(axes, direction), axis=1), axes @ direction)


def _chord_bound(angle: Floats, bulge: Floats) -> Floats:
    """Bound the angle over intervals at whose ends it is at most `angle`.

    The axis is off the chord between its ends by at most `bulge`, so its part along the direction is
    at least cos(angle) - bulge, and its part across at most sin(angle) + bulge if angle <= pi / 2.
    """
    along = np.arccos(np.clip(np.cos(angle) - bulge, -1.0, 1.0))
    across = np.arcsin(np.minimum(np.sin(angle) + bulge, 1.0))
    return np.where((angle <= np.pi / 2) & (along < np.pi / 2), np.minimum(along, across), along)
