"""Robots that requirements are tried on."""

from pathlib import Path

import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from tests.verify.arms import joint as joint_xml
from tests.verify.arms import link as link_xml
from tests.verify.arms import planar_arm, reduced, robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene


@pytest.fixture(scope="session")
def odd(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    robot = odd_arm(tmp_path_factory.mktemp("robot"))
    return reduce_model(to.Scene(robot), "all", robot.positions())


@pytest.fixture
def gantry(tmp_path: Path) -> ReducedModel:
    """A point that slides in x and y: its path is known exactly."""
    arm = robot(
        tmp_path,
        link_xml("base"), link_xml("a"), link_xml("b"),
        joint_xml("x", "base", "a", kind="prismatic", axis="1 0 0"),
        joint_xml("y", "a", "b", kind="prismatic", axis="0 1 0"),
    )  # fmt: skip
    return reduced(Scene(arm), [0.0, 0.0])


@pytest.fixture
def model(tmp_path: Path) -> ReducedModel:
    return reduced(Scene(planar_arm(tmp_path)), [-0.5, 0.2])
