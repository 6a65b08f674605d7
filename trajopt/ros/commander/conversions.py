"""Stand-in for `moveit_commander.conversions`: poses as lists, messages and placements."""

from collections.abc import Sequence
from typing import Any

from trajopt.files.messages import Header, Pose, PoseStamped, Time, document_of, is_message
from trajopt.files.moveit.frames import pose_of, read_placement
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.values.errors import shown
from trajopt.values.placement import Placement, placement


def pose_to_list(pose_msg: Pose) -> list[float]:
    """Return a pose as [x, y, z, qx, qy, qz, qw]."""
    at, how = pose_msg.position, pose_msg.orientation
    return [at.x, at.y, at.z, how.x, how.y, how.z, how.w]


def list_to_pose(pose_list: Sequence[float]) -> Pose:
    """Return the pose of [x, y, z, roll, pitch, yaw] or [x, y, z, qx, qy, qz, qw] [m, rad]."""
    return pose_of(placement_of(pose_list))


def list_to_pose_stamped(pose_list: Sequence[float], target_frame: str) -> PoseStamped:
    return stamped(placement_of(pose_list), target_frame)


def stamped(where: Placement, frame: str) -> PoseStamped:
    return PoseStamped(Header(stamp=Time.now(), frame_id=frame), pose_of(where))


def placement_of(pose: Any) -> Placement:
    """Return the placement of a pose, or of a list of six (with roll, pitch, yaw) or seven numbers."""
    if isinstance(pose, Placement):
        return pose
    if is_message(pose, "position", "orientation"):
        return read_placement(document_of(pose, "pose"), [])
    numbers: list[float] = [] if isinstance(pose, str) or not hasattr(pose, "__len__") else list(pose)
    if len(numbers) == 6:
        return placement(numbers[:3], rpy=numbers[3:])
    if len(numbers) == 7:
        return placement(numbers[:3], quaternion=numbers[3:])
    raise MoveItCommanderException(
        "a pose is a Pose, a PoseStamped, [x, y, z, roll, pitch, yaw] or [x, y, z, qx, qy, qz, qw], "
        f"not {shown(pose)}"
    )


def framed_placement(pose: Any, frame: str) -> tuple[Placement, str]:
    if is_message(pose, "header", "pose"):
        return placement_of(pose.pose), str(pose.header.frame_id).removeprefix("/") or frame
    return placement_of(pose), frame
