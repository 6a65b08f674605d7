"""Manipulability: how well a frame can move in every direction."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.requirements.singularity_distance import LENGTH


def manipulability(jacobian: Floats, *, length: float = LENGTH) -> Floats:
    """Return Yoshikawa's manipulability of Jacobians.

    It is the product of the min(6, n) singular values of (J_v, length J_w): the volume, but for a constant
    factor, of the ellipsoid of velocities that joints at unit speed give; zero at a singularity. Source:
    Yoshikawa, Manipulability of robotic mechanisms, IJRR 1985.

    Args:
        jacobian: Of `frame_jacobian`, shape (S, 6, n).
        length: What a radian of rotation is weighed as [m]; 0 where only the point's motion counts.

    Returns:
        Shape (S,) [m^min(6, n) for joints that turn].
    """
    rows = jacobian[:, :3] if length == 0.0 else jacobian * np.repeat((1.0, length), 3)[:, None]
    transposed = np.swapaxes(rows, 1, 2)
    gram = rows @ transposed if rows.shape[1] <= rows.shape[2] else transposed @ rows
    return np.sqrt(np.maximum(np.linalg.det(gram), 0.0))
