"""Smallest singular value and manipulability of a frame's Jacobian.

In the world's axes at the point p of the frame, column j is (l_j, L w_j): l_j = v_j + w_j x p
is the velocity of p and w_j the angular velocity that joint j gives at unit speed. For joints i and j of the
chain, with a the one nearer to the base and b the other, dl_j / dq_i = w_a x l_b, and dw_j / dq_i = w_i x w_j
if i is nearer, else zero. Source: Hourtash, The kinematic Hessian and higher derivatives, CIRA 2005.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import SingularityDistance
from trajopt.problem.requirements.joints import LENGTH
from trajopt.problem.residual import WHOLE, Constraint, Cost, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Loss, Rows
from trajopt.values.errors.arguments import checked


@dataclass(frozen=True, eq=False)
class FrameJacobian:
    """Jacobian of a frame by the group's joints at S samples, rotation scaled by a length.

    Attributes:
        matrix: Shape (S, 6, n), or (S, 3, n) if the length is zero.
        slope: Its derivative: [s, :, j, i] is the derivative of column j by joint i, shape (S, 6 or 3, n, n).
    """

    matrix: Floats
    slope: Floats


def frame_jacobian(
    reduced: ReducedModel, motion: Motion, frame: str, *, length: float, offset: Floats
) -> FrameJacobian:
    """Evaluate and differentiate the Jacobian of a frame.

    Args:
        length: Length that a radian of rotation counts as [m].
        offset: The point, in the frame, shape (3,) [m].
    """
    kinematics = motion.kinematics
    joint, held = reduced.attachment(frame)
    point = kinematics.rotation[:, joint] @ (held * offset) + kinematics.translation[:, joint]
    model = reduced.model
    # Supports are listed from the world outwards, so that the nearer of two joints comes first.
    chain = [int(model.joints[number].idx_v) for number in list(model.supports[joint])[1:]]
    angular = np.swapaxes(kinematics.jacobian[:, 3:, chain], 1, 2)
    linear = np.swapaxes(kinematics.jacobian[:, :3, chain], 1, 2) + np.cross(angular, point[:, None])
    # [s, a, b] of joints a and b: joint a turns what joint b does, or b moves what a turns.
    turned = np.cross(angular[:, :, None], linear[:, None, :])
    nearer = np.triu(np.ones((len(chain), len(chain))))[None, :, :, None]
    moved = turned * nearer
    by_column = np.swapaxes(moved, 1, 2) + moved * (1.0 - np.eye(len(chain)))[None, :, :, None]
    spun = np.swapaxes(np.cross(angular[:, :, None], angular[:, None, :]) * nearer, 1, 2)
    mimic_matrix = reduced.mimic_matrix[chain]
    parts, slopes = [linear], [by_column]
    if length > 0.0:
        parts.append(length * angular)
        slopes.append(length * spun)
    matrix = np.concatenate(parts, axis=2)
    slope = np.concatenate(slopes, axis=3)
    return FrameJacobian(
        np.einsum("sjd,jn->sdn", matrix, mimic_matrix),
        np.einsum("sjid,jn,im->sdnm", slope, mimic_matrix, mimic_matrix, optimize=True),
    )


@dataclass(frozen=True, eq=False)
class SmallestSingularValue:
    """One component: the smallest singular value s of a frame's Jacobian [m/rad; m/m].

    s' = u . J' v with its singular vectors u and v; exact if the value is single.
    """

    reduced: ReducedModel
    required: SingularityDistance

    @property
    def name(self) -> str:
        return f"distance of {self.required.frame} from singularity"

    def linearise(self, motion: Motion) -> Rows:
        need = self.required
        at = frame_jacobian(self.reduced, motion, need.frame, length=need.length, offset=need.offset)
        values, slopes = singular_values(at)
        return motion.rows_of_all(values[:, -1:], slopes[:, -1:])


@checked
@dataclass(frozen=True, eq=False)
class LostManipulability:
    """One component: r / (r + m), from 1 at a singularity towards 0 far from it, with reference r.

    m is the manipulability (Yoshikawa, IJRR 1985).
    """

    frame: str
    reference: float
    length: float

    @property
    def name(self) -> str:
        return f"lost manipulability of {self.frame}"

    def linearise(self, motion: Motion) -> Rows:
        at = frame_jacobian(motion.query.reduced, motion, self.frame, length=self.length, offset=np.zeros(3))
        values, slopes = singular_values(at)
        volume = values.prod(axis=1)
        rate = np.zeros((len(values), slopes.shape[2]))
        for place in range(values.shape[1]):
            others = np.delete(values, place, axis=1).prod(axis=1)
            rate += others[:, None] * slopes[:, place]
        lost = self.reference / (self.reference + volume)
        rate = -(lost**2 / self.reference)[:, None] * rate
        return motion.rows_of_all(lost[:, None], rate[:, None, :])


@checked
def manipulability(
    frame: str,
    *,
    reference: float,
    weight: float = 1e-3,
    length: float = LENGTH,
    loss: Loss = Loss.SQUARED,
    window: Window = WHOLE,
) -> Cost:
    """Push a motion away from singular configurations: a `Cost` that counts at every sample.

    Args:
        frame: Link, tool frame or attached object.
        reference: Manipulability at which half of the cost is left, > 0.
        weight: Of the cost at a singularity.
        length: Length that a radian of rotation counts as [m]; 0 counts the origin's motion only.
    """
    return Cost(LostManipulability(frame, reference, length), weight, loss, window)


def singular_values(at: FrameJacobian) -> tuple[Floats, Floats]:
    left, values, right = np.linalg.svd(at.matrix, full_matrices=False)
    slopes = np.einsum("sdk,sdji,skj->ski", left, at.slope, right, optimize=True)
    return values, slopes


@constrain.register
def _(
    required: SingularityDistance, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    return (
        constraint(
            SmallestSingularValue(reduced, required),
            lower=required.smallest * (1.0 + inset),
            upper=np.inf,
            tolerance=max(required.smallest * inset * 0.5, 1e-9),
            window=window,
        ),
    )
