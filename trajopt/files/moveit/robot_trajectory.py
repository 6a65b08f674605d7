"""Robot trajectory messages, which MoveIt sends for execution."""

from pathlib import Path

from trajopt.files.moveit.joint_trajectory import (
    header,
    on_whole_nanoseconds,
    points_document,
    read_points,
    write_message,
)
from trajopt.files.moveit.planar_joints import joined, multi_dof_points, planar_joints, read_multi_dof, split
from trajopt.values.documents.document import Node
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory


@checked
def write_trajectory(trajectory: Trajectory, path: Path | str) -> None:
    """Write a trajectory as `moveit_msgs/RobotTrajectory`: JSON if the file name ends in .json, else YAML.

    Points are at whole nanoseconds (`on_whole_nanoseconds`); numbers are written exactly. A planar base
    (joints `NAME/x`, `NAME/y` and `NAME/theta`) is written as in MoveIt: as a joint of several degrees of
    freedom, by its transforms, which lose full turns.

    Raises:
        FileFormatError: If the file cannot be written.
        ShapeError: If two points are less than a nanosecond apart.
    """
    single, several = split(on_whole_nanoseconds(trajectory))
    nothing: dict[str, object] = {"joint_names": list[str](), "points": list[object]()}
    planar = (
        {}
        if several is None
        else {"joint_names": list(planar_joints(several.joint_names)), "points": multi_dof_points(several)}
    )
    document: dict[str, object] = {
        "joint_trajectory": {"header": header(), **(nothing if single is None else points_document(single))},
        "multi_dof_joint_trajectory": {"header": header(), **nothing, **planar},
    }
    write_message(path, document)


def read_joint_trajectory(document: Node) -> Trajectory:
    """Return the trajectory of a robot trajectory message.

    Planar joints become `NAME/x`, `NAME/y` and `NAME/theta`, before the others; see `read_multi_dof`.

    Raises:
        FileFormatError: If it is malformed, or a joint of several degrees of freedom leaves the plane.
    """
    document.only(("joint_trajectory", "multi_dof_joint_trajectory"))
    several = read_multi_dof(document["multi_dof_joint_trajectory"])
    single = document["joint_trajectory"]
    if several is not None and not single["points"].elements():
        return several
    return joined(document, read_points(single), several)
