"""The robot for LeRobot, with the installed package and arms in MuJoCo, in real time."""

import json
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from trajopt_robots._example_robot_data import share_folder

import trajopt as to
from tests.oracles.query import PlainQuery
from trajopt.driving import ActionOutcome
from trajopt.files.moveit import read_scene
from trajopt.scene.reducing import reduce_model

if find_spec("lerobot") is None:
    pytest.skip("lerobot is not installed", allow_module_level=True)

import draccus
from lerobot.robots import RobotConfig, make_robot_from_config
from lerobot.utils.errors import DeviceNotConnectedError
from lerobot.utils.import_utils import register_third_party_plugins

from tests.driving.simulatedarm import LAG, SimulatedArm

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("default")]

PLUGIN = Path(__file__).parents[2] / "packaging" / "lerobot_robot_trajopt"
FPS = 30.0
WALL = to.Box(0.3, 0.02, 0.4), to.placement((0.31, -0.25, 0.6), rpy=(0.0, 0.0, -0.7))
WALL_FILE = """
world:
  collision_objects:
    - id: wall
      header: {frame_id: world}
      pose: {position: {x: 0.31, y: -0.25, z: 0.6}, orientation: {z: -0.3428978, w: 0.9393727}}
      primitives: [{type: 1, dimensions: [0.3, 0.02, 0.4]}]
      primitive_poses: [{orientation: {w: 1.0}}]
"""


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The plugin as an installed package."""
    (record := tmp_path / "lerobot_robot_trajopt-0.1.0.dist-info").mkdir()
    (record / "METADATA").write_text("Metadata-Version: 2.1\nName: lerobot_robot_trajopt\nVersion: 0.1.0\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.syspath_prepend(str(PLUGIN))
    register_third_party_plugins()
    assert "lerobot_robot_trajopt" in sys.modules


@dataclass
class Command:
    """The configuration of one of LeRobot's commands."""

    robot: RobotConfig


def guarded(motors: Mapping[str, object], settings: Mapping[str, object], tmp_path: Path) -> Any:
    """Return the robot that LeRobot makes of a configuration, over a simulated one with these motors."""
    document = {
        "type": "trajopt_guarded",
        "robot": {"type": "simulated_arm", "motors": motors, "calibration_dir": str(tmp_path)},
        "tolerance": 8e-3,
        "lag": LAG,
        "lead": 0.1,  # other processes may hold up this one
        "calibration_dir": str(tmp_path),
        **settings,
    }
    (tmp_path / "command.json").write_text(json.dumps({"robot": document}))
    # As LeRobot's commands read it.
    command = draccus.parse(Command, config_path=tmp_path / "command.json", args=["--robot.fps=30"])
    assert command.robot.type == "trajopt_guarded"
    return make_robot_from_config(command.robot)


def play(robot: Any, actions: list[dict[str, float]]) -> tuple[list[dict[str, float]], list[Any]]:
    sent, decisions = list[dict[str, float]](), list[Any]()
    for action in actions:
        due = time.monotonic() + 1.0 / FPS
        sent.append(robot.send_action(action))
        decisions.append(robot.arm.decision)
        time.sleep(max(due - time.monotonic(), 0.0))
    return sent, decisions


def touch(group: str, actions: list[dict[str, float]]) -> set[str]:
    """Return the links and objects that touch at some actions, in degrees."""
    scene, start = SimulatedArm.scene, SimulatedArm.start
    full = np.array([start[name] for name in scene.robot.joint_names])
    reduced = reduce_model(scene, group, full)
    rows = np.radians([[each[f"{name}.pos"] for name in reduced.joint_names] for each in actions])
    found = PlainQuery(reduced).close_pairs(rows, np.full(len(reduced.pairs.required), 1e-6))
    return {name for pair in found.pair[found.distance < 0.0] for name in reduced.owners(int(pair))}


def test_a_panda_stops_before_a_wall(plugin: None, tmp_path: Path) -> None:
    panda = to.load("panda")
    (tmp_path / "scene.yaml").write_text(WALL_FILE)
    joints = panda.group("panda_arm").joints
    ready = dict(zip(panda.joint_names, panda.positions("ready").tolist(), strict=True))
    SimulatedArm.scene, SimulatedArm.start = to.Scene(panda).add("wall", *WALL), ready
    motors = {f"{name}.pos": {"joint": name} for name in joints}
    robot = guarded(
        motors,
        {
            "motors": motors,
            "description": "panda",
            "group": "panda_arm",
            "scene": str(tmp_path / "scene.yaml"),
        },
        tmp_path,
    )
    with pytest.raises(DeviceNotConnectedError):
        robot.get_observation()
    with robot:
        assert robot.is_connected and set(robot.action_features) == set(robot.get_observation())
        begin = robot.get_observation()
        away = [{**begin, "panda_joint1.pos": begin["panda_joint1.pos"] + 0.3 * k} for k in range(30)]
        sent, free = play(robot, away)
        assert ActionOutcome.AS_GIVEN in {each.outcome for each in free}
        assert sent[-1] == pytest.approx(away[-1], abs=0.5)
        towards = [{**begin, "panda_joint1.pos": away[-1]["panda_joint1.pos"] - 0.4 * k} for k in range(150)]
        assert "wall" in touch("panda_arm", towards)
        sent, held = play(robot, towards)
        assert sent[-1]["panda_joint1.pos"] > towards[-1]["panda_joint1.pos"] + 5.0
        assert held[-1].reason
        inner = robot.robot
    assert not any("wall" in pair for pair in inner.touched)
    assert not robot.is_connected and not inner.is_connected


TABLE_FILE = """
world:
  collision_objects:
    - id: table
      header: {frame_id: world}
      pose: {position: {x: 0.3, y: 0.0, z: -0.06}, orientation: {w: 1.0}}
      primitives: [{type: 1, dimensions: [0.4, 0.6, 0.1]}]
      primitive_poses: [{orientation: {w: 1.0}}]
"""
SRDF = """
<robot name="so101_new_calib">
  <group name="arm"><chain base_link="base_link" tip_link="gripper_link"/></group>
  <disable_collisions link1="wrist_link" link2="moving_jaw_so101_v1_link" reason="Never"/>
</robot>
"""
SO101 = "so_arm_description/urdf/so101.urdf"
GRIPPER = {"joint": "gripper", "scale": 0.0192, "offset": -0.1745}
"""LeRobot's unit of grippers is the percent."""


def test_an_so101_does_not_touch_its_table(plugin: None, tmp_path: Path) -> None:
    folder = share_folder()
    if not (urdf := folder / "example-robot-data" / "robots" / SO101).exists():
        pytest.skip(f"{urdf} does not exist")
    (tmp_path / "so101.srdf").write_text(SRDF)
    arm = to.load(urdf, srdf=tmp_path / "so101.srdf", package_dirs=[folder])
    (tmp_path / "scene.yaml").write_text(TABLE_FILE)
    SimulatedArm.scene = read_scene(tmp_path / "scene.yaml", arm).scene
    SimulatedArm.start = dict.fromkeys(arm.joint_names, 0.0)
    motors = {f"{name}.pos": {"joint": name} for name in arm.group("arm").joints}
    robot = guarded(
        {**motors, "gripper.pos": GRIPPER},
        {
            "motors": motors,
            "description": str(urdf),
            "srdf": str(tmp_path / "so101.srdf"),
            "package_dirs": [str(folder)],
            "group": "arm",
            "scene": str(tmp_path / "scene.yaml"),
        },
        tmp_path,
    )
    with robot:
        begin = robot.get_observation()
        turned = [{**begin, "shoulder_pan.pos": 0.3 * k} for k in range(30)]
        sent, free = play(robot, turned)
        assert ActionOutcome.AS_GIVEN in {each.outcome for each in free}
        assert sent[-1] == pytest.approx(turned[-1], abs=0.5)
        down = [{**turned[-1], "shoulder_lift.pos": 0.4 * k, "gripper.pos": 30.0} for k in range(150)]
        assert "table" in touch("arm", down)
        sent, held = play(robot, down)
        assert sent[-1]["shoulder_lift.pos"] < down[-1]["shoulder_lift.pos"] - 5.0
        assert held[-1].reason and sent[-1]["gripper.pos"] == 30.0
        touched = robot.robot.touched
    assert not any("table" in pair for pair in touched)
