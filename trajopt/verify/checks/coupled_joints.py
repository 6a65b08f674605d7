"""The judge's check of `CoupledJoints`: the sum is a polynomial of time, its extremes are exact."""

import numpy as np

from trajopt.problem.requirements import CoupledJoints
from trajopt.verify.certificate import Check, Evidence
from trajopt.verify.checks.joint_positions import joint_rows
from trajopt.verify.checks.quantities import Quantity, check_requirement, quantities
from trajopt.verify.checks.requirement import Component, When, proof_at_end, requirement_check
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.search.interval_proof import Proof


@quantities.register
def _(requirement: CoupledJoints, motion: Motion) -> tuple[Quantity, ...]:
    joints = tuple(requirement.weights)
    matrix, offset = joint_rows(motion, joints)
    factors = np.array([requirement.weights[joint] for joint in joints])
    return (
        Quantity(
            kind="coupled joints",
            name="deviation of the sum",
            subject=" + ".join(joints),
            unit="",
            limit=requirement.tolerance,
            states=lambda times: (motion.trajectory(times) @ matrix.T + offset) @ factors,
            number=lambda sums: np.abs(sums - requirement.value),
            bound=None,
        ),
    )


@check_requirement.register
def _(requirement: CoupledJoints, motion: Motion, when: When) -> tuple[Check, ...]:
    (quantity,) = quantities(requirement, motion)
    end = float(quantity.number(quantity.states(np.array((motion.duration,))))[0])
    deviation, proof = end, proof_at_end(motion, end - requirement.tolerance)
    if when is When.ALWAYS:
        joints = tuple(requirement.weights)
        matrix, offset = joint_rows(motion, joints)
        factors = np.array([[requirement.weights[joint] for joint in joints]])
        total = motion.group[0].combined(factors @ matrix, factors @ offset - requirement.value)
        high, low = total.extremes()
        above = high.values[0] >= -low.values[0]
        deviation = float(high.values[0] if above else -low.values[0])
        time = float((high if above else low).times[0])
        holds = deviation <= requirement.tolerance + motion.options.excess
        proof = Proof(Evidence.PROVEN if holds else Evidence.SAMPLED, time, None)
    return (
        requirement_check(
            when,
            kind=quantity.kind,
            subject=quantity.subject,
            unit=quantity.unit,
            component=Component(quantity.name, deviation, requirement.tolerance),
            proof=proof,
        ),
    )
