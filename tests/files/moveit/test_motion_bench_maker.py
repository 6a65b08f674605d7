"""The shared MotionBenchMaker problems: all of them parse, and say what the files say."""

from collections.abc import Callable
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml

import trajopt as to
from trajopt.files.moveit import RequestFile, SceneFile, read_request, read_scene
from trajopt.problem.requirements import JointPositions
from trajopt.values.shapes.shapes import Box, Cylinder

ORIGIN = {"position": [0, 0, 0], "orientation": [0, 0, 0, 1]}
SETS = (
    "bookshelf_small",
    "bookshelf_tall",
    "bookshelf_thin",
    "box",
    "cage",
    "table_pick",
    "table_under_pick",
)
ALL = [(name, number) for name in SETS for number in range(1, 51)]
SOME = ALL[:: len(ALL) // 9][:10]


def read_pair(folder: Path, number: int, robot: to.Robot) -> tuple[SceneFile, RequestFile]:
    scene = read_scene(folder / f"scene{number:04d}.yaml", robot)
    return scene, read_request(folder / f"request{number:04d}.yaml", scene)


def check_against_text(path: Path, file: SceneFile) -> None:
    """Compare with the file's own numbers, read in another way."""
    document = yaml.load(path.read_text(), yaml.CSafeLoader)
    matrix = document["allowed_collision_matrix"]
    names = [name for name in matrix["entry_names"] if name in file.scene.robot.links]
    rows = dict(zip(matrix["entry_names"], matrix["entry_values"], strict=True))
    for a, b in combinations(names, 2):
        assert file.scene.may_touch(a, b) == rows[a][matrix["entry_names"].index(b)]
    bodies = {body.owner: body for body in file.scene.object_bodies()}
    assert set(bodies) == {item["id"] for item in document["world"]["collision_objects"]}
    for item in document["world"]["collision_objects"]:
        body = bodies[item["id"]]
        (primitive,), (pose,) = item["primitives"], item["primitive_poses"]
        outer, inner = (
            pin.XYZQUATToSE3(np.array([*p["position"], *p["orientation"]], dtype=float))
            for p in (item.get("pose", ORIGIN), pose)
        )
        assert np.allclose((outer * inner).homogeneous, body.placement.homogeneous, atol=1e-6)
        if primitive["type"] == "box":
            assert body.shape == Box(*primitive["dimensions"])
        else:
            height, radius = primitive["dimensions"]
            assert body.shape == Cylinder(radius=radius, length=height)


def check_panda(folder: Path, number: int, robot: to.Robot) -> None:
    scene, request = read_pair(folder, number, robot)
    assert not scene.notes
    assert set(request.notes) == {"planner_id: is ignored", "num_planning_attempts: is ignored"}
    problem = request.problem()
    assert problem.group == "panda_arm"
    assert problem.velocity_scaling == problem.acceleration_scaling == 1.0
    assert request.allowed_planning_time == 60.0
    fingers = robot.index(["panda_finger_joint1", "panda_finger_joint2"])
    assert (problem.start_positions[fingers] == 0.065).all()
    (goal,) = problem.goals
    assert isinstance(goal, JointPositions)
    assert tuple(goal.positions) == robot.group("panda_arm").joints
    assert set(goal.below.values()) == set(goal.above.values()) == {1e-4}
    assert scene.scene.may_touch("panda_link4", "panda_link0")
    assert not scene.scene.may_touch("panda_link5", "panda_link0")
    check_against_text(folder / f"scene{number:04d}.yaml", scene)


def check_ur5(folder: Path, number: int, robot: to.Robot) -> None:
    scene, request = read_pair(folder, number, robot)
    assert len(scene.notes) == 1
    assert "box_link" in scene.notes[0]
    problem = request.problem()
    assert problem.group == "manipulator"
    assert problem.goals[0].positions.keys() == set(robot.group("manipulator").joints)
    assert problem.start_positions.shape == (6,)
    check_against_text(folder / f"scene{number:04d}.yaml", scene)


@pytest.mark.parametrize(("name", "number"), SOME)
def test_some_panda_problems(shared_data: Path, panda: to.Robot, name: str, number: int) -> None:
    check_panda(shared_data / "motionbenchmaker" / "panda" / name, number, panda)


@pytest.mark.parametrize(("name", "number"), SOME)
def test_some_ur5_problems(shared_data: Path, foreign_ur5: to.Robot, name: str, number: int) -> None:
    check_ur5(shared_data / "motionbenchmaker" / "ur5" / name, number, foreign_ur5)


@pytest.mark.slow
@pytest.mark.parametrize("name", SETS)
def test_all_panda_problems(shared_data: Path, panda: to.Robot, name: str) -> None:
    for number in range(1, 51):
        check_panda(shared_data / "motionbenchmaker" / "panda" / name, number, panda)


@pytest.mark.slow
@pytest.mark.parametrize("name", SETS)
def test_all_ur5_problems(shared_data: Path, foreign_ur5: to.Robot, name: str) -> None:
    for number in range(1, 51):
        check_ur5(shared_data / "motionbenchmaker" / "ur5" / name, number, foreign_ur5)


FOREIGN = {
    "fetch": (
        "arm_with_torso",
        8,
        1,
        "torso_lift_link_collision_2",
        ("l_wheel_joint, r_wheel_joint", "bellows_joint (at 0.05)"),
    ),
    "baxter": ("both_arms", 14, 0, "torso_collision_2", ("l_gripper_r_finger_joint (at -0.05)",)),
}
"""Group, its joints, notes on the state of the scene, link that no matrix names, strangers."""


@pytest.fixture(scope="session")
def foreign(shared_data: Path) -> Callable[[str], to.Robot]:
    """The Fetch and the Baxter that their problems were made for."""

    @cache
    def load(name: str) -> to.Robot:
        folder = shared_data / "motionbenchmaker" / name / "robot"
        return to.load(folder / f"{name}.urdf", srdf=folder / f"{name}.srdf", package_dirs=[folder])

    return load


def check_foreign(folder: Path, number: int, robot: to.Robot) -> None:
    """Look at a problem whose files say more than the robot has, and less of its matrix."""
    scene, request = read_pair(folder, number, robot)
    group, joints, states, unnamed, strangers = FOREIGN[robot.name]
    assert sum("robot_state.joint_state" in note for note in scene.notes) == states
    assert any("does not name" in note and unnamed in note for note in scene.notes)
    said = "\n".join(note for note in request.notes if "start_state.joint_state" in note)
    assert all(stranger in said for stranger in strangers)
    problem = request.problem()
    assert problem.group == group and len(robot.group(group).joints) == joints
    check_against_text(folder / f"scene{number:04d}.yaml", scene)
    pairs = {pair for pair in robot.disabled_pairs if unnamed in pair}
    assert pairs and all(scene.scene.may_touch(*pair) for pair in pairs)


@pytest.mark.parametrize("number", [1, 50])
@pytest.mark.parametrize(
    ("robot", "name"),
    [("fetch", "cage"), ("fetch", "table_pick"), ("baxter", "bookshelf_tall_both_arms_hard")],
)
def test_some_problems_of_fetch_and_baxter(
    shared_data: Path, foreign: Callable[[str], to.Robot], robot: str, name: str, number: int
) -> None:
    check_foreign(shared_data / "motionbenchmaker" / robot / name, number, foreign(robot))


@pytest.mark.slow
@pytest.mark.parametrize("robot", FOREIGN)
def test_all_problems_of_fetch_and_baxter(
    shared_data: Path, foreign: Callable[[str], to.Robot], robot: str
) -> None:
    folders = [each for each in (shared_data / "motionbenchmaker" / robot).iterdir() if each.name != "robot"]
    assert len(folders) in (3, 7)
    for folder in folders:
        for number in range(1, 51):
            check_foreign(folder, number, foreign(robot))
