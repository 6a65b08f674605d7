"""A world that a server answers: scripts change one line, and answers are those of one in this process."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from trajopt.ros.commander.geometry_msgs.msg import PoseStamped
from trajopt.ros.commander.moveit_msgs.msg import MoveItErrorCodes

import trajopt as to
from tests.server.serving import Serving
from trajopt.ros.commander import MoveGroupCommander, MoveItCommanderException, PlanningSceneInterface, World
from trajopt.values.errors import MissingExtra, ModelError

FOLDER = Path(__file__).parents[3] / "examples" / "from_moveit"
FAST = "first_pose_goal"
SCRIPTS = [
    pytest.param(path, id=path.stem, marks=() if path.stem == FAST else pytest.mark.slow)
    for path in sorted(FOLDER.glob("*.py"))
]
ONE_LINE = 'moveit_commander.World("panda")'


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """`trajopt serve` with a Panda, in a process of its own: its address."""
    try:
        to.load("panda")
    except MissingExtra:
        pytest.skip("the Panda's meshes are not installed")
    command = [sys.executable, "-m", "trajopt", "serve", "--robot", "panda", "--port", "0", "--workers", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        assert server.stdout is not None
        try:
            yield server.stdout.readline().split()[-1]
        finally:
            server.terminate()


@pytest.mark.parametrize("path", SCRIPTS)
def test_scripts_run_against_a_server_when_one_line_is_changed(
    path: Path, address: str, tmp_path: Path
) -> None:
    text = path.read_text()
    assert text.count(ONE_LINE) == 1
    (tmp_path / path.name).write_text(text.replace(ONE_LINE, f'moveit_commander.World(url="{address}")'))
    told = subprocess.run(
        [sys.executable, str(tmp_path / path.name)],
        capture_output=True,
        text=True,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        check=False,
    )
    assert told.returncode == 0, told.stdout + told.stderr
    assert told.stderr == ""
    assert "verified: all" in told.stdout
    assert "FAIL" not in told.stdout


def box_at(x: float, y: float) -> PoseStamped:
    pose = PoseStamped()
    pose.header.frame_id = "base"
    pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = x, y, 0.1
    pose.pose.orientation.w = 1.0
    return pose


def planned(world: World) -> MoveGroupCommander:
    """Plan past a box."""
    group = MoveGroupCommander("arm", world=world)
    PlanningSceneInterface(world=world).add_box("box", box_at(0.9, 0.1), size=(0.1, 0.1, 0.1))
    group.plan("straight")
    return group


def test_the_answer_is_the_one_of_a_world_here(lab_arm: to.Robot, lab_server: Serving) -> None:
    here = planned(World(lab_arm))
    with World(url=lab_server.url) as world:
        there = planned(world)
    mine, its = here.get_last_result(), there.get_last_result()
    assert mine is not None and its is not None
    assert mine.verified == its.verified
    assert str(mine) == str(its)
    assert mine.counts == its.counts
    one, other = mine.require(), its.require()
    assert np.array_equal(one.trajectory.positions, other.trajectory.positions)
    assert str(one.certificate) == str(other.certificate)
    assert its.problem.scene is world.scene


def test_a_served_world_explains_failures_like_a_local_one(lab_arm: to.Robot, lab_server: Serving) -> None:
    with World(url=lab_server.url) as world:
        explained: list[str] = []
        for each in (World(lab_arm), world):
            PlanningSceneInterface(world=each).add_box("box", box_at(0.5, 0.0), size=(0.2, 0.2, 0.2))
            group = MoveGroupCommander("arm", world=each)
            assert not group.plan("straight")[0]
            result = group.get_last_result()
            assert result is not None
            explained += [f"{result}\n{result.explain()}"]
    assert explained[0] == explained[1]


def test_a_motion_that_is_under_way_is_stopped(lab_server: Serving) -> None:
    with World(url=lab_server.url, start="straight") as world:
        group = MoveGroupCommander("arm")
        begun = world.positions
        assert group.go("bent", wait=False)
        assert world.moving
        assert not group.go("straight")
        group.stop()
        outcome = group.get_last_outcome()
        assert outcome is not None and outcome.error_code.val == MoveItErrorCodes.PREEMPTED
        assert outcome.stopping_time is not None
        assert not world.moving
        assert group.go("straight")
        assert np.allclose(world.positions, begun, atol=1e-3)


def test_misuse_names_the_offender(lab_arm: to.Robot, lab_server: Serving) -> None:
    with pytest.raises(MoveItCommanderException, match="a server has its own robot"):
        World(lab_arm, url=lab_server.url)
    with pytest.raises(MoveItCommanderException, match="a server has its own robot"):
        World(url=lab_server.url, scene=to.Scene(lab_arm))
    with pytest.raises(MoveItCommanderException, match="no robot named 'lba'; did you mean 'lab'"):
        World("lba", url=lab_server.url)
    with pytest.raises(MoveItCommanderException, match="unreachable"):
        World(url="http://127.0.0.1:9")
    with pytest.raises(MoveItCommanderException, match="which robot"):
        World()
    with World(url=lab_server.url) as world:
        with pytest.raises(MoveItCommanderException, match="the server drives the robot"):
            _ = world.executor
        before = world.scene
        with pytest.raises(ModelError, match="the scene is of another robot"):
            world.edit(lambda scene: to.Scene(lab_arm))
        assert world.scene is before


def test_sessions_end_with_their_worlds(lab_server: Serving) -> None:
    before = len(lab_server.service.sessions)
    with World(url=lab_server.url) as world:
        with world:
            assert len(lab_server.service.sessions) == before + 1
        assert len(lab_server.service.sessions) == before + 1
    assert len(lab_server.service.sessions) == before
