"""Poses from files: read as written, and refused with the place that is wrong."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.tasks.cartesian import read_poses
from trajopt.values.errors import FileFormatError


def test_csv_with_and_without_orientations(tmp_path: Path) -> None:
    path = tmp_path / "letter.csv"
    path.write_text("x, y, z\n0.4, 0.0, 0.1\n0.4, 0.1, 0.1\n")
    poses = read_poses(path, rpy=(np.pi, 0.0, 0.0))
    assert [pose.translation.tolist() for pose in poses] == [[0.4, 0.0, 0.1], [0.4, 0.1, 0.1]]
    assert poses[0].rotation == pytest.approx(to.placement(rpy=(np.pi, 0, 0)).rotation)
    path.write_text("x,y,z,qx,qy,qz,qw\n0.4,0.0,0.1,0,0,0,1\n0.4,0.1,0.1,0,0,1,0\n")
    assert read_poses(path)[1].rotation == pytest.approx(np.diag((-1.0, -1.0, 1.0)))
    path.write_text("x,y,z,roll,pitch,yaw\n0.4,0.0,0.1,0,0,0.5\n0.4,0.1,0.1,0,0,1\n")
    assert read_poses(path)[0].rpy == pytest.approx((0.0, 0.0, 0.5))


def test_yaml(tmp_path: Path) -> None:
    path = tmp_path / "letter.yaml"
    path.write_text(
        "poses:\n- {position: [0.4, 0, 0.1], rpy: [0, 0, 1]}\n"
        "- {position: [0, 1, 0], quaternion: [0, 0, 1, 0]}\n"
    )
    first, second = read_poses(path)
    assert first.rpy == pytest.approx((0.0, 0.0, 1.0))
    assert second.rotation == pytest.approx(np.diag((-1.0, -1.0, 1.0)))


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("a.csv", "x,y\n1,2\n3,4\n", "needs x, y, z"),
        ("a.csv", "x,y,z\n1,2,3\n1,two,3\n", "line 3"),
        ("a.csv", "x,y,z\n1,2,3\n1,2\n", "line 3"),
        ("a.csv", "x,y,z\n1,2,3\n", "at least two"),
        ("a.csv", "x,y,z,qx,qy,qz,qw\n1,2,3,0,0,0,0\n1,2,4,0,0,0,1\n", "line 2"),
        ("a.yaml", "poses:\n- {position: [1, 2]}\n- {position: [1, 2, 3]}\n", "poses.0."),
        ("a.yaml", "poses:\n- {point: [1, 2, 3]}\n", "did you mean|known"),
        ("a.yaml", "waypoints: []\n", "poses"),
    ],
)
def test_errors_of_a_file_are_named(tmp_path: Path, name: str, text: str, says: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(FileFormatError, match=says):
        read_poses(path)


def test_a_missing_file() -> None:
    for name in ("nowhere.csv", "nowhere.yaml"):
        with pytest.raises(FileFormatError, match="nowhere"):
            read_poses(name)
