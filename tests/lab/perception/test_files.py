"""Calibrations as ROS and its calibrators write them."""

from pathlib import Path

import numpy as np
import pytest

from trajopt.lab.perception import Lens, read_camera_info, read_hand_eye
from trajopt.values.errors import FileFormatError

CALIBRATED = """
image_width: 640
image_height: 480
camera_name: rgb
camera_matrix:
  rows: 3
  cols: 3
  data: [525.1, 0, 318.5, 0, 526.2, 240.25, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.2624, -0.9531, -0.0054, 0.0026, 1.1633]
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]}
"""
PRINTED = """
header: {stamp: {sec: 1, nanosec: 2}, frame_id: camera_depth_optical_frame}
height: 480
width: 848
distortion_model: plumb_bob
d: [0.0, 0.0, 0.0, 0.0, 0.0]
k: [421.5, 0.0, 424.25, 0.0, 421.5, 238.0, 0.0, 0.0, 1.0]
binning_x: 0
roi: {x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false}
"""
ON_HAND = """
eye_on_hand: true
robot_base_frame: panda_link0
robot_effector_frame: panda_hand
tracking_base_frame: camera_color_optical_frame
transformation: {x: 0.05, y: -0.01, z: 0.04, qx: 0, qy: 0, qz: 0.7071067811865476, qw: 0.7071067811865476}
"""
BESIDE = """
parameters:
  name: my_calibration
  calibration_type: eye_on_base
  robot_base_frame: panda_link0
  robot_effector_frame: panda_hand
  tracking_base_frame: camera_link
transform:
  translation: {x: 1.0, y: 0.5, z: 0.8}
  rotation: {x: 0, y: 0, z: 0, w: 1}
"""
PLAIN = """
header: {frame_id: panda_hand}
child_frame_id: camera_link
transform:
  translation: {x: 0.1, y: 0.2, z: 0.3}
  rotation: {x: 1, y: 0, z: 0, w: 0}
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "file.yaml"
    path.write_text(text)
    return path


def test_the_calibrators_form(tmp_path: Path) -> None:
    read = read_camera_info(written(tmp_path, CALIBRATED))
    assert (read.width, read.height, read.fx, read.fy, read.cx, read.cy) == (
        640,
        480,
        525.1,
        526.2,
        318.5,
        240.25,
    )
    assert read.lens == Lens(k1=0.2624, k2=-0.9531, p1=-0.0054, p2=0.0026, k3=1.1633)


def test_the_messages_form_of_both_generations(tmp_path: Path) -> None:
    read = read_camera_info(written(tmp_path, PRINTED))
    assert (read.width, read.height, read.fx, read.cx) == (848, 480, 421.5, 424.25) and read.lens.straight
    older = PRINTED.replace("d: [", "D: [").replace("k: [", "K: [")
    again = read_camera_info(written(tmp_path, older))
    assert (again.fy, again.cy) == (421.5, 238.0)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("plumb_bob", "equidistant", r"distortion_model: is 'equidistant', which is not undone"),
        ("plumb_bob", "double_sphere", "'double_sphere'"),
        ("plumb_bob", "rational_polynomial", "needs 8 numbers for rational_polynomial, has 5"),
        ("525.1, 0, 318.5", "525.1, 0.3, 318.5", "is not a matrix"),
        ("525.1, 0, 318.5", "525.1, 0", r"data: needs the 9 numbers of a 3x3 matrix, has 8"),
        ("525.1", "-1", "fx must be positive"),
        ("image_width: 640", "image_width: 640.5", "whole number of pixels"),
        ("image_width: 640", "image_with: 640", "image_width"),
        ("image_width: 640", "image_width: 640\nbinning_x: 2", "binned"),
        ("image_width: 640", "image_width: 640\nroi: {x_offset: 8}", "cut off"),
    ],
)
def test_impossible_values_are_refused_with_their_place(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    with pytest.raises((FileFormatError, ValueError), match=said):
        read_camera_info(written(tmp_path, CALIBRATED.replace(old, new)))


def test_a_camera_on_the_hand(tmp_path: Path) -> None:
    mount = read_hand_eye(written(tmp_path, ON_HAND))
    assert (mount.frame, mount.camera) == ("panda_hand", "camera_color_optical_frame")
    assert np.allclose(mount.placement.translation, (0.05, -0.01, 0.04))
    assert np.allclose(mount.placement.rpy, (0, 0, np.pi / 2))


def test_a_camera_beside_the_robot(tmp_path: Path) -> None:
    mount = read_hand_eye(written(tmp_path, BESIDE))
    assert (mount.frame, mount.camera) == ("panda_link0", "camera_link")
    assert np.allclose(mount.placement.translation, (1.0, 0.5, 0.8))


def test_a_plain_transform(tmp_path: Path) -> None:
    mount = read_hand_eye(written(tmp_path, PLAIN))
    assert (mount.frame, mount.camera) == ("panda_hand", "camera_link")
    assert np.allclose(mount.placement.rotation, np.diag((1.0, -1.0, -1.0)))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (ON_HAND.replace("eye_on_hand: true", "eye_on_head: true"), "does not state where"),
        (BESIDE.replace("eye_on_base", "eye_on_ceiling"), "'eye_on_ceiling', must be one of"),
        (
            ON_HAND.replace("qw: 0.7071067811865476", "qw: 0").replace("qz: 0.7071067811865476", "qz: 0"),
            "no length",
        ),
        (ON_HAND.replace("x: 0.05", "x: far"), "must be a number"),
        (BESIDE.replace("z: 0.8", "zz: 0.8"), r"translation\.z: must be a number, is missing"),
    ],
)
def test_error_names_the_missing_or_invalid_field(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(FileFormatError, match=said):
        read_hand_eye(written(tmp_path, text))
