"""Motions in turn: joined at rest, with a stand between them only if accelerations jump."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trajopt.timing.time_scaling import JOLT, in_turn
from trajopt.values.trajectory import Trajectory


def leg(begin: float, end: float, acceleration: float) -> Trajectory:
    """Return a motion from rest to rest that begins and ends with an acceleration."""
    return Trajectory(
        ("a",),
        np.array((0.0, 1.0)),
        np.array(((begin,), (end,))),
        np.zeros((2, 1)),
        np.array(((acceleration,), (-acceleration,))),
    )


@given(st.floats(0.01, 20.0), st.floats(-20.0, 20.0))
def test_motions_that_brake_and_speed_up_stand_for_two_instants(first: float, second: float) -> None:
    joined = in_turn(leg(0.0, 1.0, first), leg(1.0, 0.5, second))
    jumps = abs(second + first) > 1e-5
    assert joined.duration == pytest.approx(2.0 + 2.0 * JOLT * jumps)
    stand = np.linspace(1.0, joined.duration - 1.0, 50)
    assert np.abs(joined(stand) - 1.0).max() <= max(first, abs(second)) * JOLT**2
    assert np.abs(joined(stand, 2)).max() <= max(first, abs(second)) + 1e-6
    assert joined(joined.duration)[0] == pytest.approx(0.5)
