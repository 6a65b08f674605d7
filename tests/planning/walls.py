"""An arm that must swing past a thin wall which the straight line does not get around."""

import trajopt as to
from trajopt.optimise.methods import Knots
from trajopt.optimise.transcription import fixed_goal
from trajopt.planning.seeds import Blocked, SeedContext, line_through

START = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
GOAL = {**START, "pan": 1.0}


def wall(arm: to.Robot, inner_edge: float = 0.55) -> to.Problem:
    """Return the problem; the wall begins so far from the arm's axis [m]."""
    scene = to.Scene(arm).add("wall", to.Box(1.0, 0.02, 2.0), to.placement((inner_edge + 0.5, 0.0, 0.3)))
    return to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL))


def walled_in(arm: to.Robot) -> to.Problem:
    """Return a problem that has no solution."""
    scene = to.Scene(arm).add("wall", to.Box(1.6, 0.02, 3.0), to.placement((0.95, 0.0, 0.0)))
    scene = scene.add("other wall", to.Box(1.6, 0.02, 3.0), to.placement((-0.95, 0.0, 0.0)))
    return to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL))


def route_of(problem: to.Problem) -> SeedContext:
    """Return the straight way to the goal."""
    reduced, goal = problem.reduced, fixed_goal(problem)
    assert goal is not None
    line = line_through(reduced, (reduced.start_positions, goal), problem.knots)
    return SeedContext(problem, line, Knots().program(problem, line.knots).scale)


def blocked_by(problem: to.Problem, name: str) -> Blocked:
    """Return a contact with an object in the middle of the straight way."""
    context = route_of(problem)
    pairs = problem.reduced.pairs
    owners = [problem.reduced.owners(pair) for pair in range(len(pairs.margin))]
    (pair,) = (number for number, both in enumerate(owners) if set(both) == {"tip", name})
    return Blocked(context.line.knots, 0.5 * (problem.knots - 1), pair)
