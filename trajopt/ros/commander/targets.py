"""What a group is sent to: joint values or poses, and the constraints messages that say so."""

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


class Part(Enum):
    """What of a pose is asked for."""

    POSE = "position and orientation"
    POSITION = "position"
    ORIENTATION = "orientation"


@dataclass(frozen=True)
class PoseTarget:
    """Where a link is sent to.

    Attributes:
        part: What of the placement counts.
        placement: Of the link in `frame`.
        frame: The frame; where it moves, it is meant where it is at the start.
    """

    part: Part
    placement: Placement
    frame: str


@dataclass(frozen=True, eq=False)
class Targets:
    """What a group is sent to.

    Attributes:
        joints: Joint -> position [rad | m], of all joints of the group.
        poses: Alternative poses by link; joints count where there are none.
    """

    joints: Mapping[str, float]
    poses: Mapping[str, tuple[PoseTarget, ...]] = field(default_factory=dict[str, tuple[PoseTarget, ...]])


def goal_constraints(
    targets: Targets, settings: Settings, frame: str, placed: Callable[[PoseTarget], Placement]
) -> list[Constraints]:
    """Return the goals that targets stand for, of which any one will do.

    Several links with several poses each are sent to their first poses together, or to their second, ...

    Args:
        targets: The targets.
        settings: Their tolerances.
        frame: Name of the planning frame.
        placed: Returns where a target is in the planning frame.
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
    goal: Constraints, link: str, part: Part, where: Placement, settings: Settings, frame: str
) -> None:
    pose, header = pose_of(where), Header(frame_id=frame)
    if part is not Part.ORIENTATION and np.isfinite(settings.position_tolerance).any():
        box = SolidPrimitive(
            SolidPrimitive.BOX, [2.0 * tolerance for tolerance in settings.position_tolerance]
        )
        region = BoundingVolume([box], [Pose(pose.position, pose.orientation)])
        goal.position_constraints.append(
            PositionConstraint(header, link, constraint_region=region, weight=1.0)
        )
    if part is not Part.POSITION:
        goal.orientation_constraints.append(
            OrientationConstraint(header, pose.orientation, link, *settings.orientation_tolerance, weight=1.0)
        )
