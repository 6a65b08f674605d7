"""The state of a trajectory at a moment is what the trajectory says of it."""

import numpy as np
import pytest

import trajopt as to
from trajopt.values.trajectory import state_of


@pytest.mark.parametrize("stated", [0, 1, 2])
def test_it_equals_the_trajectory(stated: int) -> None:
    rng = np.random.default_rng(stated)
    rows = rng.normal(size=(stated + 1, 6, 3))
    motion = to.Trajectory(("a", "b", "c"), np.array((0.0, 0.2, 0.3, 0.7, 1.0, 1.6)), *rows)
    for t in (*rng.uniform(-0.2, 1.8, 40).tolist(), 0.0, 0.2, 0.7, 1.6):
        wanted = np.stack([motion(t, order) for order in range(3)])
        assert state_of(motion, t) == pytest.approx(wanted, abs=1e-9)
