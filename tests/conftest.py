"""What many tests need: a small robot, and the shared problem sets where they are at hand."""

from pathlib import Path

import pytest

from trajopt import Robot

pytest_plugins = ("tests.watchdog",)

LINK = """
  <link name="{name}"><collision><origin xyz="{x} 0 0"/>
    <geometry><box size="{size} 0.04 0.04"/></geometry></collision></link>"""

PLANAR_ARM = (
    '<robot name="planar_arm">'
    + LINK.format(name="base", x=0.0, size=0.1)
    + LINK.format(name="upper", x=0.25, size=0.38)
    + LINK.format(name="fore", x=0.25, size=0.38)
    + LINK.format(name="hand", x=0.03, size=0.05)
    + LINK.format(name="left_finger", x=0.02, size=0.03)
    + LINK.format(name="right_finger", x=0.02, size=0.03)
    + """
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="10" velocity="2"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5" effort="10" velocity="2"/></joint>
  <joint name="flange" type="fixed"><parent link="fore"/><child link="hand"/><origin xyz="0.5 0 0"/></joint>
  <joint name="left_slide" type="prismatic"><parent link="hand"/><child link="left_finger"/>
    <origin xyz="0.06 0 0"/><axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="5" velocity="0.1"/>
    </joint>
  <joint name="right_slide" type="prismatic"><parent link="hand"/><child link="right_finger"/>
    <origin xyz="0.06 0 0"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.04" effort="5" velocity="0.1"/>
    <mimic joint="left_slide"/></joint>
</robot>
"""
)
"""Two links of 0.5 m in the plane z = 0.1 m and a gripper of two fingers, the right one mimicking."""

PLANAR_ARM_SRDF = """<robot name="planar_arm">
  <group name="arm"><chain base_link="base" tip_link="hand"/></group>
  <group name="gripper"><joint name="left_slide"/></group>
  <group_state name="bent" group="arm"><joint name="shoulder" value="0.5"/>
    <joint name="elbow" value="-1"/></group_state>
  <disable_collisions link1="left_finger" link2="right_finger" reason="Default"/>
  <disable_collisions link1="hand" link2="left_finger" reason="Adjacent"/>
  <disable_collisions link1="hand" link2="right_finger" reason="Adjacent"/>
</robot>
"""


@pytest.fixture(scope="session")
def planar_arm(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """A planar arm with a gripper: groups "arm" and "gripper", a fixed and a mimicking joint."""
    folder = tmp_path_factory.mktemp("planar_arm")
    (folder / "arm.urdf").write_text(PLANAR_ARM)
    (folder / "arm.srdf").write_text(PLANAR_ARM_SRDF)
    return Robot.from_urdf(folder / "arm.urdf", srdf=folder / "arm.srdf")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of problem sets that stands beside the repository on some machines."""
    folder = Path(__file__).parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the shared problem sets are not beside this repository")
    return folder
