"""Reduced models of small robots, as every function of the room takes them."""

from pathlib import Path

import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm, two_arms
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model


@pytest.fixture
def odd(tmp_path: Path) -> ReducedModel:
    """The odd arm holding a ball, in front of a block."""
    robot = odd_arm(tmp_path)
    scene = (
        to.Scene(robot)
        .add("ball", to.Sphere(0.02), to.placement((0.12, 0.0, 0.0), rpy=(0, 0.4, 0)), frame="tip")
        .add("block", to.Box(0.2, 0.2, 0.2), to.placement((0.6, 0.4, 0.2), rpy=(0, 0, 0.3)))
        .allow("ball", "tip")
        .allow("ball", "finger")
    )
    return reduce_model(scene, "all", robot.positions({"elbow": 0.3}))


@pytest.fixture
def pair(tmp_path: Path) -> ReducedModel:
    """Two arms on a torso, both free."""
    robot = two_arms(tmp_path)
    return reduce_model(to.Scene(robot), "both", robot.positions())


@pytest.fixture(scope="module")
def panda() -> ReducedModel:
    """The Panda's arm at its ready state, nothing around it."""
    try:
        robot = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    return reduce_model(to.Scene(robot), "panda_arm", robot.positions("ready"))
