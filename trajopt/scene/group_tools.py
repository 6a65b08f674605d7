"""The frame of a planning group that goals refer to: its tool, or its last link."""

import numpy as np

from trajopt.robot.loading.pinocchio_model import joint_above, link_above, link_joint
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError, listed, shown
from trajopt.values.placement import WORLD
from trajopt.values.shapes.shapes import bounding_sphere


def tool_of(scene: Scene, group: str) -> str:
    """Return the frame that a bare placement as goal of a group refers to.

    The tool frame of the scene, or else of the robot, that is fixed to the body of the group's last joint;
    else the tool centre point of the group's only end effector: the one link without children and shape fixed
    to it, beyond its shapes; else the tip of the group's chain; else the link that the SRDF fixes an end
    effector of the group to; else the group's only last link. A chain whose tip is on the end effector itself
    ends at that tip.
    """
    candidates = _tools(scene, group)
    if len(candidates) == 1:
        return candidates[0]
    raise ProblemError(
        f"group {shown(group)} has no single tool frame that a placement could mean: name it in "
        f"frame_placement(frame, placement); its ends are {listed(ends_of(scene, group))}"
    )


def ends_of(scene: Scene, group: str) -> tuple[str, ...]:
    """Return the frames at the ends of a group: its tool, or one for each arm."""
    candidates = _tools(scene, group)
    return tuple(dict.fromkeys(candidates)) if candidates else _ends(scene.robot, group)


def end_link(robot: Robot, group: str) -> str:
    """Return the last link of a group: the tip of its chain, or its only last link; None if ambiguous."""
    ends = _ends(robot, group)
    return robot.group(group).tip or (ends[0] if len(ends) == 1 and robot.group(group).joints else "")


def _ends(robot: Robot, group: str) -> tuple[str, ...]:
    own = robot.group(group)
    links = own.links or tuple(link for link in robot.links if joint_above(robot.model, link) in own.joints)
    above = {link_above(robot.model, link) for link in links}
    fixed_to = [item.parent_link for item in robot.end_effectors.values() if item.parent_link in links]
    return tuple(dict.fromkeys((*fixed_to, *(link for link in links if link not in above))))


def _tools(scene: Scene, group: str) -> list[str]:
    robot, own, ends = scene.robot, scene.robot.group(group), _ends(scene.robot, group)
    effectors = (item.parent_link for item in robot.end_effectors.values() if item.parent_group == group)
    tips = [own.tip] if own.tip is not None else list(dict.fromkeys(effectors))
    if not tips and len(ends) == 1:
        tips = list(ends)
    carriers = {link_joint(robot.model, link) for link in tips or ends}
    on = {name: scene.holder(name).link for name in (*robot.frames, *scene.tools)}
    carried = [
        name for name, link in on.items() if link != WORLD and link_joint(robot.model, link) in carriers
    ]
    return (
        [name for name in carried if name in scene.tools] or carried or _centre_points(robot, group) or tips
    )


def _centre_points(robot: Robot, group: str) -> list[str]:
    """Return the tool centre point of a group's only end effector; empty if there is not exactly one.

    It is farther from the end effector's link than its shapes are on average; frames of sensors are not.
    """
    own, model = robot.group(group), robot.model
    moved = [
        item.parent_link
        for item in robot.end_effectors.values()
        if str(model.names[link_joint(model, item.parent_link)]) in own.joints
    ]
    if len(moved) != 1 or (own.tip is not None and moved[0] in _above(robot, own.tip)):
        return []
    hand, joint = moved[0], link_joint(model, moved[0])
    on_hand = {
        link for link in robot.links if link_joint(model, link) == joint and hand in _above(robot, link)
    }

    def distance(link: str, point: Floats) -> float:
        of, at = (model.frames[model.getFrameId(each)].placement for each in (hand, link))
        return float(np.linalg.norm(at.rotation @ point + at.translation - of.translation))

    shapes = [
        distance(body.owner, body.placement * bounding_sphere(body.shape)[0])
        for body in robot.bodies
        if body.owner in on_hand
    ]
    taken = {link_above(model, link) for link in robot.links} | {body.owner for body in robot.bodies}
    least = np.mean(shapes) if shapes else 0.0
    found = [link for link in robot.links if link in on_hand - taken and distance(link, np.zeros(3)) >= least]
    return found if len(found) == 1 else []


def _above(robot: Robot, link: str) -> set[str]:
    found = set[str]()
    while above := link_above(robot.model, link) if joint_above(robot.model, link) != "universe" else "":
        found.add(above)
        link = above
    return found
