"""The straight line, and whole turns that shorten it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trajopt.optimise.kinematics.inverse import nearest_turn
from trajopt.planning.seeds.lines import straight_line
from trajopt.robot.joints import JointLimits


def limits(lower: float, upper: float) -> JointLimits:
    one = np.ones(1)
    return JointLimits(("a",), lower * one, upper * one, one, one, one, one)


def test_line() -> None:
    line = straight_line(np.array([0.0, 1.0]), np.array([1.0, -1.0]), 5)
    assert line[:, 0] == pytest.approx([0, 0.25, 0.5, 0.75, 1])
    assert line[-1] == pytest.approx([1.0, -1.0])


@given(st.floats(-20, 20), st.floats(-20, 20))
def test_a_continuous_joint_never_turns_more_than_half(start: float, goal: float) -> None:
    found = nearest_turn(np.array([start]), np.array([goal]), limits(-np.inf, np.inf), np.ones(1))[0]
    assert abs(found - start) <= np.pi + 1e-9
    assert np.cos(found - goal) == pytest.approx(1.0)


@given(st.floats(-6, 6), st.floats(-6, 6))
def test_turns_stay_inside_the_limits(start: float, goal: float) -> None:
    found = nearest_turn(np.array([start]), np.array([goal]), limits(-6.2, 6.2), np.ones(1))[0]
    assert -6.2 <= found <= 6.2
    assert abs(found - start) <= abs(goal - start) + 1e-12


def test_a_sliding_joint_does_not_turn() -> None:
    found = nearest_turn(np.zeros(1), np.array([6.0]), limits(-10, 10), np.zeros(1))
    assert found == pytest.approx([6.0])
