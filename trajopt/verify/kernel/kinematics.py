"""The judge's own forward kinematics, and bounds on the travel of bodies."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.native import proof
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats, Ints


@dataclass(frozen=True, eq=False)
class Poses:
    """Placements of the joint frames, for each of c configurations.

    Attributes:
        configurations: Pinocchio's configurations, shape (c, nq).
        rotation: Rotations of the joint frames in the world, shape (c, joints, 3, 3); joint 0 is the world.
        translation: Their origins, shape (c, joints, 3) [m].
        times: Times of the configurations, shape (c,) [s]; None without time.
    """

    configurations: Floats
    rotation: Floats
    translation: Floats
    times: Floats | None = None


@dataclass(frozen=True, eq=False)
class _Joints:
    """Joints of a model, the world first; shared by all scenes.

    Attributes:
        first: Index of each joint's first number in pinocchio's configurations, without the world.
        circular: Whether it has two numbers, cosine and sine.
    """

    parents: tuple[int, ...]
    revolute: Bools
    axes: Floats
    first: tuple[int, ...]
    circular: tuple[bool, ...]
    arm: proof.Arm

    @staticmethod
    def of(reduced: ReducedModel) -> "_Joints":
        model = reduced.model
        parents = tuple(int(parent) for parent in model.parents)
        axes, revolute = np.zeros((len(parents), 3)), np.zeros(len(parents), dtype=np.bool_)
        neutral, joints = pin.neutral(model), list(model.joints)[1:]
        for number, joint in enumerate(joints, start=1):
            data = joint.createData()
            joint.calc(data, neutral)
            subspace = np.asarray(data.S, dtype=np.float64).reshape(6)
            revolute[number] = bool(np.abs(subspace[3:]).max() > 0.5)
            axes[number] = subspace[3:] if revolute[number] else subspace[:3]
        placements = list(model.jointPlacements)
        arm = proof.arm(
            np.array(parents, dtype=np.int64),
            revolute,
            axes,
            np.array([placement.rotation for placement in placements]),
            np.array([placement.translation for placement in placements]),
        )
        first = tuple(int(joint.idx_q) for joint in joints)
        return _Joints(parents, revolute, axes, first, tuple(int(joint.nq) == 2 for joint in joints), arm)


def _dynamics(reduced: ReducedModel) -> proof.Dynamics:
    model = reduced.model
    inertias = list(model.inertias)
    return proof.dynamics(
        reduced.derived_of_robot(_Joints.of).arm,
        np.array([inertia.mass for inertia in inertias], dtype=np.float64),
        np.array([inertia.lever for inertia in inertias], dtype=np.float64),
        np.array([inertia.inertia for inertia in inertias], dtype=np.float64),
        np.append(0.0, model.armature),
        np.array(model.gravity.linear, dtype=np.float64),
    )


class Kinematics:
    """Workspace for kinematics and dynamics of a model, by the native core; one per thread.

    Attributes:
        revolute: Whether a joint is revolute, shape (joints,).
        axes: Unit axis of each joint in its own frame, shape (joints, 3).
    """

    def __init__(self, reduced: ReducedModel) -> None:
        self.reduced = reduced
        joints = reduced.derived_of_robot(_Joints.of)
        self.parents, self.revolute, self.axes, self.arm = (
            joints.parents, joints.revolute, joints.axes, joints.arm,
        )  # fmt: skip
        self.dynamics = reduced.derived_of_robot(_dynamics)
        self._first, self._circular = joints.first, joints.circular
        self.calls = 0

    def chain(self, joint: int) -> tuple[int, ...]:
        """Return a joint and its ancestors, outermost first, without the world."""
        found: list[int] = []
        while joint > 0:
            found.append(joint)
            joint = self.parents[joint]
        return tuple(found)

    def configurations(self, positions: Floats) -> Floats:
        """Convert the group's positions, shape (c, n), to pinocchio's configurations, (c, nq)."""
        joints = positions @ self.reduced.mimic_matrix.T + self.reduced.mimic_offset
        if not any(self._circular):
            return joints
        result = np.empty((len(joints), int(self.reduced.model.nq)))
        for column, (first, circular) in enumerate(zip(self._first, self._circular, strict=True)):
            if circular:
                result[:, first] = np.cos(joints[:, column])
                result[:, first + 1] = np.sin(joints[:, column])
            else:
                result[:, first] = joints[:, column]
        return result

    def poses(self, positions: Floats) -> Poses:
        """Compute the placements of all joint frames at the group's positions, shape (c, n)."""
        joints = positions @ self.reduced.mimic_matrix.T + self.reduced.mimic_offset
        rotation, translation = self.arm.place(np.ascontiguousarray(joints))
        self.calls += len(positions)
        return Poses(self.configurations(positions), rotation, translation)

    def torques(self, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        """Compute joint torques by inverse dynamics, shape (s, joints) [Nm | N].

        Args:
            positions: Of the group's joints, shape (s, n) [rad | m].
            velocities: Of the model's joints, shape (s, joints) [rad/s | m/s].
            accelerations: Shape (s, joints) [rad/s^2 | m/s^2].
        """
        joints = positions @ self.reduced.mimic_matrix.T + self.reduced.mimic_offset
        rows = (np.ascontiguousarray(part) for part in (joints, velocities, accelerations))
        return self.dynamics.torques(*rows)


def relative_chain(kinematics: Kinematics, joint: int, reference: int) -> tuple[tuple[int, ...], int]:
    """Return the joints that move one joint frame relative to another, outermost first, and their number.

    The number counts those on the frame's own chain; the reference's chain follows, innermost first.
    """
    own, other = kinematics.chain(joint), kinematics.chain(reference)
    shared = set(own) & set(other)
    mine = tuple(number for number in own if number not in shared)
    theirs = tuple(number for number in other if number not in shared)
    return mine + theirs[::-1], len(mine)


@dataclass(frozen=True, eq=False)
class TravelBounds:
    """Bounds for w spheres, in c intervals.

    Attributes:
        levers: Largest distance of a sphere's points from the axis of each joint, while the outer joints
            move, shape (c, w, length) [m].
        travel: Travel of its points by the outermost k joints, shape (c, w, length + 1) [m].
    """

    levers: Floats
    travel: Floats


class Travel:
    """Bounds on the travel of spheres, each with its own joints, while joints move by bounded amounts.

    Let joint j move by at most delta_j. Move the outermost joint of a body's chain first and its innermost
    last. While joint j moves, every point of the body has moved by at most the travel m of the outer joints;
    so its distance from the axis of j is at most rho_j + m, and it travels at most delta_j (rho_j + m) more
    (delta_j for a prismatic joint). Source: Schwarzer, Saha, Latombe, Adaptive dynamic collision checking for
    single and multiple robots in motion, IEEE T-RO 2005.

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
        """Arrange the chains.

        Args:
            centre: Centre of each in the carrier's frame, shape (w, 3) [m].
            radius: Radius of each, shape (w,) [m].
        """
        self._kinematics = kinematics
        self._carrier = np.array(carrier, dtype=np.int64)
        self._centre, self._radius = centre, radius
        length = max((len(chain) for chain in chains), default=0)
        self.joints: Ints = np.zeros((len(chains), length), dtype=np.int64)
        for row, chain in enumerate(chains):
            self.joints[row, : len(chain)] = chain

    def centres(self, poses: Poses) -> Floats:
        turned = np.einsum("cwij,wj->cwi", poses.rotation[:, self._carrier], self._centre)
        return turned + poses.translation[:, self._carrier]

    def bound(self, poses: Poses, centres: Floats, moved: Floats) -> TravelBounds:
        """Bound the travel of every point of each sphere.

        Args:
            moved: Largest move of each joint, shape (c, joints) [rad | m].
        """
        count, length = self.joints.shape
        axis = np.einsum(
            "cwlij,wlj->cwli", poses.rotation[:, self.joints], self._kinematics.axes[self.joints]
        )
        arm = centres[:, :, None] - poses.translation[:, self.joints]
        along = np.einsum("cwli,cwli->cwl", arm, axis)
        square = np.einsum("cwli,cwli->cwl", arm, arm) - along**2
        levers = np.sqrt(np.maximum(square, 0.0)) + self._radius[:, None]
        turns, moves = self._kinematics.revolute[self.joints], moved[:, self.joints]
        travel = np.zeros((len(moved), count, length + 1))
        for step in range(length):
            levers[..., step] += travel[..., step]
            lever = np.where(turns[:, step], levers[..., step], 1.0)
            travel[..., step + 1] = travel[..., step] + moves[..., step] * lever
        return TravelBounds(levers, travel)
