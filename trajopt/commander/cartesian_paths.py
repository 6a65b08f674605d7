"""A Cartesian path in MoveIt's words: straight lines through poses, as far as they go."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trajopt.arrays import Floats
from trajopt.cartesian import Followed, FollowOptions, follow, follows_curve, polyline
from trajopt.commander.exception import MoveItCommanderException
from trajopt.commander.settings import Settings
from trajopt.model.collisions.allowed_collisions import AllowedCollisions
from trajopt.model.placement import Placement
from trajopt.model.scene import Scene

SAME = 1e-6
"""Poses nearer to each other than this are one [m | rad]: scripts begin with the pose that they are at."""


def followed_through(
    scene: Scene,
    poses: Sequence[Placement],
    *,
    link: str,
    group: str,
    start: Floats,
    settings: Settings,
) -> Followed:
    """Follow straight lines from where a link is through poses, as far as they go.

    Args:
        scene: What is around the robot.
        poses: Of the link in the world.
        link: The link.
        group: The planning group.
        start: Positions of all joints at the beginning [rad | m].
        settings: Speeds.

    Raises:
        MoveItCommanderException: If there is no pose to go to.
    """
    stops = [scene.placement_of(link, start)]
    for pose in poses:
        if np.abs(pose.homogeneous - stops[-1].homogeneous).max() > SAME:
            stops.append(pose)
    if len(stops) == 1:
        raise MoveItCommanderException("compute_cartesian_path: no waypoint is elsewhere than the link")
    options = FollowOptions(
        velocity_scaling=settings.velocity_scaling,
        acceleration_scaling=settings.acceleration_scaling,
        tool_speed=() if settings.tool_speed is None else (settings.tool_speed,),
    )
    return follow(scene, follows_curve(link, polyline(stops)), start=start, group=group, options=options)


def without_collisions(scene: Scene) -> Scene:
    """Return the scene with every contact allowed."""
    everything = dict.fromkeys((*scene.robot.links, *scene.objects), True)
    return replace(scene, allowed=AllowedCollisions({}, everything))
