"""Exported files, read back by code that is not trajopt's."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

import trajopt as to
from trajopt.files.export import EXPORTERS, Csv, export, exporter_named
from trajopt.files.moveit.trajectories import read_trajectory
from trajopt.values.arrays import Floats
from trajopt.values.errors import NameNotFound, ProblemError, ShapeError

JOINTS = ("pan", "lift, left", "slide")


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


def test_samples_are_the_motions_own_and_end_at_its_end(motion: to.Trajectory) -> None:
    samples = motion.sampled(100.0)
    assert samples.joint_names == JOINTS and len(samples.times) == 125
    assert np.allclose(samples.times[:-1], np.arange(124) / 100.0, atol=1e-12)
    assert samples.times[-1] == motion.duration
    for order, rows in enumerate((samples.positions, samples.velocities, samples.accelerations)):
        assert rows is not None and np.allclose(rows, motion(samples.times, order), atol=1e-12)
    assert np.array_equal(samples.positions[-1], motion.positions[-1])
    assert samples.velocities is not None and not samples.velocities[-1].any()


@pytest.mark.parametrize("hz", [0.1, 10.0, 50.0, 250.0, 1000.0 / 3.0])
def test_a_rate_that_divides_the_duration_makes_no_sliver(hz: float) -> None:
    line = to.Trajectory(("a",), np.array((0.0, 3.3)), np.array(((0.0,), (1.0,))))
    steps = np.diff(line.sampled(hz).times)
    assert (steps <= 1.01 / hz + 1e-12).all() and steps[-1] >= min(0.0099 / hz, 3.3)
    if hz in (10.0, 50.0, 250.0):
        assert len(steps) == round(3.3 * hz) and np.allclose(steps, 1.0 / hz)


def test_resampling_just_above_whole_steps_keeps_the_acceleration() -> None:
    """Over a step of nanoseconds the rounding of positions alone would ask for any acceleration."""
    times = np.array((0.0, 1.0 + 3e-9))
    still = np.zeros((2, 1))
    smooth = to.Trajectory(("a",), times, np.array(((0.0,), (1.0,))), still, still)
    samples = smooth.sampled(100.0)
    dense = samples(np.linspace(0.0, samples.duration, 5001), 2)
    assert np.diff(samples.times).min() > 0.0099
    assert np.abs(dense).max() <= np.abs(smooth(np.linspace(0.0, 1.0, 5001), 2)).max() * (1 + 1e-3)


@pytest.mark.parametrize("hz", [0.0, -1.0, np.nan, np.inf, 1e9])
def test_rates_that_cannot_be(motion: to.Trajectory, hz: float) -> None:
    with pytest.raises(ShapeError, match="hz"):
        motion.sampled(hz)


def test_sampled_speeds_do_not_exceed_the_motions(motion: to.Trajectory) -> None:
    """Also those that a controller takes from differences of positions."""
    dense = np.abs(motion(np.linspace(0.0, motion.duration, 20001), 1)).max(axis=0) * (1 + 1e-6)
    for hz in (20.0, 100.0, 125.0, 1000.0):
        samples = motion.sampled(hz)
        assert samples.velocities is not None
        steps = np.diff(samples.positions, axis=0) / np.diff(samples.times)[:, None]
        assert (np.abs(samples.velocities).max(axis=0) <= dense).all()
        assert (np.abs(steps).max(axis=0) <= dense).all()


@pytest.fixture(scope="module")
def swing() -> to.Trajectory:
    """As fast as a Panda's limits allow; its accelerations change within milliseconds."""
    panda = to.load("panda")
    goal = np.add(panda.positions("ready")[:7], (0.3, -0.3, 0.2, 0.3, -0.2, 0.4, 0.1))
    joints = panda.group("panda_arm").joints
    problem = to.Problem(
        scene=to.Scene(panda),
        group="panda_arm",
        start="ready",
        goal=dict(zip(joints, goal.tolist(), strict=True)),
    )
    return to.plan(problem).require().trajectory


@pytest.mark.parametrize("name", ["csv", "ros2", "ros2-topic", "moveit"])
def test_excess_of_accelerations_between_samples_is_a_note(
    swing: to.Trajectory, tmp_path: Path, name: str
) -> None:
    exported = export(swing, tmp_path / "t.csv", to=name, hz=100.0)
    notes = [note for note in exported.notes if note.startswith("loses: between the samples, acceleration")]
    assert len(notes) == 1
    found = re.search(r"up to ([\d.]+)% larger .*\((\w+)\)", notes[0])
    assert found is not None
    dense, joint = np.linspace(0.0, swing.duration, 50_001), swing.joint_names.index(found[2])
    reached, peak = (np.abs(each(dense, 2)).max(axis=0)[joint] for each in (swing.sampled(100.0), swing))
    assert float(found[1]) == pytest.approx(100.0 * (reached / peak - 1.0), abs=0.2) and reached > 1.01 * peak


def test_nothing_is_lost_by_smooth_motions_and_own_points(
    motion: to.Trajectory, swing: to.Trajectory, tmp_path: Path
) -> None:
    exports = (
        export(motion, tmp_path / "t.csv", to="csv", hz=1000.0),
        export(swing, tmp_path / "t.yaml", to="ros2"),
    )
    assert not any("loses" in note for exported in exports for note in exported.notes)


def test_a_table_has_a_column_for_each_number_of_each_joint(motion: to.Trajectory, tmp_path: Path) -> None:
    file = tmp_path / "new" / "motion.csv"
    exported = export(motion, file, to="csv", hz=50.0)
    with file.open(newline="") as opened:
        rows = list(csv.DictReader(opened))
    assert len(rows) == exported.points == 63 and "50 samples per second" in str(exported)
    for row in (rows[0], rows[20], rows[-1]):
        for order, what in enumerate(("position", "velocity", "acceleration")):
            values = [float(row[f"{what}_{name}"]) for name in JOINTS]
            assert np.allclose(values, motion(float(row["time"]), order), atol=1e-12)
    assert float(rows[-1]["time"]) == 1.234
    assert [float(rows[-1][f"position_{name}"]) for name in JOINTS] == [1.0, 0.3, 0.25]


def seconds(stamp: dict[str, int]) -> float:
    assert 0 <= stamp["nanosec"] < 10**9 and isinstance(stamp["sec"], int)
    return stamp["sec"] + stamp["nanosec"] * 1e-9


def hermite(points: list[dict[str, object]], t: float) -> Floats:
    """What ros2_control does between points with velocities and accelerations: a quintic through both."""
    times = [seconds(point["time_from_start"]) for point in points]  # type: ignore[arg-type]
    k = min(int(np.searchsorted(times, t, side="right")) - 1, len(points) - 2)
    h, (one, two) = times[k + 1] - times[k], points[k : k + 2]
    orders = [[np.eye(6)[i] * np.prod(range(i - d + 1, i + 1)) for i in range(6)] for d in range(3)]
    conditions = [
        [sum(row) * (x ** max(i - d, 0) if i >= d else 0.0) for i, row in enumerate(orders[d])]
        for x in (0.0, h)
        for d in range(3)
    ]
    given = [p[key] for p in (one, two) for key in ("positions", "velocities", "accelerations")]
    coefficients = np.linalg.solve(np.array(conditions), np.array(given))
    return (t - times[k]) ** np.arange(6) @ coefficients


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
@pytest.mark.parametrize(("to_", "place"), [("ros2", "trajectory"), ("ros2-topic", None)])
def test_messages_of_ros_2_lose_nothing(
    motion: to.Trajectory, tmp_path: Path, to_: str, place: str | None, suffix: str
) -> None:
    file = tmp_path / f"goal{suffix}"
    exported = export(motion, file, to=to_)
    read = json.loads if suffix == ".json" else yaml.safe_load
    message = read(file.read_text())
    if place is not None:
        assert set(message) == {"trajectory", "path_tolerance", "goal_tolerance", "goal_time_tolerance"}
        message = message[place]
    assert set(message) == {"header", "joint_names", "points"}
    assert message["joint_names"] == list(JOINTS)
    assert len(message["points"]) == exported.points == 3
    for t in np.linspace(0.0, motion.duration - 1e-9, 40):
        assert np.allclose(hermite(message["points"], float(t)), motion(t), atol=1e-8)
    assert message["points"][-1]["positions"] == [1.0, 0.3, 0.25]


def test_messages_at_a_rate(motion: to.Trajectory, tmp_path: Path) -> None:
    export(motion, tmp_path / "goal.yaml", to="ros2", hz=10.0)
    points = yaml.safe_load((tmp_path / "goal.yaml").read_text())["trajectory"]["points"]
    assert [seconds(point["time_from_start"]) for point in points[:3]] == [0.0, 0.1, 0.2]
    assert len(points) == 14 and points[-1]["time_from_start"] == {"sec": 1, "nanosec": 234000000}


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_moveits_message(motion: to.Trajectory, tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"robot{suffix}"
    export(motion, file, to="moveit")
    message = (json.loads if suffix == ".json" else yaml.safe_load)(file.read_text())
    assert message["joint_trajectory"]["points"][1]["velocities"] == [0.9, 1.1, 0.3]
    assert np.array_equal(read_trajectory(file).positions, motion.positions)


def test_a_base_in_the_plane_has_no_place_in_a_joint_trajectory(tmp_path: Path) -> None:
    names = ("base/x", "base/y", "base/theta", "arm")
    moving = to.Trajectory(names, np.array((0.0, 1.0)), np.array(((0.0,) * 4, (1.0, 0.5, 0.2, 0.3))))
    for name in ("ros2", "ros2-topic"):
        with pytest.raises(ShapeError, match=r"base in the plane .* export it to moveit"):
            export(moving, tmp_path / "goal.yaml", to=name)
    assert not (tmp_path / "goal.yaml").exists()
    export(moving, tmp_path / "robot.yaml", to="moveit")


def test_formats_have_names(motion: to.Trajectory, tmp_path: Path) -> None:
    assert all(exporter_named(name) == make() for name, make in EXPORTERS.items())
    with pytest.raises(NameNotFound, match="no format to export to named 'cvs'; did you mean 'csv'"):
        export(motion, tmp_path / "m.csv", to="cvs")
    with pytest.raises(ProblemError, match="to is an Exporter or the name of one, is 3"):
        export(motion, tmp_path / "m.csv", to=3)  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match="export: give a plan"):
        export("plan.json", tmp_path / "m.csv", to=Csv())  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match="path must be the path of a file"):
        export(motion, None, to=Csv())  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())
