"""The state of a trajectory at a moment is what the trajectory says of it."""

from typing import Any

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


def test_names_of_joints_may_be_a_list() -> None:
    """They were kept as a list, so that the judge refused a motion of the very joints of its group."""
    names, knots = ["shoulder", "elbow"], np.array([[0.0, 0.0], [0.1, 0.2]])
    given: Any = names
    assert to.Trajectory(given, np.array([0.0, 1.0]), knots).joint_names == ("shoulder", "elbow")
    assert to.Path(given, knots).joint_names == ("shoulder", "elbow")
