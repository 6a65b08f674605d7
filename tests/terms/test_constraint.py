"""Bounds of a constraint are checked when it is made."""

import numpy as np
import pytest

from trajopt.errors import TrajoptError
from trajopt.terms import constraint
from trajopt.terms.smoothness import Velocity


@pytest.mark.parametrize("bad", [{"tolerance": np.nan}, {"tolerance": -1.0}, {"reach": np.nan}])
def test_a_tolerance_that_is_no_number_is_refused(bad: dict[str, float]) -> None:
    with pytest.raises(TrajoptError, match=next(iter(bad))):
        constraint(Velocity(), lower=0.0, upper=1.0, **bad)
