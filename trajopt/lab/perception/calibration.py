"""A camera's `camera_info` and hand-eye calibration, from files."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from trajopt.scene.camera import STRAIGHT, Intrinsics, Lens
from trajopt.values.arrays import Value
from trajopt.values.arrays import path as path_of
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import ShapeError
from trajopt.values.placement import Placement, placement

MODELS: Mapping[str, tuple[int, ...]] = {
    "plumb_bob": (4, 5),
    "rational_polynomial": (8,),
    "none": (0,),
    "": (0,),
}
"""Number of coefficients of each supported distortion model."""
OTHERS = ("equidistant", "fisheye", "thin_prism_fisheye")
"""Unsupported distortion models with other projections."""


def read_camera_info(path: Path | str) -> Intrinsics:
    """Read the intrinsics of a camera from YAML or JSON.

    Both forms are supported: the calibrator's (`image_width`, `camera_matrix`, `distortion_coefficients`) and
    the message as ROS 1 or 2 prints it (`width`, `K` or `k`, `D` or `d`). The lens describes the raw image:
    for rectified images, remove its coefficients from the file.

    Raises:
        FileFormatError: If it is missing or malformed; if the distortion model is not supported; or if pixels
            are binned, cropped or skewed.
    """
    document = read_document(path_of("path", path))
    if document.has("camera_matrix"):
        size = document["image_width"], document["image_height"]
        matrix, numbers = document["camera_matrix"]["data"], document["distortion_coefficients"]["data"]
    else:
        size = document["width"], document["height"]
        matrix, numbers = _either(document, "K", "k"), _either(document, "D", "d")
    _refuse_parts(document)
    k = matrix.numbers()
    if len(k) != 9:
        raise matrix.error(f"needs the 9 numbers of a 3x3 matrix, has {len(k)}")
    if k[1] or k[3] or k[6] or k[7] or k[8] != 1.0:
        raise matrix.error(f"is not a matrix (fx, 0, cx; 0, fy, cy; 0, 0, 1): {list(k)}")
    try:
        return Intrinsics(_whole(size[0]), _whole(size[1]), k[0], k[4], k[2], k[5], _lens(document, numbers))
    except ShapeError as error:
        raise document.error(str(error)) from error


def _lens(document: Node, numbers: Node) -> Lens:
    model, given = document["distortion_model"], numbers.numbers()
    name = model.text("plumb_bob" if given else "none")
    if not any(given) and name not in OTHERS:
        return STRAIGHT
    if name not in MODELS:
        known = ", ".join(each for each in MODELS if each)
        raise model.error(f"is {name!r}, which is not undone; rectify the images, or use one of {known}")
    if len(given) not in MODELS[name]:
        wanted = " or ".join(map(str, MODELS[name]))
        raise numbers.error(f"needs {wanted} numbers for {name}, has {len(given)}")
    return Lens(*given)


def _refuse_parts(document: Node) -> None:
    for key in ("binning_x", "binning_y"):
        if document[key].number(0.0) not in (0.0, 1.0):
            raise document[key].error("pixels are binned: give the calibration of the binned pictures")
    region = document["roi"]
    for key in ("x_offset", "y_offset", "height", "width"):
        if region[key].number(0.0):
            raise region[key].error("pictures are cut off: give the calibration of the pictures as they are")


def _either(document: Node, first: str, second: str) -> Node:
    return document[first] if document.has(first) else document[second]


def _whole(size: Node) -> int:
    value = size.number()
    if value != int(value) or value < 1:
        raise size.error(f"must be a whole number of pixels, is {value:g}")
    return int(value)


ON_HAND = ("eye_in_hand", "eye_on_hand")
BESIDE = ("eye_to_hand", "eye_on_base")


@dataclass(frozen=True, eq=False)
class Mount(Value):
    """Mounting of a camera.

    Attributes:
        camera: The calibrated frame of the camera. A depth camera looks along z of its optical frame,
            which differs from its housing's.
        placement: Of the camera's frame in the link's.
    """

    frame: str
    camera: str
    placement: Placement


def read_hand_eye(path: Path | str) -> Mount:
    """Read the mounting of a camera, on the robot or in its cell, from YAML or JSON.

    It reads the files of easy_handeye (`eye_on_hand`, `robot_effector_frame`, `transformation`)
    and easy_handeye2 (`parameters`, `transform`), and a plain transform as ROS prints it (`header.frame_id`,
    `child_frame_id`, `transform`), which MoveIt's calibration publishes.

    Raises:
        FileFormatError: If it is missing or malformed, or has no mounting.
    """
    document = read_document(path_of("path", path))
    if document.has("child_frame_id"):
        frame, camera = document["header"]["frame_id"].text(), document["child_frame_id"].text()
        return Mount(frame, camera, _transform(document["transform"]))
    told = document["parameters"] if document.has("parameters") else document
    camera = told["tracking_base_frame"].text()
    link = "robot_effector_frame" if _on_hand(told) else "robot_base_frame"
    if document.has("transform"):
        return Mount(told[link].text(), camera, _transform(document["transform"]))
    return Mount(told[link].text(), camera, _flat(document["transformation"]))


def _on_hand(told: Node) -> bool:
    if told.has("calibration_type"):
        kind = told["calibration_type"].text()
        if kind not in (*ON_HAND, *BESIDE):
            known = ", ".join((*ON_HAND, *BESIDE))
            raise told["calibration_type"].error(f"is {kind!r}, must be one of {known}")
        return kind in ON_HAND
    if told["eye_on_hand"].missing:
        raise told.error(
            "does not state where the camera is mounted: eye_on_hand or calibration_type is missing"
        )
    return told["eye_on_hand"].flag()


def _flat(node: Node) -> Placement:
    return _placed(node, [node[key].number() for key in "xyz"], [node[f"q{key}"].number() for key in "xyzw"])


def _transform(node: Node) -> Placement:
    shift, turn = node["translation"], node["rotation"]
    return _placed(node, [shift[key].number() for key in "xyz"], [turn[key].number() for key in "xyzw"])


def _placed(node: Node, shift: list[float], turn: list[float]) -> Placement:
    try:
        return placement(shift, quaternion=turn)
    except ShapeError as error:
        raise node.error(str(error)) from error
