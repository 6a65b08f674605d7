"""Derivatives of torques against differences, with a mimicking joint."""

from pathlib import Path

import numpy as np
import pinocchio
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.native.proximity import Dynamics
from trajopt.scene.reducing import reduce_model


def test_slopes_are_those_of_the_torque(tmp_path: Path) -> None:
    robot = odd_arm(tmp_path)
    query = DynamicsQuery(reduce_model(to.Scene(robot), "all", robot.positions()))
    rng = np.random.default_rng(6)
    state = [rng.uniform(-1.0, 1.0, (5, 4)) for _ in range(3)]
    found = query.torque_slopes(state[0], state[1], state[2])
    assert found.torque == pytest.approx(query.torque(state[0], state[1], state[2]), abs=1e-9)
    step = 1e-6
    held, none = query.gravity(state[0]), np.zeros_like(state[0])
    assert held.torque == pytest.approx(query.torque(state[0], none, none), abs=1e-9)
    for joint in range(4):
        ahead, behind = (query.gravity(state[0] + sign * step * np.eye(4)[joint]).torque for sign in (1, -1))
        assert held.position[:, :, joint] == pytest.approx((ahead - behind) / (2 * step), abs=1e-6)
    for kind, slope in enumerate((found.position, found.velocity, found.acceleration)):
        for joint in range(4):
            sides = []
            for sign in (1.0, -1.0):
                moved = [part.copy() for part in state]
                moved[kind][:, joint] += sign * step
                sides.append(query.torque(moved[0], moved[1], moved[2]))
            assert slope[:, :, joint] == pytest.approx((sides[0] - sides[1]) / (2 * step), abs=1e-5)


def test_a_model_with_a_joint_of_several_degrees_of_freedom_is_refused() -> None:
    model = pinocchio.Model()
    model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "floating")
    with pytest.raises(ValueError, match="one degree of freedom"):
        Dynamics(model, np.eye(6), np.zeros(6))
