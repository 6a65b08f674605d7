"""A world with a small arm that has masses, and one whose robot jumps to where it is sent."""

from collections.abc import Iterator
from pathlib import Path

import pytest

import trajopt as to
from tests.ros.commander.jumping import JumpingExecutor
from tests.server.serving import Serving, serving
from trajopt.driving import SimulatedExecutor
from trajopt.ros.commander import World

LINK = """
  <link name="{name}"><inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/>
    <inertia ixx="{mass}e-2" iyy="{mass}e-2" izz="{mass}e-2" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="{x} 0 0"/><geometry><box size="{size} 0.04 0.04"/></geometry></visual>
    <collision><origin xyz="{x} 0 0"/><geometry><box size="{size} 0.04 0.04"/></geometry></collision>
  </link>"""
LIMIT = '<limit lower="-2.5" upper="2.5" effort="60" velocity="2"/>'
URDF = (
    '<robot name="lab">'
    + LINK.format(name="base", x=0.0, size=0.1, mass=1)
    + LINK.format(name="upper", x=0.25, size=0.38, mass=1)
    + LINK.format(name="fore", x=0.25, size=0.38, mass=1)
    + LINK.format(name="hand", x=0.03, size=0.05, mass=1)
    + LINK.format(name="finger", x=0.02, size=0.03, mass=1)
    + f"""
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 0 1"/>{LIMIT}</joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/>
    <axis xyz="0 0 1"/>{LIMIT}</joint>
  <joint name="wrist" type="revolute"><parent link="fore"/><child link="hand"/><origin xyz="0.5 0 0"/>
    <axis xyz="0 0 1"/>{LIMIT}</joint>
  <joint name="mount" type="fixed"><parent link="hand"/><child link="finger"/><origin xyz="0.06 0 0"/></joint>
</robot>"""
)
"""Three joints in the plane z = 0.1 m: every placement in the plane can be asked for."""

SRDF = """<robot name="lab">
  <group name="arm"><chain base_link="base" tip_link="hand"/></group>
  <group name="wrist_only"><joint name="wrist"/></group>
  <group_state name="bent" group="arm"><joint name="shoulder" value="0.5"/><joint name="elbow" value="-1"/>
    <joint name="wrist" value="0.2"/></group_state>
  <group_state name="straight" group="arm"><joint name="shoulder" value="0"/><joint name="elbow" value="0"/>
    <joint name="wrist" value="0"/></group_state>
</robot>
"""


class Clock:
    """A clock that a test sets."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def wait(self, seconds: float) -> None:
        self.now += seconds


@pytest.fixture(scope="session")
def lab_arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    folder = tmp_path_factory.mktemp("lab")
    (folder / "lab.urdf").write_text(URDF)
    (folder / "lab.srdf").write_text(SRDF)
    return to.Robot.from_urdf(folder / "lab.urdf", srdf=folder / "lab.srdf")


@pytest.fixture(scope="session")
def lab_server(lab_arm: to.Robot) -> Iterator[Serving]:
    """A server of that arm."""
    with serving(lab_arm) as server:
        yield server


@pytest.fixture(params=["here", pytest.param("served", marks=pytest.mark.slow)])
def simulated(lab_arm: to.Robot, request: pytest.FixtureRequest) -> Iterator[World]:
    """A world whose robot moves in MuJoCo, in this process or in a server's; it is the current one."""
    served = request.param == "served"
    with World(url=request.getfixturevalue("lab_server").url) if served else World(lab_arm) as world:
        yield world


@pytest.fixture
def jumping(lab_arm: to.Robot) -> Iterator[World]:
    """A world whose robot is at once where it is sent; it is the current one."""
    with World(lab_arm, executor=JumpingExecutor(lab_arm.positions("bent"))) as world:
        yield world


@pytest.fixture
def constraints_folder(tmp_path: Path) -> Path:
    (tmp_path / "still.yaml").write_text(
        "joint_constraints: [{joint_name: wrist, position: 0.2, tolerance_above: 0.5, tolerance_below: 0.5}]"
    )
    return tmp_path


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def timed(lab_arm: to.Robot, clock: Clock) -> World:
    """A simulated world whose time a test tells."""
    executor = SimulatedExecutor(to.Scene(lab_arm), lab_arm.positions("bent"), clock=clock)
    return World(lab_arm, executor=executor, wait=clock.wait)
