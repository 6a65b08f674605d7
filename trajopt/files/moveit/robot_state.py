"""Robot state messages: joint positions."""

from collections.abc import Mapping
from difflib import get_close_matches

from trajopt.files.moveit.frames import require
from trajopt.files.moveit.robot_base import base_positions
from trajopt.robot.robot import Robot
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import JointNotFound, listed, shown

ROBOT_STATE_FIELDS = (
    "joint_state",
    "multi_dof_joint_state",
    "attached_collision_objects",
    "is_diff",
)
FIXED_JOINT_TOLERANCE = 1e-6
"""A fixed joint may be listed with a position this close to zero [rad | m]."""


def read_joint_positions(node: Node, robot: Robot, notes: list[str]) -> Mapping[str, float]:
    """Return the joint positions in a robot state, by joint [rad | m].

    Drivers publish joints that the description fixes or does not have, such as wheels and fingers; these are
    skipped and noted. The positions of a planar base come from its transform; see `base_positions`.

    Args:
        node: The robot state message.
        robot: The robot.
        notes: Receives a sentence on the skipped joints, and for every quaternion not of unit length.

    Raises:
        FileFormatError: If names and positions are inconsistent, or a fixed base is not at its fixed pose.
    """
    stated, place = _stated(node), node["joint_state"].place
    unknown = [joint for joint in stated if joint not in (*robot.joint_names, *robot.fixed_joints)]
    if unknown:
        free = [joint for joint in robot.joint_names if joint not in stated]
        named = listed([joint + _near(joint, free) for joint in unknown])
        notes.append(f"{place}: left out, being no joints of {robot.name}: {named}")
    fixed = [f"{joint} (at {at:g})" for joint, (at, *_) in stated.items() if _moved(robot, joint, at)]
    if fixed:
        notes.append(f"{place}: left out, being fixed in {robot.name}: {listed(fixed)}")
    base = base_positions(node["multi_dof_joint_state"], robot, notes)
    return {**{joint: at for joint, (at, *_) in stated.items() if joint in robot.joint_names}, **base}


def checked_joint_positions(node: Node, robot: Robot) -> Mapping[str, float]:
    """Return the joint positions in a robot state that may name only joints of the robot.

    Args:
        node: The robot state message.
        robot: The robot.

    Raises:
        JointNotFound: If the robot has no such joint.
        FileFormatError: If names and positions are inconsistent, a fixed joint is moved, or a fixed base is
            not at its fixed pose.
    """
    for joint, (at, name, value) in _stated(node).items():
        if _moved(robot, joint, at):
            raise value.error(f"joint {shown(joint)} is fixed and cannot be at {at:g}")
        if joint not in robot.fixed_joints:
            require(name, JointNotFound, "joint", joint, robot.joint_names)
    return read_joint_positions(node, robot, [])


def _stated(node: Node) -> Mapping[str, tuple[float, Node, Node]]:
    """Return the listed joints: by joint, its position, and the nodes of name and position."""
    state = node.only(ROBOT_STATE_FIELDS)["joint_state"]
    state.only(("header", "name", "position", "velocity", "effort"))
    names, values = state["name"].elements(), state["position"].elements()
    if len(names) != len(values):
        raise state.error(f"{len(names)} names, but {len(values)} positions")
    stated: dict[str, tuple[float, Node, Node]] = {}
    for name, value in zip(names, values, strict=True):
        joint, position = name.text(), value.number()
        if stated.setdefault(joint, (position, name, value))[0] != position:
            raise name.error(f"joint {shown(joint)} is listed twice, at different positions")
    return stated


def _moved(robot: Robot, joint: str, position: float) -> bool:
    return joint in robot.fixed_joints and abs(position) > FIXED_JOINT_TOLERANCE


def _near(joint: str, free: list[str]) -> str:
    """Return a hint if an unknown name resembles a joint that the message leaves out."""
    near = get_close_matches(joint, free, n=1)
    return f" (did you mean {shown(near[0])}?)" if near else ""


def layered_positions(robot: Robot, *layers: Mapping[str, float]) -> Floats:
    """Return positions of all joints; later layers override earlier ones.

    If a later layer moves the source of a mimic joint, the joint follows its source, unless that layer or a
    later one names the joint itself.

    Args:
        robot: The robot.
        layers: Joint -> position [rad | m]; joints in no layer have their default.

    Returns:
        Positions, shape (number of joints,) [rad | m].
    """
    named: dict[str, float] = {}
    for layer in layers:
        for joint, mimic in robot.mimics.items():
            if mimic.source in layer:
                named.pop(joint, None)
        named.update(layer)
    return robot.positions(named)
