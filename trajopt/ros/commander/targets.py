"""Targets of a group, joint values or poses, and their conversion to constraints messages."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from itertools import zip_longest

import numpy as np

from trajopt.files.messages import (
    BoundingVolume,
    Constraints,
    Header,
    JointConstraint,
    OrientationConstraint,
    Pose,
    PositionConstraint,
    SolidPrimitive,
)
from trajopt.files.moveit.pose import pose_of
from trajopt.server.move_group.settings import Settings
from trajopt.values.placement import Placement


class TargetKind(Enum):
    """Constrained part of a pose."""

    POSE = "position and orientation"
    POSITION = "position"
    ORIENTATION = "orientation"


@dataclass(frozen=True)
class PoseTarget:
    """Target pose of a link.

    Attributes:
        part: Constrained part of the placement.
        placement: Placement of the link in `frame`.
        frame: The frame; a moving frame is taken at its start placement.
    """

    part: TargetKind
    placement: Placement
    frame: str


@dataclass(frozen=True, eq=False)
class Targets:
    """Targets of a group.

    Attributes:
        joints: Joint -> position [rad | m], of all joints of the group.
        poses: Alternative poses by link; `joints` applies if empty.
    """

    joints: Mapping[str, float]
    poses: Mapping[str, tuple[PoseTarget, ...]] = field(default_factory=dict[str, tuple[PoseTarget, ...]])


def goal_constraints(
    targets: Targets, settings: Settings, frame: str, placed: Callable[[PoseTarget], Placement]
) -> list[Constraints]:
    """Return alternative goal constraints for targets.

    If several links have several poses each, the i-th alternative contains the i-th pose of every link.

    Args:
        targets: The targets.
        settings: Their tolerances.
        frame: Name of the planning frame.
        placed: Returns the placement of a target in the planning frame.
    """
    if not targets.poses:
        return [_joint_goal(targets.joints, settings.joint_tolerance)]
    goals: list[Constraints] = []
    for together in zip_longest(*targets.poses.values()):
        goal = Constraints()
        for link, target in zip(targets.poses, together, strict=True):
            if target is not None:
                _demand(goal, link, target.part, placed(target), settings, frame)
        goals.append(goal)
    return goals


def _joint_goal(joints: Mapping[str, float], tolerance: float) -> Constraints:
    constraints = [JointConstraint(name, value, tolerance, tolerance, 1.0) for name, value in joints.items()]
    return Constraints(joint_constraints=constraints)


def _demand(
    goal: Constraints, link: str, part: TargetKind, where: Placement, settings: Settings, frame: str
) -> None:
    pose, header = pose_of(where), Header(frame_id=frame)
    if part is not TargetKind.ORIENTATION and np.isfinite(settings.position_tolerance).any():
        box = SolidPrimitive(
            SolidPrimitive.BOX, [2.0 * tolerance for tolerance in settings.position_tolerance]
        )
        region = BoundingVolume([box], [Pose(pose.position, pose.orientation)])
        goal.position_constraints.append(
            PositionConstraint(header, link, constraint_region=region, weight=1.0)
        )
    if part is not TargetKind.POSITION:
        goal.orientation_constraints.append(
            OrientationConstraint(header, pose.orientation, link, *settings.orientation_tolerance, weight=1.0)
        )
