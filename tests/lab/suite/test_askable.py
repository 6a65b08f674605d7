"""What can be asked at all is said by a script that knows nothing of the planner, and says why not."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from benchmarks.askable import faults, problems, read_machine

URDF = """<robot name="two links">
  <link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="upper"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
    <origin xyz="0.5 0 0"/></inertial></link>
  <link name="fore"><collision><origin xyz="0.5 0 0"/><geometry><box size="0.9 0.05 0.05"/></geometry>
    </collision></link>
  <link name="shoulder"><collision><origin xyz="0.9 0 0"/><geometry><sphere radius="0.1"/></geometry>
    </collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-3.14159" upper="3.14159" effort="{effort}" velocity="1"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/><axis xyz="0 0 1"/>
    <origin xyz="1 0 0"/><limit effort="0" velocity="1"/></joint>
  <joint name="welded" type="fixed"><parent link="fore"/><child link="shoulder"/></joint>
</robot>"""
SRDF = '<robot name="two links"><disable_collisions link1="fore" link2="base" reason="Never"/></robot>'

Ask = Callable[..., list[str]]


@pytest.fixture
def ask(tmp_path: Path) -> Ask:
    """Ask the two links to go from 0 to a goal, past a ball on a shelf."""

    def asked(
        goal: dict[str, float], *, ball: float = 5.0, effort: float = 0.0, matrix: object = None
    ) -> list[str]:
        (tmp_path / "arm.urdf").write_text(URDF.format(effort=effort))
        (tmp_path / "arm.srdf").write_text(SRDF)
        still = {"joint_state": {"name": ["shoulder", "welded", "lost"], "position": [0.0, 0.3, 1.0]}}
        shape = {"type": "cylinder", "dimensions": [0.4, 0.05]}
        place = {"position": [0.0, ball, 0.0], "orientation": [0.0, 0.0, 0.0, 1.0]}
        thing = {"id": "ball", "primitives": [shape], "primitive_poses": [place],
                 "pose": {"position": [1.0, 0.0, 0.0], "orientation": [0, 0, 0, 1]}}  # fmt: skip
        scene = {
            "robot_state": still,
            "world": {"collision_objects": [thing]},
            "allowed_collision_matrix": matrix or {"entry_names": [], "entry_values": []},
        }
        joints = [{"joint_name": name, "position": value} for name, value in goal.items()]
        (tmp_path / "scene0001.yaml").write_text(yaml.safe_dump(scene))
        (tmp_path / "request0001.yaml").write_text(
            yaml.safe_dump({"start_state": still, "goal_constraints": [{"joint_constraints": joints}]})
        )
        machine = read_machine.__wrapped__(tmp_path / "arm.urdf", tmp_path / "arm.srdf", tmp_path)
        return faults(machine, tmp_path / "scene0001.yaml", tmp_path / "request0001.yaml")

    return asked


def test_it_knows_nothing_of_the_planner() -> None:
    script = (
        "import sys, benchmarks.askable; "
        "sys.exit(any(name.split('.')[0].startswith('trajopt') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", script], check=False, timeout=100).returncode == 0


def test_free_configurations_within_limits_are_askable(ask: Ask) -> None:
    assert ask({"shoulder": 1.0, "elbow": 9.0}) == []


def test_outside_a_limit(ask: Ask) -> None:
    assert ask({"shoulder": 3.2}) == ["goal: shoulder at 3.2 is outside its limits"]
    assert ask({"shoulder": 3.141592653589793}) == []  # the limit is printed with five decimals


def test_configurations_in_contact_are_not_askable(ask: Ask) -> None:
    assert ask({"elbow": 1.5707963}, ball=0.9) == ["goal: fore touches ball", "goal: shoulder touches ball"]
    assert ask({"elbow": 0.1}, ball=0.0)[0].startswith("start: fore touches ball")
    # Folded back, the forearm and what is welded to it lie in the base: the SRDF excuses the one only.
    assert ask({"elbow": 3.14159}) == ["goal: base touches shoulder"]


def test_the_allowed_collision_matrix_decides_for_its_pairs(ask: Ask) -> None:
    names = ["base", "fore", "shoulder"]
    matrix = {"entry_names": names, "entry_values": [[False, False, True], [False] * 3, [True, False, False]]}
    assert ask({"elbow": 3.14159}, matrix=matrix) == ["goal: base touches fore"]


def test_configurations_that_cannot_be_held_are_not_askable(ask: Ask) -> None:
    assert ask({"shoulder": 1.5}, effort=4.0) == [
        "start: shoulder needs 4.905 to hold its load, its effort limit is 4"
    ]
    assert ask({"shoulder": 1.5}, effort=5.0) == []
    assert ask({"shoulder": 1.5}, effort=0.0) == []  # not stated


def test_the_fetch_as_it_was_found(shared_data: Path) -> None:
    folder = shared_data / "motionbenchmaker" / "fetch"
    machine = read_machine(folder / "robot/fetch.urdf", folder / "robot/fetch.srdf", folder / "robot")
    found = {name: faults(machine, *files) for name, files in problems(folder, 10).items()}
    assert len(found) == 70
    assert {name for name, reasons in found.items() if reasons} == {
        "bookshelf_tall/3", "table_under_pick/5", "table_under_pick/8"
    }  # fmt: skip


def test_configurations_that_a_baxter_cannot_hold(shared_data: Path) -> None:
    folder = shared_data / "motionbenchmaker" / "baxter"
    machine = read_machine(folder / "robot/baxter.urdf", folder / "robot/baxter.srdf", folder / "robot")
    found = problems(folder, 5)
    (reason,) = faults(machine, *found["bookshelf_tall_both_arms_easy/5"])
    assert reason == "goal: left_s1 needs 50.028 to hold its load, its effort limit is 50"
    assert faults(machine, *found["bookshelf_tall_both_arms_easy/1"]) == []
