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
from trajopt.errors import FileFormatError, ShapeError
from trajopt.moveit import read_trajectory, write_trajectory

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
    assert np.array_equal(back.positions, trajectory.positions)
    for mine, theirs in (
        (back.velocities, trajectory.velocities),
        (back.accelerations, trajectory.accelerations),
    ):
        assert (mine is None and theirs is None) or np.array_equal(mine, theirs)
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


def test_joints_of_several_degrees_of_freedom(write: Callable[..., Path]) -> None:
    with pytest.raises(FileFormatError, match="not supported"):
        read_trajectory(write("multi_dof_joint_trajectory: {points: [{}]}"))
