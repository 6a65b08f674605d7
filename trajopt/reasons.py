"""Why there is no plan, in words: which pair, which joint, by how much, and where."""

import numpy as np

from trajopt.problem import Problem
from trajopt.seeds import GoalCandidates
from trajopt.solvers import SolveResult
from trajopt.terms import Clearance
from trajopt.verify import Certificate, Examination

NAMED = 3
"""Colliding pairs that a sentence names."""


def out_of_limits(seen: Examination) -> str:
    """Say which joints are outside their limits at an examined configuration; empty for none."""
    return "; ".join(
        f"{item.joint} at {item.position:.4f} is outside [{item.lower:.4f}, {item.upper:.4f}]"
        for item in seen.out_of_limits
    )


def collisions(seen: Examination) -> str:
    """Say what collides at an examined configuration; empty for nothing."""
    return "; ".join(
        f"{item.first} is {max(-item.distance, 0.0) * 1000:.1f} mm inside {item.second}"
        for item in seen.collisions[:NAMED]
    )


def no_goal_configuration(found: GoalCandidates) -> str:
    """Say why no configuration that reaches a goal can be had."""
    if found.blocking is None:
        return f"the nearest of the configurations tried misses the goal by {found.nearest_miss:.3g} (m, rad)"
    first, second, depth = found.blocking
    return (
        f"all {found.colliding} configurations that reach the goal collide; in the nearest, "
        f"{first} is {depth * 1000:.1f} mm inside {second}"
    )


def stuck(problem: Problem, solved: SolveResult) -> str:
    """Say which constraint the solver could not satisfy, where, and by how much."""
    worst = max(solved.at.constraints, key=lambda block: block.worst / block.tolerance)
    row = int(np.argmax(worst.violation))
    what = f"{worst.name} by {worst.worst:.3g}"
    if worst.name == Clearance.name:
        first, second = problem.reduced.owners(int(worst.rows.component[row]))
        what = f"clearance of {first} from {second} by {1000 * worst.worst:.1f} mm"
    where = f"{worst.rows.place[row] / (problem.knots - 1):.0%} of the way"
    return f"{solved.status.value}; worst is {what} at {where}"


def not_verified(certificate: Certificate) -> str:
    """Say what the judge refused."""
    return "; ".join(f"{check.name}: {check.detail}" for check in certificate.failed)
