"""Robot trajectory messages, what MoveIt sends to be executed."""

from pathlib import Path

import yaml

from trajopt.io.document import Node, read_document, write_text
from trajopt.model.trajectory import Trajectory
from trajopt.moveit.joint_trajectory import points_document, read_points

_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def write_trajectory(trajectory: Trajectory, path: Path | str) -> None:
    """Write a trajectory as `moveit_msgs/RobotTrajectory` in YAML.

    Numbers are written exactly, times to the nanosecond.

    Raises:
        FileFormatError: If the file cannot be written.
        ShapeError: If two points are less than a nanosecond apart.
    """
    document: dict[str, object] = {
        "joint_trajectory": {"header": _header(), **points_document(trajectory)},
        "multi_dof_joint_trajectory": {
            "header": _header(),
            "joint_names": list[str](),
            "points": list[object](),
        },
    }
    text = yaml.dump_all([document], Dumper=_DUMPER, sort_keys=False, default_flow_style=None, width=110)
    write_text(path, text)


def _header() -> dict[str, object]:
    return {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}


def read_trajectory(path: Path | str) -> Trajectory:
    """Read a `moveit_msgs/RobotTrajectory` from YAML or JSON.

    Raises:
        FileFormatError: If the file does not say what it must.
    """
    return read_joint_trajectory(read_document(path))


def read_joint_trajectory(document: Node) -> Trajectory:
    """Return the trajectory of a robot trajectory message.

    Raises:
        FileFormatError: If it is malformed, or moves joints of several degrees of freedom.
    """
    document.only(("joint_trajectory", "multi_dof_joint_trajectory"))
    if document["multi_dof_joint_trajectory"]["points"].elements():
        raise document["multi_dof_joint_trajectory"].error("such joints are not supported")
    return read_points(document["joint_trajectory"])
