"""The judge's check of `SingularityDistance`: singular values change by no more than the matrix does.

Column j of the Jacobian is (velocity of the point, length times axis) of joint j at unit speed. While
joints move by at most delta_i, the axis of j turns by the sum of delta_i over turning joints nearer to the
base. The velocity of the point changes at a rate of at most r per unit of joint i, where r bounds the
velocity that the outer of i and j gives, if the inner one turns, and not at all if it slides.
"""

import numpy as np

from trajopt.problem.requirements import SingularityDistance
from trajopt.values.arrays import Floats
from trajopt.verify.checks.quantities import Quantity, quantities
from trajopt.verify.kernel.motion import Motion


@quantities.register
def _(requirement: SingularityDistance, motion: Motion) -> tuple[Quantity, ...]:
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
    """The Jacobian of a frame, column by column of the chain that moves it."""

    def __init__(self, requirement: SingularityDistance, motion: Motion) -> None:
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
        """Bound the norm of the change while joints leave where they are at `middle` by `moved`.

        Args:
            middle: Times, shape (c,) [s].
            moved: By joint of the model, shape (c, joints) [rad | m].

        Returns:
            Bound of the Frobenius norm, which bounds that of singular values, shape (c,).
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
        """Return axes and arms to the point of the chain's joints, in the world, (c, k, 3) each."""
        poses, chain = self._motion.poses(times), list(self._chain)
        point = poses.rotation[:, self._joint] @ self._point + poses.translation[:, self._joint]
        own = self._motion.kinematics.axes[chain]
        axis = np.einsum("ckij,kj->cki", poses.rotation[:, chain], own)
        return axis, point[:, None] - poses.translation[:, chain]
