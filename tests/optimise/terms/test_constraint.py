"""Bounds of a constraint are checked when it is made."""

import numpy as np
import pytest

from trajopt.optimise.terms import Constraint, constraint
from trajopt.problem.smoothness import Velocity
from trajopt.values.errors import TrajoptError


@pytest.mark.parametrize("bad", [{"tolerance": np.nan}, {"tolerance": -1.0}, {"reach": np.nan}])
def test_a_tolerance_that_is_not_a_number_is_refused(bad: dict[str, float]) -> None:
    with pytest.raises(TrajoptError, match=next(iter(bad))):
        constraint(Velocity(), lower=0.0, upper=1.0, **bad)
    with pytest.raises(TrajoptError, match=next(iter(bad))):
        Constraint(Velocity(), np.zeros(1), np.ones(1), **bad)


@pytest.mark.parametrize(("lower", "upper"), [(np.nan, 1.0), (0.0, np.nan), (2.0, 1.0)])
def test_bounds_that_hold_nothing_are_refused(lower: float, upper: float) -> None:
    with pytest.raises(TrajoptError, match=r"lower|upper"):
        constraint(Velocity(), lower=lower, upper=upper)
    with pytest.raises(TrajoptError, match=r"lower|upper"):
        Constraint(Velocity(), np.array((lower,)), np.array((upper,)))
