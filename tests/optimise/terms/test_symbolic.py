"""Symbolic kinematics against Pinocchio's own, on every kind of joint and on the installed arms."""

from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.optimise.terms.symbolic import SymbolicKinematics
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model


def check(reduced: ReducedModel, seed: int) -> None:
    kinematics = SymbolicKinematics(reduced)
    model, data = reduced.model, reduced.model.createData()
    joints = range(1, model.njoints)
    offset = np.array((0.1, -0.2, 0.3))
    function = ca.Function(
        "f", [kinematics.q], [ca.vertcat(*(kinematics.joint_point(joint, offset) for joint in joints))]
    )
    limits = reduced.limits
    lower, upper = np.maximum(limits.lower, -3.0), np.minimum(limits.upper, 3.0)
    for positions in np.random.default_rng(seed).uniform(lower, upper, (20, len(lower))):
        pin.forwardKinematics(model, data, reduced.configuration(positions))
        expected = np.concatenate([data.oMi[joint].act(offset) for joint in joints])
        assert np.array(function(positions)).ravel() == pytest.approx(expected, abs=1e-12)


def test_joints_of_every_kind(tmp_path: Path) -> None:
    robot = odd_arm(tmp_path)
    check(reduce_model(to.Scene(robot), "all", robot.positions()), 1)


@pytest.mark.parametrize("name", ["planar_fold", "past_pillar_ur5", "two_arms_meet"])
def test_installed_arms(name: str) -> None:
    check(to.named_problem(name).reduced, 2)
