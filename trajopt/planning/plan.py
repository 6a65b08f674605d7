"""plan(problem): the whole of planning in one call; of a goal set, to the goal that comes easiest."""

from collections.abc import Callable
from threading import Event

import numpy as np

from trajopt.arrays import one_of
from trajopt.errors import ProblemError, shown
from trajopt.methods import Knots, Method
from trajopt.planning import Attempts, Meter, Portfolio, Progress, Search
from trajopt.planning.budget import Budget
from trajopt.planning.result import Result
from trajopt.problem import Problem

NO_BOUNDS = Budget()
"""The budget unless told otherwise: the first guesses that planning knows of, one after the other."""


def plan(
    problem: Problem,
    *,
    method: Method | None = None,
    rng: np.random.Generator | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
    progress: Progress | None = None,
    on_incumbent: Callable[[Result], None] | None = None,
) -> Result:
    """Plan a motion and have it judged.

    Args:
        problem: What the motion must achieve.
        method: Transcription and solver with their options; sequential QP over knots when None.
        rng: Draws the starts of inverse kinematics and the bends of first guesses; a fixed seed when
            None, so that the answer is the same every time.
        budget: How much work, time and how many cores it may use, and whether to go on improving.
        cancel: Set it from another thread to stop: the best motion so far is returned, if there is
            one.
        progress: Called at every stage and every step of the solver.
        on_incumbent: Called with every verified motion that is better than the one before.

    Returns:
        A result; `result.require()` gives the plan or raises with the reason.

    Raises:
        ProblemError: If a requirement cannot be asked of this robot, or an argument is of the wrong kind.
        KeyboardInterrupt: If interrupted before there is a motion; afterwards the motion is returned.
    """
    if cancel is not None:
        one_of("cancel", cancel, Event)
    one_of("budget", budget, Budget)
    if not isinstance(method, Method | None):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ProblemError(
            f"method is a Method, is {shown(method)}; trajopt.methods.method_named returns one by its name"
        )
    method, rng, meter = method or Knots(), rng or np.random.default_rng(0), Meter(budget, cancel, progress)
    goals = problem.alternatives or {"": problem}
    portfolios = [Portfolio(Attempts(each, meter), method, rng, name) for name, each in goals.items()]
    return Search(problem, portfolios, meter, on_incumbent).run()
