"""Pose and workspace of a robot's base: `multi_dof_joint_state`, `workspace_parameters`."""

from collections.abc import Mapping
from dataclasses import replace

from trajopt.files.moveit.frames import frame_id
from trajopt.files.moveit.planar_joints import in_the_plane
from trajopt.files.moveit.pose import read_placement, read_vector
from trajopt.problem.requirements import Requirement, joint_positions
from trajopt.robot.bases import PLANAR
from trajopt.robot.loading.pinocchio_model import placed_model, root_placement
from trajopt.robot.robot import Robot
from trajopt.values.documents.document import Node
from trajopt.values.placement import IDENTITY, Placement

NOT_DISPLACED = 1e-6
"""Largest deviation of a listed fixed joint from its fixed pose [m | rad]."""


def base_positions(node: Node, robot: Robot, notes: list[str]) -> Mapping[str, float]:
    """Return the positions of a planar base, by joint [rad | m]; empty for other bases.

    Args:
        node: The joints of several degrees of freedom of a robot state.
        robot: The robot.
        notes: Receives a sentence for every quaternion not of unit length.

    Raises:
        FileFormatError: If the base leaves the plane, or a fixed joint is not at its fixed pose.
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
        robot: The robot.
        notes: Receives the sentence.

    Raises:
        FileFormatError: If a transform is malformed.
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

    Args:
        node: The workspace; a box of zero size is ignored, as in MoveIt.
        robot: The robot.
        group: Name of the planning group.
        world_names: Frame ids of the world.
        notes: Receives a sentence if the box is in another frame and therefore ignored.

    Raises:
        FileFormatError: If a corner is malformed, or a minimum exceeds a maximum.
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
    """Return transforms by joint; a single one is the base's if it or the base joint is unnamed."""
    node.only(("header", "joint_names", "transforms", "twist", "wrench"))
    names = [name.text() for name in node["joint_names"].elements()]
    transforms = node["transforms"].elements()
    if names and len(names) != len(transforms):
        raise node.error(f"{len(names)} names, but {len(transforms)} transforms")
    if len(transforms) == 1 and (not names or not robot.base.name):
        names = [robot.base.name]
    return list(zip(names or [""] * len(transforms), transforms, strict=True))


def _same(one: Placement, other: Placement) -> bool:
    return float(abs(one.homogeneous - other.homogeneous).max()) <= NOT_DISPLACED
