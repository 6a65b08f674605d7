"""Access to Pinocchio's model: names, limits, adjacent links, and plain data for pickles."""

from collections.abc import Collection, Mapping
from typing import cast

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import JointLimits, configuration
from trajopt.values.arrays import Floats, readonly
from trajopt.values.placement import Placement

_JOINTS = (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT)
_NO_NAME = "\x01"  # XML holds no such character, so no name does


def link_names(model: pin.Model) -> tuple[str, ...]:
    return tuple(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY)


def joint_frame_names(model: pin.Model) -> tuple[str, ...]:
    """Return the names of all joints, fixed ones included, in the tree's order."""
    return tuple(frame.name for frame in list(model.frames)[1:] if frame.type in _JOINTS)


def fixed_joint_names(model: pin.Model) -> frozenset[str]:
    return frozenset(joint_frame_names(model)) - frozenset(model.names[1:])


def link_frame(model: pin.Model, link: str) -> int:
    """Return the frame index of a link."""
    return int(model.getFrameId(link, pin.FrameType.BODY))


def joint_above(model: pin.Model, link: str) -> str:
    """Return the name of a link's parent joint ("universe" for the root)."""
    return str(model.frames[model.frames[link_frame(model, link)].parentFrame].name)


def link_joint(model: pin.Model, link: str) -> int:
    """Return the index of the joint that moves a link; 0 without one."""
    return int(model.frames[link_frame(model, link)].parentJoint)


def link_above(model: pin.Model, link: str) -> str:
    """Return the name of a link's parent link; the joint between them may be fixed."""
    joint = model.frames[model.frames[link_frame(model, link)].parentFrame]
    return str(model.frames[joint.parentFrame].name)


def distinct_links(model: pin.Model) -> pin.Model:
    """Return the model, or a copy in which no link has the name of a joint."""
    names = [frame.name for frame in model.frames]
    if len(set(names)) == len(names):
        return model
    renamed = model.copy()
    for frame in renamed.frames:
        if frame.type == pin.FrameType.BODY:
            frame.name = _NO_NAME + frame.name
    return renamed


def named_again(model: pin.Model) -> pin.Model:
    """Undo `distinct_links`; return the model."""
    for frame in model.frames:
        frame.name = frame.name.removeprefix(_NO_NAME)
    return model


def described_limits(model: pin.Model) -> JointLimits:
    """Read the limits of the URDF: position, velocity, effort; acceleration is NaN, jerk inf."""
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


def links_of_the_world(model: pin.Model, shaped: Collection[str]) -> frozenset[str]:
    """Return the links that belong to the world: tables and floors of the robot's description.

    They carry no joint, and no link with a shape is between them and the root, which has none itself.

    Args:
        shaped: The links with a shape.
    """
    frames, carriers = model.frames, set[int]()
    for frame in frames:
        if frame.type == pin.FrameType.JOINT:
            carriers.update(_links_above(model, int(frame.parentFrame)))
    found: set[str] = set()
    for place, frame in enumerate(frames):
        if frame.type == pin.FrameType.BODY and frame.parentJoint == 0 and place not in carriers:
            above = _links_above(model, int(frame.parentFrame))
            if above and not any(frames[each].name in shaped for each in above):
                found.add(str(frame.name))
    return frozenset(found)


def _links_above(model: pin.Model, place: int) -> list[int]:
    """Return the frame indices of the links from a frame to the root, itself included if it is a link."""
    found: list[int] = []
    while place > 0:
        if model.frames[place].type == pin.FrameType.BODY:
            found.append(place)
        place = int(model.frames[place].parentFrame)
    return found


def adjacent_links(model: pin.Model, links: tuple[str, ...]) -> frozenset[frozenset[str]]:
    """Return pairs of links joined by one joint or fixed to each other, which touch by construction."""
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


ModelData = tuple[str, Mapping[str, Floats]]
"""The text of Pinocchio's archive, and the vectors with infinities, which it cannot read back."""


def model_data(model: pin.Model) -> ModelData:
    """Return a model as plain data."""
    finite, infinite = model.copy(), dict[str, Floats]()
    for name in dir(model):
        value: object = getattr(model, name)
        if isinstance(value, np.ndarray):
            vector = cast("Floats", value)
            if not np.isfinite(vector).all():
                infinite[name] = vector.copy()
                setattr(finite, name, np.zeros_like(vector))
    return finite.saveToString(), infinite


def model_of(data: ModelData) -> pin.Model:
    """Restore a model from its data."""
    text, infinite = data
    model = pin.Model()
    model.loadFromString(text)
    for name, vector in infinite.items():
        setattr(model, name, vector)
    return model


def root_placement(model: pin.Model) -> Placement:
    """Return the placement of the root link in the world."""
    at = model.frames[link_frame(model, link_names(model)[0])].placement
    return Placement(readonly(at.rotation.copy()), readonly(at.translation.copy()))


def placed_model(model: pin.Model, where: Placement) -> pin.Model:
    """Return a copy of a model that is displaced as a whole.

    Args:
        where: The displacement, in the world.
    """
    moved, change = model.copy(), pin.SE3(where.rotation, where.translation)
    for joint in range(1, moved.njoints):
        if moved.parents[joint] == 0:
            moved.jointPlacements[joint] = change * moved.jointPlacements[joint]
    for frame in list(moved.frames)[1:]:
        if frame.parentJoint == 0:
            frame.placement = change * frame.placement
    return moved


def link_placement(model: pin.Model, link: str, positions: Floats) -> Placement:
    """Return the placement of a link in the world.

    Args:
        model: The robot's model.
        link: Name of one of its links.
        positions: Of all joints, shape (number of joints,) [rad | m].
    """
    data = model.createData()
    frame = link_frame(model, link)
    pin.framesForwardKinematics(model, data, configuration(model, positions))
    found = data.oMf[frame]
    return Placement(readonly(found.rotation.copy()), readonly(found.translation.copy()))
