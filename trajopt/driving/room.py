"""Room: what a motion is planned with so that it can be proven of a robot that is a little off it."""

from dataclasses import replace

from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.scene.scene import Scene

OF_DISTANCES = {
    Status.START_IN_COLLISION,
    Status.CLEARANCE_IMPOSSIBLE,
    Status.GOAL_IN_COLLISION,
    Status.NO_WAYPOINT,
    Status.STUCK,
    Status.PROVEN_INFEASIBLE,
    Status.BLOCKED_IN_TIME,
    Status.INEVITABLE,
    Status.FIXED_LINK_MET,
    Status.GOAL_OCCUPIED,
}
"""Reasons for which there may be no plan because larger distances are required."""
SMALLEST_SHARE = 1e-4
"""Room that is smaller is not named as a reason [m]."""


def with_room(scene: Scene, off: float) -> Scene:
    """Return a scene whose clearances are larger by how far a robot can be off where it has to be.

    Args:
        scene: What is around the robot.
        off: How far any point of it can be off [m].
    """
    stated = scene.clearances
    wider = replace(
        stated,
        everywhere=stated.everywhere + off,
        pairs={pair: value + off for pair, value in stated.pairs.items()},
        links={link: value + off for link, value in stated.links.items()},
        kinds={kind: value + off for kind, value in stated.kinds.items()},
    )
    return replace(scene, clearances=wider)


def with_share(result: Result, off: float) -> str:
    """Return why there is no plan, and how much of the required distances the robot's tolerance takes.

    Args:
        result: Of a problem in a scene that `with_room` made.
        off: How far any point of the robot can be off [m].
    """
    if result.status not in OF_DISTANCES or off < SMALLEST_SHARE:
        return result.reason
    return f"{result.reason}; {1e3 * off:.4g} mm of each required distance is room for the driver's tolerance"
