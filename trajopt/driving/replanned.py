"""Planned anew, from where the robot parts from the motion that it is on, or from where it stands."""

from trajopt.driving.guard import Seen
from trajopt.driving.intention import Goal
from trajopt.driving.running import Running
from trajopt.driving.uncertain import grow_uncertain
from trajopt.planning.plan import plan
from trajopt.planning.replan import replan
from trajopt.planning.result import Result


def replanned(running: Running, goal: Goal, at: float, *, hurry: bool) -> Result:
    """Plan to a goal from where the robot will be at a time.

    Where things are known worse and worse, and nothing is proven to the goal for that, what is clear as
    well as they were known when they were seen will do: it is gone along as far as that is proven.

    Args:
        running: The motion that the robot is on.
        goal: The goal.
        at: On the executor's clock [s].
        hurry: Whether only what is over sooner is of use.
    """
    world = running.commitment.world
    result = _among(running, goal, at, world, hurry)
    known = world.as_well_known(at)
    if result.verified or known is None or not grow_uncertain(world):
        return result
    other = _among(running, goal, at, known, hurry)
    return other if other.verified else result


def _among(running: Running, goal: Goal, at: float, world: Seen, hurry: bool) -> Result:
    """Plan in a world, beginning with what is left of the motion.

    What is left of one that goes slower than it could, or waits, would be that slow again.
    """
    commitment, intended, budget = running.commitment, running.intended, running.options.budget
    slow = hurry or intended is None or intended.held_back or intended.scaling.speed != 1.0
    if intended is None or slow or not intended.begin <= at < intended.end:
        return plan(commitment.from_then(goal.problem, at, world), budget=budget)
    there = commitment.still_at(goal.problem, at, commitment.around(at, world))
    return replan(there, intended.trajectory, at - intended.begin, budget=budget)
