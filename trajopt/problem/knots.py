"""Number of knots of a problem's path."""

from trajopt.robot.robot import Robot
from trajopt.values.errors import ProblemError, shown

DEFAULT_KNOTS = 24
"""Knots of a path; 20 to 32 perform alike, 16 lose a few problems."""

ROLLING_KNOTS = 48
"""Knots for bases with driven wheels. Their drift falls with the square of a step; with 24 knots it is 10 to
30 mm over ten metres.
"""

LEG_KNOTS = 8
"""Knots of the leg between two waypoints: enough for a detour around an obstacle."""

MOST_KNOTS = 2000
"""Time and memory grow with the square of the knots; this number takes some seconds and 0.3 GB."""


def stated_knots(robot: Robot, group: str, stated: int, waypoints: int = 0) -> int:
    """Return the number of knots of a group's path: the stated number, or the default if it is 0.

    Args:
        robot: Robot.
        group: Planning group.
        stated: `Problem.knots`.
        waypoints: Number of waypoints on the path.

    Raises:
        ProblemError: If `stated` is not an integer, or out of range.
    """
    if stated != 0:
        whole = isinstance(stated, int)  # pyright: ignore[reportUnnecessaryIsInstance]
        if not whole or not 3 <= stated <= MOST_KNOTS:
            raise ProblemError(f"knots must be a whole number from 3 to {MOST_KNOTS}, not {shown(stated)}")
        return stated
    rolls = robot.base.rolling(robot.group(group).joints)
    least = DEFAULT_KNOTS if rolls is None else ROLLING_KNOTS
    return min(max(least, LEG_KNOTS * (waypoints + 1) + 1), MOST_KNOTS)
