"""A joint without limits that is asked to turn the long way round does, and the result says so."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import ODD_ARM
from trajopt.planning.search import long_turns


@pytest.fixture
def arm(tmp_path: Path) -> to.Robot:
    (tmp_path / "odd.urdf").write_text(ODD_ARM)
    return to.load(tmp_path / "odd.urdf")


def asked(arm: to.Robot, goal: object, start: float = 3.0) -> to.Problem:
    return to.Problem(scene=to.Scene(arm), start={"pan": start}, goal=goal)  # pyright: ignore


def test_the_nearer_position_is_named_and_the_goal_is_kept(arm: to.Robot) -> None:
    result = to.plan(asked(arm, {"pan": -3.0}))
    assert result.remarks == ("pan is asked to turn by 344 deg: 3.283 rad is the same angle, 16.2 deg away",)
    assert "note     pan is asked to turn" in str(result) and result.as_dict()["remarks"]
    motion = result.require().trajectory
    assert motion.positions[-1][motion.joint_names.index("pan")] == pytest.approx(-3.0, abs=1e-3)
    near = to.plan(asked(arm, {"pan": 2.0 * np.pi - 3.0}))
    assert near.remarks == () and near.require().trajectory.duration < motion.duration


def test_whole_turns_tolerances_and_goal_sets(arm: to.Robot) -> None:
    assert "3 rad is the same angle, 0 deg away" in long_turns(asked(arm, {"pan": 3.0 + 4.0 * np.pi}))[0]
    assert long_turns(asked(arm, {"pan": 0.0})) == ()
    wide = to.joint_positions({"pan": -3.0}, tolerance=3.0)
    assert long_turns(asked(arm, wide)) == ()
    several = to.any_of({"far": to.joint_positions({"pan": -3.0}), "near": to.joint_positions({"pan": 1.0})})
    assert len(long_turns(asked(arm, several))) == 1
