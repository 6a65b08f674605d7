"""The judge's check of `JointPositions`: joints at positions, within tolerances on either side."""

import numpy as np

from trajopt.problem.requirements import JointPositions
from trajopt.robot.loading.pinocchio_model import joint_unit
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_unit
from trajopt.verify.certificate import Check, Evidence
from trajopt.verify.checks.quantities import Quantity, check_requirement, quantities
from trajopt.verify.checks.requirement import When, proof_at_end
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.polynomials import Extremes
from trajopt.verify.search.interval_proof import Proof


@quantities.register
def _(requirement: JointPositions, motion: Motion) -> tuple[Quantity, ...]:
    joints = tuple(requirement.positions)
    matrix, offset = joint_rows(motion, joints)
    wanted = np.array([requirement.positions[joint] for joint in joints])
    below = np.array([requirement.below[joint] for joint in joints])
    above = np.array([requirement.above[joint] for joint in joints])

    def states(times: Floats) -> Floats:
        return motion.trajectory(times) @ matrix.T + offset - wanted

    return (
        Quantity(
            kind="joints",
            name="deviation beyond the tolerance",
            subject=", ".join(joints),
            unit="",
            limit=0.0,
            states=states,
            number=lambda off: np.maximum(off - above, -below - off).max(axis=1),
            bound=None,
        ),
    )


@check_requirement.register
def _(requirement: JointPositions, motion: Motion, when: When) -> tuple[Check, ...]:
    reduced, joints = motion.reduced, tuple(requirement.positions)
    matrix, offset = joint_rows(motion, joints)
    wanted = np.array([requirement.positions[joint] for joint in joints])
    least = wanted - np.array([requirement.below[joint] for joint in joints])
    most = wanted + np.array([requirement.above[joint] for joint in joints])
    if when is When.END:
        values = matrix @ motion.trajectory.positions[-1] + offset
        high = low = Extremes(values, np.full(len(joints), motion.duration))
    else:
        high, low = motion.group[0].combined(matrix, offset).extremes()
    over, under = high.values - most, least - low.values
    joint = int(np.argmax(np.maximum(over, under)))
    above = over[joint] >= under[joint]
    excess = float(max(over[joint], under[joint]))
    side, bound = (high, most) if above else (low, least)
    proof = proof_at_end(motion, excess)
    if when is When.ALWAYS:
        proof = Proof(Evidence.PROVEN, float(side.times[joint]), None)
    unit = joint_unit(reduced.scene.robot.model, joints[joint])
    return (
        Check(
            name=f"{when.value}: joints",
            subject=joints[joint],
            value=float(side.values[joint]),
            bound=float(bound[joint]),
            unit=unit,
            time=proof.time,
            slack=-excess,
            evidence=proof.evidence,
            holds=excess <= motion.options.excess,
            detail=f"must not {'exceed' if above else 'fall below'} {in_unit(float(bound[joint]), unit)}",
        ),
    )


def joint_rows(motion: Motion, joints: tuple[str, ...]) -> tuple[Floats, Floats]:
    """Express positions of named joints by the group's: matrix (m, n) and offset (m,).

    Raises:
        JointNotFound: If a name is no movable joint of the robot.
    """
    reduced = motion.reduced
    index = reduced.scene.robot.index(joints)
    matrix = np.zeros((len(joints), len(reduced.joint_names)))
    offset = np.array(reduced.start[index])
    moved = reduced.moving_joints
    for row, joint in enumerate(joints):
        if joint in moved:
            place = moved.index(joint)
            matrix[row], offset[row] = reduced.mimic_matrix[place], reduced.mimic_offset[place]
    return matrix, offset
