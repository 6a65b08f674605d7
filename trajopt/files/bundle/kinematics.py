"""Pinocchio's robot model as plain data: joints, inertias and frames, in model order.

Pinocchio's own archives are not used, because they load unchecked memory from untrusted files.
"""

from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np
import pinocchio as pin

from trajopt.values.arrays import Floats, floats
from trajopt.values.documents.document import Node
from trajopt.values.placement import as_placement

MOST_JOINTS = 1_000
"""Largest number of joints: ten times a humanoid with hands. Memory grows with the square of a chain's
length.
"""
_JOINTS: Mapping[str, Callable[[], Any]] = {
    kind().shortname(): kind
    for kind in (
        *(pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ),
        *(pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ),
        *(pin.JointModelRUBX, pin.JointModelRUBY, pin.JointModelRUBZ),
    )
}
_CONTINUOUS = """<robot name="one"><link name="a"/><link name="b"/>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0.1 0.7 0.4"/>
<limit effort="1" velocity="1"/></joint></robot>"""
_OF_POSITIONS = ("lowerPositionLimit", "upperPositionLimit")
_OF_RATES = (
    *("velocityLimit", "effortLimit", "friction", "damping"),
    *("armature", "rotorInertia", "rotorGearRatio"),
)
_FRAMES = {
    str(kind): kind
    for kind in (
        *(pin.FrameType.OP_FRAME, pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT),
        *(pin.FrameType.BODY, pin.FrameType.SENSOR),
    )
}


def _continuous(axis: Floats) -> Any:
    """Return a joint without limits about an axis, exact to the last digit.

    Its constructor takes no axis, and the URDF reader normalises with rounding errors. So the exact axis
    overwrites the axis of a joint read from URDF.
    """
    model = pin.buildModelFromXML(_CONTINUOUS)
    read = _axis(model.joints[1])
    model.loadFromString(model.saveToString().replace(_digits(read), _digits(axis)))
    return model.joints[1]


def _digits(axis: Floats) -> str:
    return " ".join(format(float(part), ".17e") for part in axis)


def _revolute(axis: Floats) -> Any:
    joint: Any = pin.JointModelRevoluteUnaligned(1.0, 0.0, 0.0)
    joint.axis = axis  # the constructor would normalise it again
    return joint


def _prismatic(axis: Floats) -> Any:
    joint: Any = pin.JointModelPrismaticUnaligned(1.0, 0.0, 0.0)
    joint.axis = axis
    return joint


_UNALIGNED: Mapping[str, Callable[[Floats], Any]] = {
    pin.JointModelRevoluteUnaligned().shortname(): _revolute,
    pin.JointModelPrismaticUnaligned().shortname(): _prismatic,
    pin.JointModelRevoluteUnboundedUnaligned().shortname(): _continuous,
}


def kinematics_document(model: pin.Model) -> dict[str, object]:
    """Return a model as plain data with arrays."""
    joints = [_joint(model, place) for place in range(1, model.njoints)]
    frames = [_frame(frame) for frame in model.frames]
    names = (*_OF_POSITIONS, *_OF_RATES)
    return {
        "name": str(model.name),
        "bodies": int(model.nbodies),
        "gravity": np.array(model.gravity.vector),
        "base_inertia": _inertia(model.inertias[0]),
        "joints": joints,
        "frames": frames,
        **{name: np.array(getattr(model, name)) for name in names},
    }


def _joint(model: pin.Model, place: int) -> dict[str, object]:
    joint = model.joints[place]
    kind = str(joint.shortname())
    if kind not in _JOINTS and kind not in _UNALIGNED:
        raise KeyError(kind)
    axis = {} if kind in _JOINTS else {"axis": _axis(joint)}
    return {
        "name": str(model.names[place]),
        "kind": kind,
        **axis,
        "parent": int(model.parents[place]),
        "placement": model.jointPlacements[place].np.copy(),
        "inertia": _inertia(model.inertias[place]),
    }


def _axis(joint: Any) -> Floats:
    """Return the axis along which, or about which, a joint moves, shape (3,)."""
    data = joint.createData()
    joint.calc(data, np.array([1.0, 0.0][: joint.nq]))
    subspace = np.array(data.S).ravel()
    return subspace[3:] if subspace[3:].any() else subspace[:3]


def _frame(frame: Any) -> dict[str, object]:
    return {
        "name": str(frame.name),
        "kind": str(frame.type),
        "joint": int(frame.parentJoint),
        "parent": int(frame.parentFrame),
        "placement": frame.placement.np.copy(),
        "inertia": _inertia(frame.inertia),
    }


def _inertia(inertia: Any) -> Floats:
    """Return mass, lever and rotational inertia about the centre of mass, shape (13,)."""
    return np.concatenate(([inertia.mass], inertia.lever, inertia.inertia.ravel()))


def model_from(node: Node) -> pin.Model:
    """Build a model from its document.

    Args:
        node: The output of `kinematics_document`, with its arrays read.
    """
    model = pin.Model()
    model.name = node["name"].text()
    model.gravity = pin.Motion(_array(node["gravity"], (6,)))
    joints = node["joints"].elements()
    for joint in joints:
        parent = _index(joint["parent"], model.njoints)
        model.addJoint(parent, _kind(joint), _placement(joint["placement"]), joint["name"].text())
    frames = node["frames"].elements()
    for _ in range(1, _index(node["bodies"], len(frames) + 2)):
        model.appendBodyToJoint(0, pin.Inertia.Zero(), pin.SE3.Identity())
    inertias = [node["base_inertia"], *(joint["inertia"] for joint in joints)]
    for place, inertia in enumerate(inertias):
        model.inertias[place] = _inertia_of(inertia)
    for place, frame in enumerate(frames):
        _add_frame(model, frame, place)
    for name in (*_OF_POSITIONS, *_OF_RATES):
        size = model.nq if name in _OF_POSITIONS else model.nv
        setattr(model, name, _array(node[name], (size,), infinite=True))
    return model


def _add_frame(model: pin.Model, node: Node, place: int) -> None:
    joint, kind = _index(node["joint"], model.njoints), _FRAMES.get(node["kind"].text())
    if kind is None:
        raise node["kind"].error("is not a kind of frame")
    parent = _index(node["parent"], max(place, 1))
    at, inertia = _placement(node["placement"]), _inertia_of(node["inertia"])
    if place == 0:  # the world, in every model
        return
    before = model.nframes
    model.addFrame(pin.Frame(node["name"].text(), joint, parent, at, kind, inertia), False)
    if model.nframes == before:
        raise node["name"].error("is the name of two frames")


def _kind(joint: Node) -> Any:
    kind = joint["kind"].text()
    if kind in _JOINTS:
        return _JOINTS[kind]()
    if kind not in _UNALIGNED:
        raise joint["kind"].error("is not a kind of joint")
    axis = _array(joint["axis"], (3,))
    if abs(float(np.linalg.norm(axis)) - 1.0) > 1e-6:
        raise joint["axis"].error("is not of length one")
    return _UNALIGNED[kind](axis)


def _placement(node: Node) -> pin.SE3:
    at = as_placement(node.place, _array(node, (4, 4)))
    return pin.SE3(np.array(at.rotation), np.array(at.translation))


def _inertia_of(node: Node) -> pin.Inertia:
    numbers = _array(node, (13,))
    if numbers[0] < 0.0:
        raise node.error("has a negative mass")
    return pin.Inertia(float(numbers[0]), numbers[1:4], numbers[4:].reshape(3, 3))


def _index(node: Node, count: int) -> int:
    if not isinstance(node.value, int) or isinstance(node.value, bool) or not 0 <= node.value < count:
        raise node.error(f"must be a number from 0 to {count - 1}")
    return node.value


def _array(node: Node, shape: tuple[int, ...], *, infinite: bool = False) -> Floats:
    value = cast("Any", node.value)
    if not isinstance(value, np.ndarray) or cast("Floats", value).shape != shape:
        raise node.error(f"must be an array of shape {shape}")
    numbers = np.array(value, dtype=np.float64)
    return numbers if infinite else np.array(floats(node.place, numbers, shape))
