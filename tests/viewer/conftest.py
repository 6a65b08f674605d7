"""A tiny arm that slides and turns past a post, with a cup in its hand."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import trajopt as to
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.shapes.shapes import Box, Cylinder
from trajopt.values.trajectory import Trajectory

URDF = """<robot name="tiny">
  <link name="base">
    <collision><origin xyz="0 0 0.05"/><geometry><box size="0.16 0.16 0.1"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic">
    <parent link="base"/><child link="carriage"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.3" effort="50" velocity="0.5"/>
  </joint>
  <link name="carriage">
    <visual><geometry><cylinder radius="0.05" length="0.08"/></geometry>
      <material name="blue"><color rgba="0.2 0.4 0.7 1"/></material></visual>
    <collision><geometry><cylinder radius="0.05" length="0.08"/></geometry></collision>
  </link>
  <joint name="turn" type="revolute">
    <parent link="carriage"/><child link="arm"/><origin xyz="0 0 0.08"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="50" velocity="2"/>
  </joint>
  <link name="arm">
    <visual><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.06 0.06"/></geometry></visual>
    <collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.06 0.06"/></geometry></collision>
  </link>
  <joint name="wrist" type="continuous">
    <parent link="arm"/><child link="hand"/><origin xyz="0.6 0 0"/><axis xyz="1 0 0"/>
    <limit effort="50" velocity="2"/>
  </joint>
  <link name="hand">
    <collision><geometry><sphere radius="0.02"/></geometry></collision>
  </link>
</robot>"""


class Motion(NamedTuple):
    """A reduced model and a motion of it."""

    reduced: ReducedModel
    trajectory: Trajectory


@pytest.fixture(scope="session")
def motion(tmp_path_factory: pytest.TempPathFactory) -> Motion:
    folder: Path = tmp_path_factory.mktemp("tiny")
    (folder / "tiny.urdf").write_text(URDF)
    robot = to.Robot.from_urdf(folder / "tiny.urdf")
    scene = (
        to.Scene(robot)
        .add("post", Cylinder(0.04, 0.6), to.placement((0.3, 0.3, 0.3)))
        .add("table", Box(0.3, 0.3, 0.04), to.placement((0.35, -0.35, 0.1)))
        .add("cup", Cylinder(0.03, 0.08), to.placement((0.0, 0.0, -0.06)), frame="hand", touch_links=["hand"])
        .allow_contact("cup on the table", "cup", "table", first=0.2)
    )
    start = robot.positions({"slide": 0.12, "turn": -0.8})
    reduced = reduce_model(scene, "all", start)
    middle, end = np.array([0.25, -0.2, 0.3]), np.array([0.1, 0.35, 0.0])
    times = np.array([0.0, 0.7, 1.5])
    positions = np.stack((reduced.start_positions, middle, end))
    velocities = np.stack((np.zeros(3), (end - positions[0]) / 1.5, np.zeros(3)))
    return Motion(reduced, Trajectory(reduced.joint_names, times, positions, velocities))
