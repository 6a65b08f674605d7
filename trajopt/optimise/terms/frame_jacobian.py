"""The Jacobian of a frame and its derivative by the joints.

In the world's axes at the point p of the frame, column j is (l_j, L w_j): l_j = v_j + w_j x p is the
velocity of p and w_j the angular velocity that joint j gives at unit speed. For joints i and j of the
chain, with a the one nearer to the base and b the other, dl_j / dq_i = w_a x l_b, and dw_j / dq_i =
w_i x w_j if i is nearer, else zero. Source: Hourtash, The kinematic Hessian and higher derivatives,
CIRA 2005. Exact; no differences are taken.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.problem.motion import Motion
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats


@dataclass(frozen=True, eq=False)
class FrameJacobian:
    """Jacobian of a frame by the group's joints at S samples, rotation scaled by a length.

    Attributes:
        matrix: Shape (S, 6, n), or (S, 3, n) where the length is zero.
        slope: Its derivative: [s, :, j, i] is that of column j by joint i, shape (S, 6 or 3, n, n).
    """

    matrix: Floats
    slope: Floats


def frame_jacobian(
    reduced: ReducedModel, motion: Motion, frame: str, *, length: float, offset: Floats
) -> FrameJacobian:
    """Evaluate and differentiate the Jacobian of a frame.

    Args:
        reduced: The robot and its surroundings.
        motion: The samples.
        frame: Link, tool frame or object.
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
