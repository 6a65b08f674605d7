"""Robot trajectory files."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from trajopt import Trajectory
from trajopt.files.moveit import read_trajectory, write_trajectory
from trajopt.values.errors import FileFormatError, ShapeError

numbers = st.floats(-1e6, 1e6, allow_subnormal=False)


@st.composite
def trajectories(draw: st.DrawFn) -> Trajectory:
    joints, points = draw(st.integers(1, 4)), draw(st.integers(2, 5))
    steps = draw(st.lists(st.floats(1e-6, 100.0), min_size=points - 1, max_size=points - 1))
    times = np.concatenate(([0.0], np.cumsum(steps)))
    orders = draw(st.integers(1, 3))
    columns = [draw(arrays(np.float64, (points, joints), elements=numbers)) for _ in range(orders)]
    return Trajectory(tuple(f"joint {i}" for i in range(joints)), times, *columns)


@given(trajectory=trajectories())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_round_trip(trajectory: Trajectory, tmp_path: Path) -> None:
    write_trajectory(trajectory, tmp_path / "t.yaml")
    back = read_trajectory(tmp_path / "t.yaml")
    assert back.joint_names == trajectory.joint_names
    assert back.interpolation is trajectory.interpolation
    assert np.abs(back.times - trajectory.times).max() <= 0.5e-9 + 1e-15 * trajectory.duration
    kept = back.times == trajectory.times
    for order, (read, written) in enumerate(
        (
            (back.positions, trajectory.positions),
            (back.velocities, trajectory.velocities),
            (back.accelerations, trajectory.accelerations),
        )
    ):
        assert (read is None) == (written is None)
        if read is not None and written is not None:
            assert np.array_equal(read[kept], written[kept])
            assert np.array_equal(read[~kept], trajectory(back.times[~kept], order))
    write_trajectory(back, tmp_path / "again.yaml")
    assert (tmp_path / "again.yaml").read_text() == (tmp_path / "t.yaml").read_text()


def test_message_as_moveit_has_it(tmp_path: Path) -> None:
    trajectory = Trajectory(("a",), np.array((0.0, 1.25)), np.array(((0.0,), (1e-5,))), np.zeros((2, 1)))
    write_trajectory(trajectory, tmp_path / "t.yaml")
    document = yaml.safe_load((tmp_path / "t.yaml").read_text())
    message = document["joint_trajectory"]
    assert message["joint_names"] == ["a"]
    assert message["header"]["frame_id"] == ""
    assert message["points"][1] == {
        "positions": [1e-5],
        "velocities": [0.0],
        "time_from_start": {"sec": 1, "nanosec": 250000000},
    }
    assert document["multi_dof_joint_trajectory"]["points"] == []
    assert list(tmp_path.iterdir()) == [tmp_path / "t.yaml"]


def test_points_within_a_nanosecond(tmp_path: Path) -> None:
    trajectory = Trajectory(("a",), np.array((0.0, 1e-10)), np.zeros((2, 1)))
    with pytest.raises(ShapeError, match="nanosecond"):
        write_trajectory(trajectory, tmp_path / "t.yaml")
    assert not list(tmp_path.iterdir())


def test_seconds_by_their_old_names(write: Callable[..., Path]) -> None:
    back = read_trajectory(
        write("""
        joint_trajectory:
          header: {seq: 1, stamp: {secs: 0, nsecs: 0}, frame_id: world}
          joint_names: [a]
          points:
            - {positions: [0], velocities: [], effort: [], time_from_start: {secs: 0, nsecs: 0}}
            - {positions: [1], velocities: [], effort: [], time_from_start: {secs: 1, nsecs: 5}}
        """)
    )
    assert back.times[1] == 1.000000005
    assert back.velocities is None


NAMES = ("odom/x", "odom/y", "odom/theta")


@pytest.mark.parametrize("orders", [1, 2, 3])
@pytest.mark.parametrize("others", [("a", "b"), ()])
def test_a_base_in_the_plane_is_a_joint_of_several_degrees_of_freedom(
    tmp_path: Path, orders: int, others: tuple[str, ...]
) -> None:
    rng = np.random.default_rng(orders)
    names = (*others, *NAMES)
    rows = [rng.normal(size=(9, len(names))) for _ in range(orders)]
    rows[0][:, -1] = np.linspace(0.5, 9.0, 9)  # more than a turn, in steps of less than half a turn
    trajectory = Trajectory(names, np.arange(9.0), *rows)
    write_trajectory(trajectory, tmp_path / "motion.yaml")
    document = yaml.safe_load((tmp_path / "motion.yaml").read_text())
    assert document["joint_trajectory"]["joint_names"] == list(others)
    several = document["multi_dof_joint_trajectory"]
    assert several["joint_names"] == ["odom"] and len(several["points"]) == 9
    turned = several["points"][0]["transforms"][0]["rotation"]
    assert turned == pytest.approx({"x": 0.0, "y": 0.0, "z": np.sin(0.25), "w": np.cos(0.25)})
    back = read_trajectory(tmp_path / "motion.yaml")
    assert back.interpolation is trajectory.interpolation
    assert back.joint_names == (*NAMES, *others)
    for order in range(3):
        at = np.linspace(0.0, 8.0, 50)
        assert back.ordered(names)(at, order) == pytest.approx(trajectory(at, order), abs=1e-9)


POINT = "{transforms: [{translation: [1, 2, 0], rotation: [0, 0, 1, 0]}], time_from_start: "


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("joint_names: [odom], points: [{transforms: [{translation: [0, 0, 1]}]}]", "raise or tilt"),
        (f"joint_names: [odom], points: [{POINT}0}}]", "two points at least"),
        (f"joint_names: [], points: [{POINT}0}}, {POINT}1}}]", "every joint once"),
        (f"joint_names: [a, b], points: [{POINT}0}}, {POINT}1}}]", "1 transforms for 2 joints"),
        (
            f"joint_names: [odom], points: [{POINT}0, velocities: [{{linear: [0, 0, 1]}}]}}, {POINT}1}}]",
            "other velocities|raise or tilt",
        ),
        ("joint_names: [odom], points: [{}]", "no transforms"),
    ],
)
def test_joints_of_several_degrees_of_freedom_that_are_none(
    write: Callable[..., Path], text: str, says: str
) -> None:
    with pytest.raises(FileFormatError, match=says):
        read_trajectory(write(f"multi_dof_joint_trajectory: {{{text}}}"))


def test_a_moveit_trajectory_of_base_and_arm_is_read(write: Callable[..., Path]) -> None:
    """MoveIt states no accelerations of joints of several degrees of freedom: none are taken then."""
    point = "{positions: [0], velocities: [0], accelerations: [0], time_from_start: "
    text = f"""
    joint_trajectory: {{joint_names: [a], points: [{point}0}}, {point}1}}]}}
    multi_dof_joint_trajectory:
      joint_names: [odom]
      points:
        - {POINT}0, velocities: [{{linear: {{x: 0.5}}, angular: {{z: 0.1}}}}]}}
        - {POINT}1, velocities: [{{linear: {{x: 0.5}}, angular: {{z: 0.1}}}}]}}
    """
    with pytest.raises(FileFormatError, match="linear"):
        read_trajectory(write(text))
    full = text.replace("{x: 0.5}", "{x: 0.5, y: 0, z: 0}").replace("{z: 0.1}", "{x: 0, y: 0, z: 0.1}")
    back = read_trajectory(write(full))
    assert back.joint_names == (*NAMES, "a") and back.accelerations is None
    assert back.positions[0] == pytest.approx([1.0, 2.0, np.pi, 0.0])
    assert back.velocities is not None and back.velocities[0] == pytest.approx([0.5, 0.0, 0.1, 0.0])
    with pytest.raises(FileFormatError, match="different times"):
        read_trajectory(write(full.replace("time_from_start: 1}]}", "time_from_start: 2}]}")))
