"""How many knots the path of a problem has."""

from trajopt.robot.robot import Robot
from trajopt.values.errors import ProblemError, shown

DEFAULT_KNOTS = 24
"""Knots of a path; 20 to 32 make no difference, 16 lose a few problems."""

ROLLING_KNOTS = 48
"""The same where wheels roll: how far they stray falls with the square of a step; with 24 knots it is 10 to
30 mm on a journey of ten metres."""

LEG_KNOTS = 8
"""Knots of the leg between two waypoints: enough to leave a straight line, pass something and come back."""

MOST_KNOTS = 2000
"""Time and memory grow with the square of the knots: this many take some seconds and 0.3 GB."""


def stated_knots(robot: Robot, group: str, stated: int, waypoints: int = 0) -> int:
    """Return the number of knots of a path of a group: what a problem states, unless that is 0.

    Args:
        robot: The robot.
        group: Its group.
        stated: What the problem states.
        waypoints: How many waypoints the path has.

    Raises:
        ProblemError: If it is no whole number, too small or too large.
    """
    if stated != 0:
        whole = isinstance(stated, int)  # pyright: ignore[reportUnnecessaryIsInstance]
        if not whole or not 3 <= stated <= MOST_KNOTS:
            raise ProblemError(f"knots must be a whole number from 3 to {MOST_KNOTS}, not {shown(stated)}")
        return stated
    rolls = robot.base.rolling(robot.group(group).joints)
    least = DEFAULT_KNOTS if rolls is None else ROLLING_KNOTS
    return min(max(least, LEG_KNOTS * (waypoints + 1) + 1), MOST_KNOTS)
