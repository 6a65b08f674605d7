"""Options of solvers that no solver can work with are refused where they are given."""

import pytest

from trajopt.optimise.solvers import Chomp, Effort, Sqp, Stomp
from trajopt.values.errors import ProblemError

TOO_SMALL = [
    *((Sqp, name, 0) for name in ("max_iterations", "penalty", "penalty_growth")),
    (Sqp, "penalty_rounds", -1),
    *((Sqp, name, -1e-9) for name in ("relative_gain", "absolute_gain")),
    *((Chomp, name, 0) for name in ("max_iterations", "learning_rate", "step_limit", "weight_growth")),
    *((Chomp, name, -1) for name in ("after_feasible", "smoothness_weight", "obstacle_weight")),
    *((Stomp, name, 0) for name in ("max_iterations", "rollouts", "noise", "sensitivity")),
    *((Stomp, name, -1) for name in ("after_feasible", "kept", "cost_weight", "seed")),
]


@pytest.mark.parametrize(("solver", "name", "value"), TOO_SMALL)
def test_a_number_that_is_too_small_is_named(
    solver: type[Sqp | Chomp | Stomp], name: str, value: float
) -> None:
    with pytest.raises(
        ProblemError, match=rf"{solver.__name__}: {name} must be (positive|at least [01]), is "
    ):
        solver(**{name: value})


def test_the_brief_form_of_any_solver_takes_a_step() -> None:
    assert Sqp(max_iterations=1).with_effort(Effort.BRIEF).max_iterations == 1


def test_full_effort_changes_nothing() -> None:
    assert Sqp().with_effort(Effort.FULL) == Sqp() and not Sqp().gives_up
