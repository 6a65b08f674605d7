"""Robot state messages: positions of joints, and of the robot's base."""

from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches

from trajopt.files.messages import JointState, MultiDOFJointState, RobotState, field_names
from trajopt.files.moveit.frames import frame_id, read_placement, read_vector, require
from trajopt.files.moveit.trajectories import in_the_plane
from trajopt.problem.requirements import Requirement, joint_positions
from trajopt.robot.bases import PLANAR
from trajopt.robot.loading.pinocchio_model import placed_model, root_placement
from trajopt.robot.robot import Robot
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import JointNotFound, listed, shown
from trajopt.values.placement import IDENTITY, Placement

NOT_DISPLACED = 1e-6
"""Largest deviation of a listed fixed joint from its fixed pose [m | rad]."""
FIXED_JOINT_TOLERANCE = 1e-6
"""A fixed joint may be listed with a position this close to zero [rad | m]."""


def base_positions(node: Node, robot: Robot, notes: list[str]) -> Mapping[str, float]:
    """Return the positions of a planar base, by joint [rad | m]; empty for other bases.

    Args:
        node: The joints of several degrees of freedom of a robot state.
        notes: Receives a sentence for every quaternion not of unit length.
    """
    positions: dict[str, float] = {}
    for joint, transform in _transforms(node, robot):
        if joint == robot.base.name and len(robot.base.joints) == len(PLANAR):
            found = in_the_plane(transform, notes)
            positions |= dict(zip(robot.base.joints, found, strict=True))
            continue
        stands = (
            root_placement(robot.model) if joint == robot.base.name and not robot.base.joints else IDENTITY
        )
        if not _same(read_placement(transform, notes), stands):
            raise transform.error(
                f"{joint or 'the base'} of {robot.name} cannot stand elsewhere than at {stands}"
            )
    return positions


def placed_robot(node: Node, robot: Robot, notes: list[str]) -> Robot:
    """Return the robot with its fixed base at the pose of a robot state, and note a change.

    Args:
        node: The joints of several degrees of freedom of the robot state.
    """
    if robot.base.joints:
        return robot
    for joint, transform in _transforms(node, robot):
        where, now = read_placement(transform, []), root_placement(robot.model)
        if joint == robot.base.name and not _same(where, now):
            notes.append(f"{transform.place}: {robot.name}, whose base does not move, stands at {where}")
            return replace(robot, model=placed_model(robot.model, where * now.inverse()))
    return robot


def read_workspace(
    node: Node, robot: Robot, group: str, world_names: frozenset[str], notes: list[str]
) -> tuple[Requirement, ...]:
    """Return the requirement of a workspace: a planar base stays inside; arms are not restricted.

    A box of zero size or in another frame is ignored.
    """
    moved = robot.base.joints[:2] if len(robot.base.joints) == len(PLANAR) else ()
    corners = [read_vector(node[key]) for key in ("min_corner", "max_corner")]
    if (
        not moved
        or not set(moved) <= set(robot.group(group).joints)
        or not any(map(any, filter(None, corners)))
    ):
        return ()
    if frame_id(node["header"]) not in world_names:
        notes.append(f"{node.place}: is ignored, being of a frame that is not the world")
        return ()
    low, high = (corner or (0.0, 0.0, 0.0) for corner in corners)
    if low[0] > high[0] or low[1] > high[1]:
        raise node.error("its least corner is beyond its largest one")
    middle = {joint: (low[i] + high[i]) / 2.0 for i, joint in enumerate(moved)}
    half = {joint: (high[i] - low[i]) / 2.0 for i, joint in enumerate(moved)}
    return (joint_positions(middle, below=half, above=half),)


def _transforms(node: Node, robot: Robot) -> list[tuple[str, Node]]:
    node.only(field_names(MultiDOFJointState))
    names = [name.text() for name in node["joint_names"].elements()]
    transforms = node["transforms"].elements()
    if names and len(names) != len(transforms):
        raise node.error(f"{len(names)} names, but {len(transforms)} transforms")
    if len(transforms) == 1 and (not names or not robot.base.name):
        names = [robot.base.name]
    return list(zip(names or [""] * len(transforms), transforms, strict=True))


def _same(one: Placement, other: Placement) -> bool:
    return float(abs(one.homogeneous - other.homogeneous).max()) <= NOT_DISPLACED


def read_joint_positions(node: Node, robot: Robot, notes: list[str]) -> Mapping[str, float]:
    """Return the joint positions in a robot state, by joint [rad | m].

    Joints that the description fixes or does not have, such as wheels and fingers, are skipped and noted. The
    positions of a planar base come from its transform; see `base_positions`.
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
    """Return the joint positions in a robot state that may name only joints of the robot."""
    for joint, (at, name, value) in _stated(node).items():
        if _moved(robot, joint, at):
            raise value.error(f"joint {shown(joint)} is fixed and cannot be at {at:g}")
        if joint not in robot.fixed_joints:
            require(name, JointNotFound, "joint", joint, robot.joint_names)
    return read_joint_positions(node, robot, [])


def _stated(node: Node) -> Mapping[str, tuple[float, Node, Node]]:
    state = node.only(field_names(RobotState))["joint_state"]
    state.only(field_names(JointState))
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
    """Return positions of all joints, (number of joints,) [rad | m]; later layers override earlier ones.

    If a later layer moves the source of a mimic joint, the joint follows its source, unless that layer or a
    later one names the joint itself. Joints in no layer have their default.
    """
    named: dict[str, float] = {}
    for layer in layers:
        for joint, mimic in robot.mimics.items():
            if mimic.source in layer:
                named.pop(joint, None)
        named.update(layer)
    return robot.positions(named)
