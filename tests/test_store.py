"""Trajectories and plans on disk."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.files.moveit.test_robot_trajectory import trajectories
from trajopt import Trajectory
from trajopt.files.moveit import write_trajectory
from trajopt.files.moveit.trajectories import read_trajectory
from trajopt.values.documents.document import write_json
from trajopt.values.errors import FileFormatError
from trajopt.values.trajectory import Interpolation

POINT = {"time_from_start": 0.0, "positions": [0.0]}


def same(a: Trajectory, b: Trajectory) -> bool:
    columns = (
        (a.times, b.times),
        (a.positions, b.positions),
        (a.velocities, b.velocities),
        (a.accelerations, b.accelerations),
    )
    return a.joint_names == b.joint_names and all(
        (x is None and y is None) or (x is not None and y is not None and np.array_equal(x, y))
        for x, y in columns
    )


@given(trajectory=trajectories())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_round_trip_is_exact(trajectory: Trajectory, tmp_path: Path) -> None:
    write_json(tmp_path / "t.json", trajectory.as_dict())
    assert same(read_trajectory(tmp_path / "t.json"), trajectory)


def two_points(**more: object) -> dict[str, object]:
    points = [POINT | more, POINT | more | {"time_from_start": 1.0}]
    return {"joint_names": ["a"], "points": points}


@pytest.mark.parametrize(
    ("more", "interpolation"),
    [
        ({}, Interpolation.LINEAR),
        ({"velocities": [], "accelerations": []}, Interpolation.LINEAR),
        ({"velocities": [0.0]}, Interpolation.CUBIC),
        ({"velocities": [0.0], "accelerations": [0.0]}, Interpolation.QUINTIC),
    ],
)
def test_taken_as_written(tmp_path: Path, more: dict[str, list[float]], interpolation: Interpolation) -> None:
    write_json(tmp_path / "t.json", two_points(**more))
    assert read_trajectory(tmp_path / "t.json").interpolation is interpolation


def test_plan_with_more_in_it(tmp_path: Path) -> None:
    plan = {"status": "verified", "certificate": {"clearance": 0.01}} | two_points(effort=[1.0], name="x")
    write_json(tmp_path / "plan.json", plan)
    assert read_trajectory(tmp_path / "plan.json").duration == 1.0


def test_moveit_messages(tmp_path: Path) -> None:
    trajectory = Trajectory(("a",), np.array((0.0, 0.5)), np.array(((0.0,), (1.0,))))
    write_trajectory(trajectory, tmp_path / "t.yaml")
    assert same(read_trajectory(tmp_path / "t.yaml"), trajectory)
    document = {"joint_trajectory": two_points()}
    write_json(tmp_path / "t.json", document)
    assert read_trajectory(tmp_path / "t.json").duration == 1.0
    (tmp_path / "u.yml").write_text(json.dumps(two_points()))
    assert read_trajectory(tmp_path / "u.yml").duration == 1.0


def changed(place: int, **more: object) -> dict[str, object]:
    document = two_points(velocities=[0.0], accelerations=[0.0])
    points = document["points"]
    assert isinstance(points, list)
    points[place] = points[place] | more
    return document


BAD: dict[str, tuple[object, str]] = {
    "a list": ([1], "one mapping"),
    "no joints": ({"points": [POINT]}, "joint_names"),
    "a joint twice": (two_points() | {"joint_names": ["a", "a"]}, "every joint once"),
    "joints no list": (two_points() | {"joint_names": "a"}, "joint_names: must be a list"),
    "a joint no text": (two_points() | {"joint_names": [1]}, r"joint_names\[0\]: must be text"),
    "no points": ({"joint_names": ["a"]}, "two points at least, not 0"),
    "one point": ({"joint_names": ["a"], "points": [POINT]}, "two points at least, not 1"),
    "point no mapping": ({"joint_names": ["a"], "points": [1, 2]}, r"points\[0\]: must be a mapping"),
    "no time": (changed(1, time_from_start=None), r"points\[1\]\.time_from_start: must be a number"),
    "time no number": (changed(1, time_from_start="late"), r"points\[1\]\.time_from_start"),
    "start later": (changed(0, time_from_start=0.5), r"points\[0\]\.time_from_start: must be 0"),
    "time stands": (changed(1, time_from_start=0.0), r"points\[1\]\.time_from_start.*after"),
    "unknown unit": (changed(1, time_from_start={"sec": 1, "msec": 5}), "unknown key 'msec'"),
    "no positions": (changed(1, positions=[]), r"points\[1\]: has no positions"),
    "positions nowhere": (changed(0, positions=[]), r"points\[1\]: has positions, but the first"),
    "no positions at all": (two_points(positions=[]), "has no positions"),
    "too many positions": (changed(1, positions=[0.0, 1.0]), r"points\[1\]\.positions: 2 numbers for 1"),
    "some velocities": (changed(1, velocities=[]), r"points\[1\]: has no velocities"),
    "more accelerations": (changed(0, accelerations=[]), r"points\[1\]: has accelerations"),
    "accelerations alone": (two_points(accelerations=[0.0]), r"points\[0\]: has accelerations, but no velo"),
    "a text for a number": (changed(1, velocities=["fast"]), r"points\[1\]\.velocities\[0\]"),
    "a huge number": (changed(1, positions=[10**400]), r"points\[1\]\.positions\[0\]: must be finite"),
    "other joints": ({"joint_trajectory": {}, "multi_dof_joint_trajectory": {"points": [{}]}}, "multi_dof"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_trajectory(tmp_path: Path, case: str) -> None:
    document, message = BAD[case]
    (tmp_path / "bad.json").write_text(json.dumps(document))
    with pytest.raises(FileFormatError, match=message) as caught:
        read_trajectory(tmp_path / "bad.json")
    assert "bad.json" in str(caught.value)


@pytest.mark.parametrize(
    "text",
    ["", "{", '{"joint_names": ["a"], "points": [}', "\x00", "[" * 100000, "- " * 100000],
    ids=["empty", "open", "crossed", "binary", "deep", "deep blocks"],
)
@pytest.mark.parametrize("name", ["bad.json", "bad.yaml"])
def test_broken_file(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(FileFormatError, match=name):
        read_trajectory(tmp_path / name)


def test_bytes_and_missing_files(tmp_path: Path) -> None:
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe\x80")
    for name in ("bytes.json", "nowhere.json", "."):
        with pytest.raises(FileFormatError, match="cannot be read"):
            read_trajectory(tmp_path / name)


def test_not_a_number_in_a_file(tmp_path: Path) -> None:
    (tmp_path / "t.json").write_text(
        '{"joint_names": ["a"], "points": [{"time_from_start": 0, "positions": [NaN]}, '
        '{"time_from_start": Infinity, "positions": [0]}]}'
    )
    with pytest.raises(FileFormatError, match=r"time_from_start: must be finite"):
        read_trajectory(tmp_path / "t.json")


@pytest.mark.parametrize("value", [float("nan"), float("inf"), np.float64("-inf")])
def test_json_has_no_such_number(tmp_path: Path, value: float) -> None:
    write_json(tmp_path / "t.json", {"a": 1})
    with pytest.raises(FileFormatError, match=r"t\.json: b\[1\]\.c: (nan|-?inf) is not a number"):
        write_json(tmp_path / "t.json", {"b": [0.0, {"c": value}]})
    assert json.loads((tmp_path / "t.json").read_text()) == {"a": 1}


def test_json_has_no_such_thing(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="a: JSON cannot hold a ndarray"):
        write_json(tmp_path / "t.json", {"a": np.zeros(3)})
    with pytest.raises(FileFormatError, match="a: the key 1 is not text"):
        write_json(tmp_path / "t.json", {"a": {1: 2}})
    assert not list(tmp_path.iterdir())


def test_folders_on_the_way_are_made(tmp_path: Path) -> None:
    write_json(tmp_path / "new" / "folder" / "t.json", {"a": 1})
    assert json.loads((tmp_path / "new" / "folder" / "t.json").read_text()) == {"a": 1}


def test_a_file_in_place_of_a_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    with pytest.raises(FileFormatError, match="cannot be written"):
        write_json(tmp_path / "taken" / "t.json", {"a": 1})


@given(value=st.floats(allow_nan=False, allow_infinity=False))
@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_numbers_are_written_exactly(value: float, tmp_path: Path) -> None:
    write_json(tmp_path / "t.json", {"a": value, "b": np.float64(value)})
    back = json.loads((tmp_path / "t.json").read_text())
    assert back["a"] == back["b"] == value
