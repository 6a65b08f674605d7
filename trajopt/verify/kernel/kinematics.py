"""The judge's own forward kinematics of a reduced model, for many configurations at once."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.native import proof
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats


@dataclass(frozen=True, eq=False)
class Poses:
    """Where the joint frames are, for each of c configurations.

    Attributes:
        configurations: Pinocchio's, shape (c, nq).
        rotation: Of each joint frame in the world, shape (c, joints, 3, 3); joint 0 is the world.
        translation: Origin of each, shape (c, joints, 3) [m].
        times: When the robot is there, shape (c,) [s]; None where time stands still.
    """

    configurations: Floats
    rotation: Floats
    translation: Floats
    times: Floats | None = None


@dataclass(frozen=True, eq=False)
class _Joints:
    """The joints of a model, the world first; the same for all scenes.

    Attributes:
        parents: Parent joint of each joint.
        revolute: Whether a joint turns, shape (joints,).
        axes: Unit axis of each joint in its own frame, shape (joints, 3).
        first: Place of each joint's first number in pinocchio's configurations, without the world.
        circular: Whether it has two, cosine and sine.
        arm: The joints as the core knows them.
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
    """Return the masses of a robot, and of what it carries as part of itself."""
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
    """Workspace for kinematics and dynamics of a model, by the native core; one for each thread.

    Attributes:
        reduced: The model.
        parents: Parent joint of each joint.
        revolute: Whether a joint turns, shape (joints,).
        axes: Unit axis of each joint in its own frame, shape (joints, 3).
        arm: The joints as the core knows them.
        dynamics: What they carry.
        calls: Configurations computed so far.
    """

    def __init__(self, reduced: ReducedModel) -> None:
        """Read the joints, once for all scenes."""
        self.reduced = reduced
        joints = reduced.derived_of_robot(_Joints.of)
        self.parents, self.revolute, self.axes, self.arm = (
            joints.parents, joints.revolute, joints.axes, joints.arm,
        )  # fmt: skip
        self.dynamics = reduced.derived_of_robot(_dynamics)
        self._first, self._circular = joints.first, joints.circular
        self.calls = 0

    def chain(self, joint: int) -> tuple[int, ...]:
        """Return a joint and those it hangs on, outermost first, without the world."""
        found: list[int] = []
        while joint > 0:
            found.append(joint)
            joint = self.parents[joint]
        return tuple(found)

    def configurations(self, positions: Floats) -> Floats:
        """Map the group's positions, shape (c, n), to pinocchio's configurations, (c, nq)."""
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
        """Compute where all joint frames are, for the group's positions of shape (c, n)."""
        joints = positions @ self.reduced.mimic_matrix.T + self.reduced.mimic_offset
        rotation, translation = self.arm.place(np.ascontiguousarray(joints))
        self.calls += len(positions)
        return Poses(self.configurations(positions), rotation, translation)

    def torques(self, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        """Compute the torques that motions of the model's joints need.

        Args:
            positions: Of the group's joints, shape (s, n) [rad | m].
            velocities: Of the model's joints, shape (s, joints) [rad/s | m/s].
            accelerations: Of the model's joints, shape (s, joints) [rad/s^2 | m/s^2].

        Returns:
            Shape (s, joints) [Nm | N].
        """
        joints = positions @ self.reduced.mimic_matrix.T + self.reduced.mimic_offset
        rows = (np.ascontiguousarray(part) for part in (joints, velocities, accelerations))
        return self.dynamics.torques(*rows)
