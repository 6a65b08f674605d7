"""What pinocchio's model says of a robot beside its kinematics: limits, and which links adjoin."""

import numpy as np
import pinocchio as pin

from trajopt.model.limits import JointLimits


def described_limits(model: pin.Model) -> JointLimits:
    """Read what the URDF states: position, velocity, effort; acceleration is nan, jerk inf."""
    count = model.njoints - 1
    lower, upper = np.full(count, -np.inf), np.full(count, np.inf)
    for place, joint in enumerate(list(model.joints)[1:]):
        if joint.nq == 1:
            lower[place] = model.lowerPositionLimit[joint.idx_q]
            upper[place] = model.upperPositionLimit[joint.idx_q]
    effort = np.array(model.effortLimit)
    effort[effort <= 0.0] = np.inf
    return JointLimits(
        tuple(model.names[1:]),
        lower,
        upper,
        np.array(model.velocityLimit),
        np.full(count, np.nan),
        np.full(count, np.inf),
        effort,
    )


def adjacent_links(model: pin.Model, links: tuple[str, ...]) -> frozenset[frozenset[str]]:
    """Pair the links joined by one joint, or fixed to each other: contact there is construction."""
    by_joint: dict[int, list[str]] = {}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            by_joint.setdefault(int(frame.parentJoint), []).append(frame.name)
    parent_link = {
        frame.name: model.frames[frame.parentFrame].name
        for frame in model.frames
        if frame.type in (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT)
    }
    pairs: set[frozenset[str]] = set()
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            joint_frame = model.frames[frame.parentFrame].name
            parent = parent_link.get(joint_frame)
            if parent in links:
                pairs.add(frozenset((frame.name, parent)))
    for names in by_joint.values():
        pairs.update(frozenset((a, b)) for a in names for b in names if a < b)
    return frozenset(pairs)
