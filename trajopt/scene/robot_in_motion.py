"""Another robot that moves as planned, as objects of a scene: its links, and what it carries."""

from collections.abc import Mapping
from math import inf

import numpy as np

from trajopt.robot.bodies import Anchor, FixedBody
from trajopt.scene.planned_robot import MovingRobot
from trajopt.scene.scene_object import SceneObject
from trajopt.scene.timing import Timing
from trajopt.scene.track import Track
from trajopt.values.errors import ModelError, shown
from trajopt.values.placement import WORLD, Placement
from trajopt.values.shapes.shapes import bounding_box
from trajopt.values.trajectory import Trajectory


def robot_objects(
    name: str,
    robot: MovingRobot,
    trajectory: Trajectory,
    *,
    base: Placement,
    start: float,
    until: float = inf,
    tolerance: float,
) -> Mapping[str, SceneObject]:
    """Return everything with a shape that a robot is made of, and what it carries, as objects by id.

    Of what one joint carries the first has a track, and the rest is placed in its frame.

    Args:
        name: What the ids begin with.
        robot: What moves.
        trajectory: Of its group's joints.
        base: Of its world in the scene that the objects are for.
        start: When the motion begins, by the clock of that scene [s].
        until: Until when it is known to move so [s].
        tolerance: How far points may be from where the tracks have them [m].

    Raises:
        ModelError: If something that moves is a half-space.
        ShapeError: If a number is not usable.
    """
    owned: dict[str, list[FixedBody]] = {}
    for body in robot.bodies:
        if body.joint > 0 or body.owner not in robot.scene.objects:
            owned.setdefault(body.owner, []).append(body)
    found: dict[str, SceneObject] = {}
    first: dict[int, str] = {}
    for owner, bodies in owned.items():
        key, anchor = f"{name}/{owner}", robot.anchors[owner]
        inward = anchor.placement.inverse()
        parts = tuple((body.shape, inward * body.placement) for body in bodies)
        if anchor.joint == 0:
            found[key] = SceneObject(key, parts, base * anchor.placement, WORLD)
        elif anchor.joint in first:
            carrier = first[anchor.joint]
            where = robot.anchors[carrier].placement.inverse() * anchor.placement
            found[key] = SceneObject(key, parts, where, f"{name}/{carrier}")
        else:
            first[anchor.joint] = owner
            motion = Track.of(
                robot,
                owner,
                reach=max(_reach(body, anchor) for body in robot.bodies if body.joint == anchor.joint),
                trajectory=trajectory,
                base=base,
                start=start,
                until=until,
                tolerance=tolerance,
            )
            found[key] = SceneObject(key, parts, motion.track.at(0.0), WORLD, timing=Timing(motion))
    return found


def _reach(body: FixedBody, frame: Anchor) -> float:
    """Return how far the points of a body may be from the origin of a frame on the same joint [m].

    Raises:
        ModelError: If it is a half-space.
    """
    lower, upper = bounding_box(body.shape)
    if not (np.isfinite(lower).all() and np.isfinite(upper).all()):
        raise ModelError(
            f"{shown(body.owner)} has no end, so no track has all of it: a half-space cannot move"
        )
    where = frame.placement.inverse() * body.placement
    corners = np.stack(np.meshgrid(*zip(lower, upper, strict=True)), axis=-1).reshape(-1, 3)
    return float(np.linalg.norm(corners @ where.rotation.T + where.translation, axis=1).max())
