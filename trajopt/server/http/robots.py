"""A robot as plain data: what a client must know of it to ask for something."""

from math import isfinite

from trajopt.robot.robot import Robot
from trajopt.values.arrays import Floats


def robot_document(name: str, robot: Robot) -> dict[str, object]:
    """Return a robot as plain data that JSON can hold; a limit that there is not is null.

    Args:
        name: Name by which the server knows it.
        robot: The robot.
    """
    limits = robot.limits
    return {
        "name": name,
        "joints": {
            joint: {
                "lower": _finite(limits.lower, place),
                "upper": _finite(limits.upper, place),
                "velocity": _finite(limits.velocity, place),
                "acceleration": _finite(limits.acceleration, place),
            }
            for place, joint in enumerate(robot.joint_names)
        },
        "groups": {key: list(group.joints) for key, group in robot.groups.items()},
        "states": [
            {"group": group, "name": state, "positions": dict(positions)}
            for (group, state), positions in robot.states.items()
        ],
        "links": list(robot.links),
        "frames": list(robot.frame_names),
    }


def _finite(values: Floats, place: int) -> float | None:
    value = float(values[place])
    return value if isfinite(value) else None
