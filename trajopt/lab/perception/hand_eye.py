"""Mounting of a camera, from the files of hand-eye calibration."""

from dataclasses import dataclass
from pathlib import Path

from trajopt.values.arrays import Value
from trajopt.values.arrays import path as path_of
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import ShapeError
from trajopt.values.placement import Placement, placement

ON_HAND = ("eye_in_hand", "eye_on_hand")
BESIDE = ("eye_to_hand", "eye_on_base")


@dataclass(frozen=True, eq=False)
class Mount(Value):
    """Mounting of a camera.

    Attributes:
        frame: The link of the robot that it is fixed on: of the hand, or of the base.
        camera: The calibrated frame of the camera. A depth camera looks along z of its optical frame,
            which differs from that of its housing.
        placement: Of the camera's frame in the link's.
    """

    frame: str
    camera: str
    placement: Placement


def read_hand_eye(path: Path | str) -> Mount:
    """Read the mounting of a camera on a robot, or beside it.

    Three forms are supported: those of easy_handeye (`eye_on_hand`, `robot_effector_frame`, `transformation`)
    and easy_handeye2 (`parameters`, `transform`), and a plain transform as ROS prints it (`header.frame_id`,
    `child_frame_id`, `transform`), which MoveIt's calibration publishes.

    Args:
        path: A YAML or JSON file.

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
            "says nothing of where the camera is fixed: eye_on_hand or calibration_type is missing"
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
