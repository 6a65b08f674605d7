"""The way back from where a stop off the path has led to: all that is required has to hold again."""

from dataclasses import replace

from trajopt.driving.commitment import Commitment
from trajopt.planning import Budget
from trajopt.planning.plan import plan
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import joint_positions
from trajopt.values.trajectory import Trajectory


def way_back(commitment: Commitment, problem: Problem, at: float, budget: Budget) -> Trajectory | None:
    """Return the way from where a robot rests to where a stop led it off a path on which all held.

    Nothing that is required on the way may hold on it, but limits and clearances; it is proven.

    Args:
        commitment: What the robot will do.
        problem: What is asked of it.
        at: When it begins, on the executor's clock [s].
        budget: What the plan may take.

    Returns:
        The way; None where there is none, or no stop led off a path.
    """
    if commitment.left is None:
        return None
    driven = commitment.executor.joint_names
    places = {name: float(commitment.left[driven.index(name)]) for name in commitment.joint_names}
    there = replace(problem, goal=joint_positions(places), constraints=(), waypoints=())
    result = plan(commitment.from_then(there, at, commitment.world), budget=budget)
    if not result.verified:
        return None
    motion = result.require().trajectory
    proven = commitment.guard.proven(motion, commitment.world, at, requirements=False)
    return motion if proven else None
