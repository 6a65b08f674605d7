"""How far points of a body can get while joints move by bounded amounts.

Let joint j move by at most delta_j. Move the outermost joint of a body's chain first and its
innermost last. While joint j moves, every joint further in is still where it was, and every
point of the body has moved by at most the travel m of the joints further out; so its
distance from the axis of j is at most rho_j + m, and it travels at most delta_j (rho_j + m) more
(delta_j for a sliding joint). Source: Schwarzer, Saha, Latombe, Adaptive dynamic collision checking
for single and multiple robots in motion, IEEE T-RO 2005.
"""

from collections.abc import Sequence

import numpy as np

from trajopt.values.arrays import Floats, Ints
from trajopt.verify.kernel.kinematics import Kinematics, Poses


def relative_chain(kinematics: Kinematics, joint: int, reference: int) -> tuple[tuple[int, ...], int]:
    """Return the joints by which one joint frame moves as seen from another, outermost first.

    Args:
        kinematics: Of the robot.
        joint: The frame's joint.
        reference: Joint of the frame that it is seen from.

    Returns:
        The joints, and how many of them are on the first frame's own chain; the others, on the
        reference's chain, follow from its innermost to its outermost.
    """
    own, other = kinematics.chain(joint), kinematics.chain(reference)
    shared = set(own) & set(other)
    mine = tuple(number for number in own if number not in shared)
    theirs = tuple(number for number in other if number not in shared)
    return mine + theirs[::-1], len(mine)


class Travel:
    """Bounds on the travel of spheres, each moved by joints of its own.

    Attributes:
        joints: Joints that move each sphere, outermost first, padded with 0, shape (w, length).
    """

    def __init__(
        self,
        kinematics: Kinematics,
        *,
        carrier: Sequence[int],
        centre: Floats,
        radius: Floats,
        chains: Sequence[tuple[int, ...]],
    ) -> None:
        """Lay out the chains.

        Args:
            kinematics: Of the robot.
            carrier: Joint that carries each of w spheres.
            centre: Of each in the carrier's frame, shape (w, 3) [m].
            radius: Of each, shape (w,) [m].
            chains: Joints that move each, outermost first.
        """
        self._kinematics = kinematics
        self._carrier = np.array(carrier, dtype=np.int64)
        self._centre, self._radius = centre, radius
        length = max((len(chain) for chain in chains), default=0)
        self.joints: Ints = np.zeros((len(chains), length), dtype=np.int64)
        for row, chain in enumerate(chains):
            self.joints[row, : len(chain)] = chain

    def centres(self, poses: Poses) -> Floats:
        """Place the centres in the world, shape (c, w, 3) [m]."""
        turned = np.einsum("cwij,wj->cwi", poses.rotation[:, self._carrier], self._centre)
        return turned + poses.translation[:, self._carrier]

    def reach(self, poses: Poses, centres: Floats, step: int) -> Floats:
        """Largest distance of each sphere's points from the axis of its joint number `step`.

        Args:
            poses: Of the robot.
            centres: What `centres` returns, shape (c, w, 3) [m].
            step: Place in the chains, 0 for the outermost joints.

        Returns:
            Shape (c, w) [m].
        """
        joint = self.joints[:, step]
        axis = np.einsum("cwij,wj->cwi", poses.rotation[:, joint], self._kinematics.axes[joint])
        arm = centres - poses.translation[:, joint]
        along = np.einsum("cwi,cwi->cw", arm, axis)
        square = np.einsum("cwi,cwi->cw", arm, arm) - along**2
        return np.sqrt(np.maximum(square, 0.0)) + self._radius

    def bound(self, poses: Poses, centres: Floats, moved: Floats) -> Floats:
        """Bound the travel of every point of each sphere.

        Args:
            poses: Where the joints are when they have not moved, for c configurations.
            centres: What `centres` returns, shape (c, w, 3) [m].
            moved: By how much each joint moves at most, shape (c, joints) [rad | m].

        Returns:
            Travel by the outermost k joints of each chain, shape (c, w, length + 1) [m].
        """
        count, length = self.joints.shape
        result = np.zeros((len(moved), count, length + 1))
        for step in range(length):
            joint = self.joints[:, step]
            lever = self.reach(poses, centres, step) + result[..., step]
            turns = self._kinematics.revolute[joint]
            result[..., step + 1] = result[..., step] + moved[:, joint] * np.where(turns, lever, 1.0)
        return result
