"""What trajopt exports, it reads."""

import json
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.files.export import EXPORTERS, export
from trajopt.files.moveit import read_trajectory
from trajopt.files.moveit.trajectories import trajectory_message
from trajopt.values.errors import FileFormatError

JOINTS = ("pan", "lift, left", "slide")
READ = sorted(set(EXPORTERS) - {"urscript", "urscript-movej", "urscript-program", "mcap", "rerun"})


@pytest.fixture
def motion() -> to.Trajectory:
    """From rest to rest in 1.234 s through a point at speed."""
    return to.Trajectory(
        JOINTS,
        np.array((0.0, 0.7, 1.234)),
        np.array(((0.1, -1.0, 0.0), (0.4, -0.7, 0.2), (1.0, 0.3, 0.25))),
        np.array(((0.0, 0.0, 0.0), (0.9, 1.1, 0.3), (0.0, 0.0, 0.0))),
        np.array(((0.0, 0.0, 0.0), (0.5, -0.4, -0.1), (0.0, 0.0, 0.0))),
    )


@pytest.mark.parametrize("suffix", [".yaml", ".json", ".csv"])
@pytest.mark.parametrize("name", READ)
def test_every_export_but_urscript_is_read(
    motion: to.Trajectory, tmp_path: Path, name: str, suffix: str
) -> None:
    if (name == "csv") != (suffix == ".csv"):
        pytest.skip("a table is .csv, a message is not")
    file = tmp_path / f"motion{suffix}"
    export(motion, file, to=name)
    back, due = read_trajectory(file), motion.sampled(100.0) if name == "csv" else motion
    assert back.joint_names == JOINTS
    assert np.allclose(back.times, due.times, rtol=0.0, atol=1e-9)
    for order in ("positions", "velocities", "accelerations"):
        assert np.array_equal(getattr(back, order), getattr(due, order)), order


@pytest.mark.parametrize("name", sorted({*READ} - {"csv"}))
def test_a_motion_at_its_limits_holds_them_as_it_is_read_back(tmp_path: Path, name: str) -> None:
    robot = to.load("planar2")
    swing = to.Problem(scene=to.Scene(robot), start={}, goal=dict.fromkeys(robot.joint_names, 0.7))
    plan = to.plan(swing).require()
    export(plan, tmp_path / "motion.yaml", to=name)
    back = read_trajectory(tmp_path / "motion.yaml")
    assert not np.array_equal(back.times, plan.trajectory.times)
    assert to.judge(swing, back).verified, str(to.judge(swing, back))
    sent = trajectory_message(plan.trajectory).joint_trajectory
    assert [list(point.positions) for point in sent.points] == back.positions.tolist()


@pytest.mark.parametrize("name", ["urscript", "urscript-movej", "urscript-program"])
def test_a_urscript_program_differs_from_a_broken_file(tmp_path: Path, name: str) -> None:
    ur = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    rows = np.linspace(np.zeros(6), np.full(6, 0.2), 3)
    still = np.zeros_like(rows)
    motion = to.Trajectory(
        tuple(f"{each}_joint" for each in ur), np.array((0.0, 1.0, 2.0)), rows, still, still
    )
    export(motion, tmp_path / "motion.script", to=name)
    with pytest.raises(
        FileFormatError, match=r"motion\.script: is a program in URScript, which is not read back"
    ):
        read_trajectory(tmp_path / "motion.script")
    with pytest.raises(FileFormatError, match="No such file"):
        read_trajectory(tmp_path / "other.script")


def test_a_table_may_leave_out_derivatives_and_mix_its_columns(tmp_path: Path) -> None:
    file = tmp_path / "t.CSV"
    file.write_text("position_b, velocity_a,time,position_a,velocity_b\n1,2,0,3,4\n5,6,0.5,7,8\n\n")
    back = read_trajectory(file)
    assert back.joint_names == ("b", "a") and back.times.tolist() == [0.0, 0.5]
    assert back.positions.tolist() == [[1.0, 3.0], [5.0, 7.0]] and back.accelerations is None
    assert back.velocities is not None and back.velocities.tolist() == [[4.0, 2.0], [8.0, 6.0]]
    file.write_text("time,position_a\n0,1\n1,2\n")
    assert read_trajectory(file).velocities is None


TABLES = {
    "": "two rows at least",
    "time,position_a\n0,1\n": "two rows at least",
    "0,1\n1,2\n2,3\n": "first line must name the columns",
    "time,position_\n0,1\n1,2\n": "first line must name the columns",
    "time,position_a,effort_a\n0,1,2\n1,2,3\n": "unknown column 'effort_a'",
    "time,position_a,position_a\n0,1,2\n1,2,3\n": "the column 'position_a' twice",
    "time,position_a,position_b,velocity_a\n0,1,2,3\n1,2,3,4\n": "has no column velocity_b",
    "time,position_a,velocity_b\n0,1,2\n1,2,3\n": "has no column velocity_a",
    "time,position_a,acceleration_a\n0,1,2\n1,2,3\n": "accelerations, but no velocities",
    "time,position_a\n0,1\n1\n": "row 2: 1 numbers for 2 columns",
    "time,position_a\n0,1\n1,fast\n": "row 2, position_a: must be a finite number, is 'fast'",
    "time,position_a\n0,1\n1,nan\n": "row 2, position_a: must be a finite number, is 'nan'",
    "time,position_a\n0.5,1\n1,2\n": "row 1, time: must be 0, is 0.5 s",
    "time,position_a\n0,1\n0,2\n": "row 2, time: 0 s does not come after 0 s",
    'time,position_a\n0,"1\n1,2\n': "is not a table",
}


@pytest.mark.parametrize("text", TABLES)
def test_tables_that_are_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(FileFormatError, match=rf"t\.csv.*{TABLES[text]}"):
        read_trajectory(tmp_path / "t.csv")


POINTS = {
    "joint_names": ["a"],
    "points": [
        {"time_from_start": 0, "positions": [0.0]},
        {"time_from_start": {"sec": 1}, "positions": [1.0]},
    ],
}
DOCUMENTS: dict[str, tuple[dict[str, object], str]] = {
    "no trajectory": ({"motion": POINTS}, "holds no trajectory .*FollowJointTrajectory goal"),
    "a failure": (
        {"status": "UNREACHABLE", "message": "too far", "joint_names": ["a"], "points": []},
        "holds no motion: too far",
    ),
    "a goal of more": ({"trajectory": POINTS, "tolerance": 1}, "unknown key 'tolerance'"),
    "a goal of a base": (
        {"trajectory": POINTS, "multi_dof_trajectory": {"points": [{}]}},
        "multi_dof_trajectory: cannot be read",
    ),
    "several": ({"trajectory": [POINTS]}, "must be a mapping|holds no trajectory"),
}


@pytest.mark.parametrize("case", DOCUMENTS)
def test_documents_without_a_motion(tmp_path: Path, case: str) -> None:
    document, says = DOCUMENTS[case]
    (tmp_path / "t.json").write_text(json.dumps(document))
    with pytest.raises(FileFormatError, match=says):
        read_trajectory(tmp_path / "t.json")


def test_a_goal_to_execute_holds_moveits_message(tmp_path: Path) -> None:
    (tmp_path / "t.json").write_text(json.dumps({"trajectory": {"joint_trajectory": POINTS}}))
    assert read_trajectory(tmp_path / "t.json").duration == 1.0
