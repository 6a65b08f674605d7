"""Placo's inverse kinematics from many starts: the oracle of the project's own."""

import numpy as np
import placo
from numpy.typing import NDArray

import trajopt as to

CONVERGED = 1e-7


class PlacoSearch:
    """Searches configurations of a group whose robot has no other joints, for a link at a placement."""

    def __init__(self, robot: to.Robot, group: str, link: str, where: to.Placement) -> None:
        self._names = robot.group(group).joints
        assert set(self._names) == set(robot.joint_names)
        self._wrapper = placo.RobotWrapper("", placo.Flags.ignore_collisions, robot.urdf_xml)
        self._solver = placo.KinematicsSolver(self._wrapper)
        self._solver.mask_fbase(True)
        self._solver.enable_joint_limits(True)
        self._solver.add_regularization_task(1e-6)
        self._solver.add_position_task(link, where.translation)
        self._solver.add_orientation_task(link, where.rotation)

    def __call__(self, begin: NDArray[np.float64], steps: int = 40) -> NDArray[np.float64]:
        for joint, value in zip(self._names, begin.tolist(), strict=True):
            self._wrapper.set_joint(joint, value)
        self._wrapper.update_kinematics()
        now = self._positions()
        for _ in range(steps):
            self._solver.solve(True)
            self._wrapper.update_kinematics()
            before, now = now, self._positions()
            if np.abs(now - before).max() < CONVERGED:
                break
        return now

    def _positions(self) -> NDArray[np.float64]:
        return np.array([self._wrapper.get_joint(name) for name in self._names])
