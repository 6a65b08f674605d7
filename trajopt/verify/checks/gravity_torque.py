"""The judge's check of `GravityTorque`, at samples: inverse dynamics of the arm at rest."""

from dataclasses import replace

import numpy as np

from trajopt.problem.requirements import GravityTorque
from trajopt.values.arrays import Floats
from trajopt.verify.certificate import Check
from trajopt.verify.checks.joint_torques import torques_at_rest
from trajopt.verify.checks.quantities import Quantity, check_requirement, quantities
from trajopt.verify.checks.requirement import When
from trajopt.verify.kernel.motion import Motion


@quantities.register
def _(requirement: GravityTorque, motion: Motion) -> tuple[Quantity, ...]:
    return (
        Quantity(
            kind="gravity torque",
            name="largest share of an effort limit",
            subject="",
            unit="",
            limit=requirement.share,
            states=lambda times: _shares(motion, times),
            number=lambda shares: shares.max(axis=1),
            bound=None,
        ),
    )


@check_requirement.register
def _(requirement: GravityTorque, motion: Motion, when: When) -> tuple[Check, ...]:
    (quantity,) = quantities(requirement, motion)
    found = quantity.check(motion, when)
    shares = quantity.states(np.array((found.time or 0.0,)))[0]
    joint = motion.reduced.joint_names[int(shares.argmax())]
    return (replace(found, subject=joint),)


def _shares(motion: Motion, times: Floats) -> Floats:
    """Torque at rest of each of the group's joints, as a share of its limit, shape (c, n)."""
    return np.abs(torques_at_rest(motion.kinematics, motion.trajectory(times))) / motion.reduced.limits.effort
