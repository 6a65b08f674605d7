"""explain(result): the whole explanation, put together from its parts."""

from collections.abc import Callable
from dataclasses import replace

from trajopt.arrays import function, one_of
from trajopt.errors import shown
from trajopt.errors.arguments import checked
from trajopt.explanation.candidates import candidates
from trajopt.explanation.diagnosis import diagnose
from trajopt.explanation.explanation import Explanation
from trajopt.explanation.prices import prices
from trajopt.explanation.remedies import smallest_changes
from trajopt.planning.plan import plan as plan_problem
from trajopt.planning.result import Result
from trajopt.problem import Problem


@checked
def explain(
    result: Result, *, plan_again: bool = False, plan: Callable[[Problem], Result] = plan_problem
) -> Explanation:
    """Explain a result; see `Result.explain`.

    Args:
        result: What planning returned.
        plan_again: Whether to look for remedies of a failure, and for the prices of a success in seconds.
        plan: Plans a changed problem; give one of your own for another method than the default.

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
    """Explain a set of goals by the goal that was tried first: the nearest of those not refused."""
    name, nearest = next(iter(result.alternatives.items()))
    alone = explain(nearest, plan_again=plan_again, plan=plan)
    grounds = f"of the goal {shown(name)}, {alone.grounds}"
    return replace(alone, reason=result.reason, grounds=grounds, certainty=result.certainty)
