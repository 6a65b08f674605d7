"""How far the two bodies of a pair can travel towards each other."""

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.verify.kernel.distances import Distances
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.travel import Travel, relative_chain


class PairTravel:
    """Bounds on the relative travel of every pair of bodies.

    Joints that carry both bodies do not count. Against a half-space on a moving link, which has no
    bound of its own, the other body is moved as seen from that link.
    """

    def __init__(self, kinematics: Kinematics, distances: Distances) -> None:
        """Lay out which joints move which body against which."""
        joint = distances.joint.tolist()
        finite = np.isfinite(distances.radius)
        carrier, chains = list(joint), [kinematics.chain(number) for number in joint]
        sphere = list(range(len(joint)))
        rows: list[tuple[int, int, int, int]] = []
        for one, other in zip(distances.first.tolist(), distances.second.tolist(), strict=True):
            chain, own = relative_chain(kinematics, joint[one], joint[other])
            if finite[one] and finite[other]:
                rows.append((one, own, other, len(chain) - own))
                continue
            body, plane = (one, other) if finite[one] else (other, one)
            chain, _ = relative_chain(kinematics, joint[body], joint[plane])
            rows.append((len(chains), len(chain), plane, 0))
            carrier.append(joint[body])
            chains.append(chain)
            sphere.append(body)
        self._rows: Ints = np.array(rows, dtype=np.int64).reshape(-1, 4)
        self._bodies = len(joint)
        self._travel = Travel(
            kinematics,
            carrier=carrier,
            centre=distances.centre[sphere],
            radius=np.where(finite, distances.radius, 0.0)[sphere],
            chains=chains,
        )

    def centres(self, poses: Poses) -> Floats:
        """Place the centres of all spheres in the world, bodies first, shape (c, w, 3) [m]."""
        return self._travel.centres(poses)

    def bound(self, poses: Poses, centres: Floats, moved: Floats, cell: Ints, pair: Ints) -> Floats:
        """Bound by how much the distance of pairs can change.

        Args:
            poses: Of the robot at c configurations.
            centres: What `centres` returns.
            moved: By how much each joint moves at most, shape (c, joints) [rad | m].
            cell: Which configuration, shape (i,).
            pair: Which pair, shape (i,).

        Returns:
            Shape (i,) [m].
        """
        travel = self._travel.bound(poses, centres, moved)
        first, own, second, other = self._rows[pair].T
        return travel[cell, first, own] + travel[cell, second, other]
