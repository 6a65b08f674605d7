"""Checks of requirements on joints: positions, couplings, torques of gravity, singularities."""

from dataclasses import replace

import numpy as np

from trajopt.problem.requirements import CoupledJoints, GravityTorque, JointPositions, SingularityDistance
from trajopt.robot.joints import joint_unit
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_unit
from trajopt.verify.certificate import Check, Evidence
from trajopt.verify.checks.quantities import (
    Component,
    Quantity,
    When,
    check_requirement,
    proof_at_end,
    quantities,
    requirement_check,
)
from trajopt.verify.checks.torques import torques_at_rest
from trajopt.verify.kernel.interval_proof import Proof
from trajopt.verify.kernel.motion import Extremes, JudgedMotion


@quantities.register
def _(requirement: JointPositions, motion: JudgedMotion) -> tuple[Quantity, ...]:
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
def _(requirement: JointPositions, motion: JudgedMotion, when: When) -> tuple[Check, ...]:
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


def joint_rows(motion: JudgedMotion, joints: tuple[str, ...]) -> tuple[Floats, Floats]:
    """Express positions of named joints by the group's: matrix (m, n) and offset (m,)."""
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


@quantities.register
def _(requirement: CoupledJoints, motion: JudgedMotion) -> tuple[Quantity, ...]:
    """The sum is a polynomial of time, whose extremes are exact."""
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
def _(requirement: CoupledJoints, motion: JudgedMotion, when: When) -> tuple[Check, ...]:
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


@quantities.register
def _(requirement: GravityTorque, motion: JudgedMotion) -> tuple[Quantity, ...]:
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
def _(requirement: GravityTorque, motion: JudgedMotion, when: When) -> tuple[Check, ...]:
    (quantity,) = quantities(requirement, motion)
    found = quantity.check(motion, when)
    shares = quantity.states(np.array((found.time or 0.0,)))[0]
    joint = motion.reduced.joint_names[int(shares.argmax())]
    return (replace(found, subject=joint),)


def _shares(motion: JudgedMotion, times: Floats) -> Floats:
    return np.abs(torques_at_rest(motion.kinematics, motion.trajectory(times))) / motion.reduced.limits.effort


@quantities.register
def _(requirement: SingularityDistance, motion: JudgedMotion) -> tuple[Quantity, ...]:
    """Bound how fast the least singular value changes: by no more than the matrix does (Weyl).

    Column j of the Jacobian is (velocity of the point, length times axis) of joint j at unit speed. While
    joints move by at most delta_i, the axis of j turns by at most the sum of delta_i over the turning
    joints nearer to the base. The velocity of the point changes at a rate of at most r per unit of joint i,
    where r bounds the velocity that the outer of i and j gives, if the inner one turns; it is constant if
    that slides.
    """
    columns = _Columns(requirement, motion)

    def bound(begin: Floats, end: Floats, matrices: Floats) -> Floats:
        change = columns.change((begin + end) / 2.0, motion.deviation(begin, end))
        return requirement.smallest - (_smallest(matrices[1]) - change)

    return (
        Quantity(
            kind="singularity",
            name="smallest singular value",
            subject=requirement.frame,
            unit="m/rad",
            limit=requirement.smallest,
            states=columns.matrices,
            number=_smallest,
            bound=bound,
            least=True,
        ),
    )


def _smallest(matrices: Floats) -> Floats:
    return np.asarray(np.linalg.svd(matrices, compute_uv=False)[..., -1], dtype=np.float64)


class _Columns:
    def __init__(self, requirement: SingularityDistance, motion: JudgedMotion) -> None:
        self._motion, self._length = motion, requirement.length
        self._joint, place = motion.reduced.attachment(requirement.frame)
        self._point = place * requirement.offset
        self._chain = motion.kinematics.chain(self._joint)[::-1]
        self._turns = motion.kinematics.revolute[list(self._chain)]
        self._mimic_matrix = motion.reduced.mimic_matrix[[joint - 1 for joint in self._chain]]

    def matrices(self, times: Floats) -> Floats:
        """Return the Jacobian at times (c,): shape (c, 6, n), or (c, 3, n) without rotation."""
        axis, arm = self._axes(times)
        turns = self._turns[None, :, None]
        linear = np.where(turns, np.cross(axis, arm), axis)
        rows = np.concatenate((linear, self._length * axis * turns), axis=2)
        rows = rows if self._length > 0.0 else linear
        return np.einsum("ckd,kn->cdn", rows, self._mimic_matrix)

    def change(self, middle: Floats, moved: Floats) -> Floats:
        """Bound the norm of the change while joints move from positions at times (c,) by `moved`, shape (c,).

        The Frobenius norm bounds the change of singular values. `moved`: (c, joints of the model) [rad | m].
        """
        _, arm = self._axes(middle)
        delta = moved[:, list(self._chain)]
        reach = np.ones(delta.shape)
        travel = np.zeros(len(middle))
        for place in reversed(range(len(self._chain))):
            if self._turns[place]:
                reach[:, place] = np.linalg.norm(arm[:, place], axis=1) + travel
            travel = travel + delta[:, place] * reach[:, place]
        turn = np.cumsum(delta * self._turns, axis=1) - delta * self._turns
        # Joints i nearer than j, and j itself, turn the column; those further out move the point.
        inner = (turn + delta * self._turns) * reach
        outer = np.cumsum((delta * reach)[:, ::-1], axis=1)[:, ::-1] - delta * reach
        linear = inner + outer * self._turns
        angular = self._length * turn * self._turns
        size = np.hypot(linear, angular)
        return np.linalg.norm(size @ np.abs(self._mimic_matrix), axis=1)

    def _axes(self, times: Floats) -> tuple[Floats, Floats]:
        """Return axes and lever arms to the point, for the chain's joints in the world, (c, k, 3) each."""
        poses, chain = self._motion.poses(times), list(self._chain)
        point = poses.rotation[:, self._joint] @ self._point + poses.translation[:, self._joint]
        own = self._motion.kinematics.axes[chain]
        axis = np.einsum("ckij,kj->cki", poses.rotation[:, chain], own)
        return axis, point[:, None] - poses.translation[:, chain]
