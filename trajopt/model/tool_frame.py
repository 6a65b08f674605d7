"""The frame by which a motion is told: the tool of a group."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel


def tool_frame(reduced: ReducedModel) -> str:
    """Return the name of the frame that shows what the group does.

    Tip link and hand move as one, so this is a tool frame fixed to the same joint, if the robot has
    one; else the link there whose origin is farthest from the joint. A group without a tip link
    counts as ending with what its last joint moves.
    """
    robot = reduced.scene.robot
    tip = robot.group(reduced.group).tip
    last = reduced.model.getJointId(reduced.joint_names[-1])
    carrier = last if tip is None else reduced.attachment(tip)[0]
    for name in robot.frames:
        if reduced.attachment(name)[0] == carrier:
            return name
    reach: dict[str, float] = {}
    for name in (*((tip,) if tip is not None else ()), *robot.links):
        joint, where = reduced.attachment(name)
        if joint == carrier:
            # Of equals the first stays: the tip link.
            reach.setdefault(name, round(float(np.linalg.norm(where.translation)), 9))
    return max(reach, key=lambda name: reach[name])


def tool_point(reduced: ReducedModel, frame: str, positions: Floats) -> Floats:
    """Return where a frame is for the group's positions (n,), shape (3,) in the world [m]."""
    return reduced.scene.placement_of(frame, reduced.all_positions(positions)).translation
