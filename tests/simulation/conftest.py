"""Robots that the simulation tests share."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.robots_for_tests import odd_arm
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import MissingExtra
from trajopt.values.trajectory import Trajectory

MASS, LENGTH, INERTIA = 2.0, 0.4, 0.01

PENDULUM = """<robot name="pendulum">
  <link name="base"/>
  <link name="rod"><inertial><origin xyz="{length} 0 0"/><mass value="{mass}"/>
    <inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.2 0 0" rpy="0 1.5707963267948966 0"/>
      <geometry><cylinder radius="0.02" length="0.4"/></geometry></collision></link>
  <link name="tip"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <joint name="swing" type="revolute"><parent link="base"/><child link="rod"/><origin xyz="0 0 1"/>
    <axis xyz="0 -1 0"/><limit lower="-3" upper="3" effort="{effort}" velocity="4"/></joint>
  <joint name="end" type="fixed"><parent link="rod"/><child link="tip"/><origin xyz="0.5 0 0"/></joint>
</robot>
"""


@pytest.fixture
def pendulum(tmp_path: Path) -> Callable[..., Robot]:
    """A rod that swings about -y one metre above the ground; at zero it is level, along x."""

    def build(*, effort: float = 100.0, mass: float = MASS, inertia: float = INERTIA) -> Robot:
        path = tmp_path / "pendulum.urdf"
        path.write_text(PENDULUM.format(effort=effort, mass=mass, length=LENGTH, inertia=inertia))
        return Robot.from_urdf(path)

    return build


@pytest.fixture
def odd(tmp_path: Path) -> Robot:
    return odd_arm(tmp_path)


def reduced_all(scene: Scene) -> ReducedModel:
    """The group "all" from the robot's default positions."""
    return reduce_model(scene, "all", scene.robot.positions())


def smooth(reduced: ReducedModel, start: Floats, end: Floats, duration: float) -> Trajectory:
    """From rest to rest along a quintic."""
    still = np.zeros((2, len(reduced.joint_names)))
    return Trajectory(reduced.joint_names, np.array([0.0, duration]), np.array([start, end]), still, still)


def panda() -> Robot:
    """The Panda; skips the test where its files are not installed."""
    loader = pytest.importorskip("trajopt_robots.panda")
    try:
        return loader.load()
    except MissingExtra as missing:
        pytest.skip(str(missing))
