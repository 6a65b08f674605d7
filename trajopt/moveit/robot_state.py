"""Robot state messages: where the joints are."""

from collections.abc import Mapping

import numpy as np

from trajopt.arrays import Floats
from trajopt.errors import JointNotFound
from trajopt.io.document import Node
from trajopt.model.robot import Robot
from trajopt.moveit.frames import require
from trajopt.moveit.pose import read_placement

ROBOT_STATE_FIELDS = (
    "joint_state",
    "multi_dof_joint_state",
    "attached_collision_objects",
    "is_diff",
)
FIXED_JOINT_TOLERANCE = 1e-6
"""A fixed joint may be listed with a position this close to zero [rad | m]."""


def read_joint_positions(node: Node, robot: Robot, notes: list[str]) -> Mapping[str, float]:
    """Return the positions that a robot state names, by joint [rad | m].

    Fixed joints may be listed at zero; joints of several degrees of freedom at no displacement.

    Args:
        node: The robot state message.
        robot: The robot.
        notes: Receives a sentence for every quaternion not of unit length.

    Raises:
        JointNotFound: If the robot has no such joint.
        FileFormatError: If names and positions do not go together, a fixed joint is moved, or the
            robot is displaced in the world.
    """
    state = node.only(ROBOT_STATE_FIELDS)["joint_state"]
    state.only(("header", "name", "position", "velocity", "effort"))
    names, values = state["name"].elements(), state["position"].elements()
    if len(names) != len(values):
        raise state.error(f"{len(names)} names, but {len(values)} positions")
    positions: dict[str, float] = {}
    for name, value in zip(names, values, strict=True):
        joint, position = name.text(), value.number()
        if joint in robot.fixed_joints:
            if abs(position) > FIXED_JOINT_TOLERANCE:
                raise value.error(f"joint {joint!r} is fixed and cannot be at {position:g}")
            continue
        require(name, JointNotFound, "joint", joint, robot.joint_names)
        if positions.setdefault(joint, position) != position:
            raise name.error(f"joint {joint!r} is listed twice, at different positions")
    _check_not_displaced(node["multi_dof_joint_state"], notes)
    return positions


def layered_positions(robot: Robot, *layers: Mapping[str, float]) -> Floats:
    """Return positions of all joints; later layers win over earlier ones.

    A mimicking joint that only an earlier layer names follows its source again when a later layer
    moves the source.

    Args:
        robot: The robot.
        layers: Joint -> position [rad | m]; joints in none of them are at their default.

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


def _check_not_displaced(node: Node, notes: list[str]) -> None:
    node.only(("header", "joint_names", "transforms", "twist", "wrench"))
    for transform in node["transforms"].elements():
        where = read_placement(transform, notes).homogeneous
        if np.abs(where - np.eye(4)).max() > FIXED_JOINT_TOLERANCE:
            raise transform.error("the robot stands elsewhere than at the origin of the world")
