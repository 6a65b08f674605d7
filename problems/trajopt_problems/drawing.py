"""Random instances: drawn again until start and goal can be reached."""

from collections.abc import Callable

import numpy as np

import trajopt as to

DRAWS = 200
"""Instances that are drawn before giving up."""


def drawn(
    make: Callable[[np.random.Generator | None], to.Problem], rng: np.random.Generator | None
) -> to.Problem:
    """Return the fixed instance, or draw until the start is clear and a clear configuration holds the goal.

    Args:
        make: Makes the fixed instance of None, and draws one with a generator; raises `TrajoptError` where
            the arm cannot even begin.
        rng: Draws instances, and the starts of the search for goal configurations; None for the fixed one.

    Raises:
        TrajoptError: If no instance that is drawn is feasible.
    """
    if rng is None:
        return make(None)
    for _ in range(DRAWS):
        try:
            problem = make(rng)
        except to.TrajoptError:
            continue
        reduced = problem.reduced
        clear = to.examine(reduced, reduced.start_positions, moment=to.verify.Moment.START).clear
        if clear and to.goal_configurations(problem, rng=rng):
            return problem
    raise to.TrajoptError(f"none of {DRAWS} instances has a start and a goal that are clear")


def near(rng: np.random.Generator | None, value: float, spread: float) -> float:
    """Return the value itself for the fixed instance, else one drawn within a spread around it."""
    return value if rng is None else float(rng.uniform(value - spread, value + spread))
