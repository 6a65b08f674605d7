"""Retimed: the path that a robot is on, driven slower or with a stop, so that what moves passes before."""

from trajopt.driving.guard import Seen
from trajopt.driving.intention import Intention
from trajopt.geometry import Query
from trajopt.planning.moving.among import Among
from trajopt.planning.moving.timed_path import TimedOnPath
from trajopt.problem.problem import Problem


def retimed(
    intended: Intention, here: Problem, world: Seen, begin: float, patience: float
) -> TimedOnPath | None:
    """Return what is left of a motion, timed anew on its path and proven to its end; None if no timing is.

    Args:
        intended: The motion.
        here: Its problem, from where the robot will be when the rest begins.
        world: What is known of the world.
        begin: When the rest begins, on the executor's clock [s].
        patience: It is over no later than so much after the motion as it was [s].
    """
    among = Among.of(here, Query(here.reduced))
    if among is None:
        return None
    rest = intended.left(begin)
    until = min(rest.duration + patience, among.latest)
    motions = among.timing.timings(rest, until)
    return next((each for each in motions if intended.goal.guard.proven(each.trajectory, world, begin)), None)
