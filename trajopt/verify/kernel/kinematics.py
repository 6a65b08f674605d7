"""The judge's own forward kinematics of a reduced model, for many configurations at once."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.arrays import Bools, Floats
from trajopt.model.reduced import ReducedModel
from trajopt.verify.kernel.polynomials import Extremes, Polynomials


@dataclass(frozen=True, eq=False)
class Poses:
    """Where the joint frames are, for each of c configurations.

    Attributes:
        configurations: Pinocchio's, shape (c, nq).
        rotation: Of each joint frame in the world, shape (c, joints, 3, 3); joint 0 is the world.
        translation: Origin of each, shape (c, joints, 3) [m].
    """

    configurations: Floats
    rotation: Floats
    translation: Floats


class Kinematics:
    """Workspace for what is computed joint by joint: kinematics first of all; one for each thread.

    Attributes:
        reduced: The model.
        parents: Parent joint of each joint.
        revolute: Whether a joint turns, shape (joints,).
        axes: Unit axis of each joint in its own frame, shape (joints, 3).
        calls: Configurations computed so far.
    """

    def __init__(self, reduced: ReducedModel) -> None:
        """Read the joints."""
        model = reduced.model
        self.reduced = reduced
        self.parents: tuple[int, ...] = tuple(int(parent) for parent in model.parents)
        self.axes: Floats = np.zeros((len(self.parents), 3))
        self.revolute: Bools = np.zeros(len(self.parents), dtype=np.bool_)
        self.calls = 0
        self._model, self._data = model, model.createData()
        self._first: list[int] = []
        self._circular: list[bool] = []
        neutral = pin.neutral(model)
        for number, joint in enumerate(list(model.joints)[1:], start=1):
            data = joint.createData()
            joint.calc(data, neutral)
            subspace = np.asarray(data.S, dtype=np.float64).reshape(6)
            self.revolute[number] = bool(np.abs(subspace[3:]).max() > 0.5)
            self.axes[number] = subspace[3:] if self.revolute[number] else subspace[:3]
            self._first.append(int(joint.idx_q))
            self._circular.append(int(joint.nq) == 2)

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
        result = np.empty((len(joints), int(self._model.nq)))
        for column, (first, circular) in enumerate(zip(self._first, self._circular, strict=True)):
            if circular:
                result[:, first] = np.cos(joints[:, column])
                result[:, first + 1] = np.sin(joints[:, column])
            else:
                result[:, first] = joints[:, column]
        return result

    def poses(self, positions: Floats) -> Poses:
        """Compute where all joint frames are, for the group's positions of shape (c, n)."""
        configurations = self.configurations(positions)
        matrices = np.empty((len(positions), len(self.parents), 4, 4))
        for row, configuration in enumerate(configurations):
            pin.forwardKinematics(self._model, self._data, configuration)
            matrices[row] = [placement.np for placement in self._data.oMi.tolist()]
        self.calls += len(positions)
        return Poses(configurations, matrices[..., :3, :3], matrices[..., :3, 3])

    def extremes(self, functions: Polynomials) -> tuple[Extremes, Extremes]:
        """Return the largest and the smallest values of functions of time."""
        return functions.largest(), functions.smallest()

    def torques(self, configurations: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        """Compute the torques that motions of the model's joints need.

        Args:
            configurations: Pinocchio's, shape (s, nq).
            velocities: Of the model's joints, shape (s, joints) [rad/s | m/s].
            accelerations: Of the model's joints, shape (s, joints) [rad/s^2 | m/s^2].

        Returns:
            Shape (s, joints) [Nm | N].
        """
        rows = zip(configurations, velocities, accelerations, strict=True)
        return np.array([pin.rnea(self._model, self._data, q, v, a) for q, v, a in rows])
