"""explain(result): the whole explanation."""

from collections.abc import Callable
from dataclasses import replace

from trajopt.planning.plan import plan as plan_problem
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.values.arrays import function, one_of
from trajopt.values.errors import shown
from trajopt.values.errors.arguments import checked
from trajopt.why.candidates import candidates
from trajopt.why.diagnosis import diagnose
from trajopt.why.explanation import Explanation
from trajopt.why.prices import prices
from trajopt.why.remedies import smallest_changes


@checked
def explain(
    result: Result, *, plan_again: bool = False, plan: Callable[[Problem], Result] = plan_problem
) -> Explanation:
    """Explain a result; see `Result.explain`.

    Args:
        result: The planning result.
        plan_again: Whether to search remedies of a failure, or prices of a success in seconds.
        plan: Plans a changed problem; pass your own for a non-default method.

    Raises:
        ProblemError: If an argument is of the wrong kind.
    """
    one_of("plan_again", plan_again, bool)
    function("plan", plan)
    if one_of("result", result, Result).alternatives:
        return _of_a_goal_set(result, plan_again, plan)
    found = diagnose(result)
    if result.verified:
        return replace(found, prices=prices(result, seconds=plan_again))
    if plan_again:
        return replace(found, remedies=smallest_changes(candidates(found), plan))
    return found


def _of_a_goal_set(result: Result, plan_again: bool, plan: Callable[[Problem], Result]) -> Explanation:
    """Explain a set of goals by its first tried goal: the nearest that was not refused."""
    name, nearest = next(iter(result.alternatives.items()))
    alone = explain(nearest, plan_again=plan_again, plan=plan)
    grounds = f"of the goal {shown(name)}, {alone.grounds}"
    return replace(alone, reason=result.reason, grounds=grounds, certainty=result.certainty)
