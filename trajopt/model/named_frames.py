"""What a name means in pinocchio's model: URDF lets a link and a joint have the same one.

A frame that is named is a link; a joint is meant only where a joint is asked for.
"""

import pinocchio as pin

_JOINTS = (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT)
_NO_NAME = "\x01"  # XML holds no such character, so no name does


def link_names(model: pin.Model) -> tuple[str, ...]:
    """Return the names of all links, root first."""
    return tuple(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY)


def joint_frame_names(model: pin.Model) -> tuple[str, ...]:
    """Return the names of all joints, those that cannot move included, in the tree's order."""
    return tuple(frame.name for frame in list(model.frames)[1:] if frame.type in _JOINTS)


def link_frame(model: pin.Model, link: str) -> int:
    """Return the place of a link among the model's frames."""
    return int(model.getFrameId(link, pin.FrameType.BODY))


def joint_above(model: pin.Model, link: str) -> str:
    """Return the name of the joint that a link hangs on ("universe" for the root)."""
    return str(model.frames[model.frames[link_frame(model, link)].parentFrame].name)


def distinct_links(model: pin.Model) -> pin.Model:
    """Return the model, or a copy whose links have names that no joint has where some do."""
    names = [frame.name for frame in model.frames]
    if len(set(names)) == len(names):
        return model
    renamed = model.copy()
    for frame in renamed.frames:
        if frame.type == pin.FrameType.BODY:
            frame.name = _NO_NAME + frame.name
    return renamed


def named_again(model: pin.Model) -> pin.Model:
    """Give links the names back that `distinct_links` took; return the model."""
    for frame in model.frames:
        frame.name = frame.name.removeprefix(_NO_NAME)
    return model
