"""Joints at positions: verdicts, and what every kind is asked."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
import trajopt.optimise.terms
from tests.problem.requirements.kind import Kind
from tests.problem.requirements.sound import (
    END,
    check,
    reach,
)
from tests.verify.arms import mixed_arm, quintic, reduced
from trajopt.optimise.terms.joint_positions import JointPosition
from trajopt.problem.requirements import (
    JointPositions,
    joint_positions,
)
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.errors import JointNotFound
from trajopt.verify import Evidence, When


def test_joint_goals(model: ReducedModel) -> None:
    good = joint_positions({"shoulder": 0.9, "elbow": 0.4})
    (found,) = check(model, reach(model, END), good, When.END)
    assert found.holds
    assert found.name == "goal: joints"
    assert found.evidence is Evidence.PROVEN
    off = joint_positions({"shoulder": 0.9, "elbow": 0.42}, below={"elbow": 0.01})
    (found,) = check(model, reach(model, END), off, When.END)
    assert not found.holds
    assert found.subject == "elbow"
    assert found.slack == pytest.approx(-0.01)
    allowed = joint_positions({"elbow": 0.42}, below={"elbow": 0.03})
    assert check(model, reach(model, END), allowed, When.END)[0].holds
    with pytest.raises(JointNotFound, match="elbow"):
        check(model, reach(model, END), joint_positions({"elbov": 0.0}), When.END)


def test_joint_constraints_hold_between_the_points(model: ReducedModel) -> None:
    """There and back: the extreme is between the ends, exact."""
    there = reach(model, (0.9, 0.2), (-0.5, 0.2))
    wanted = joint_positions({"shoulder": 0.0}, tolerance=0.9)
    (found,) = check(model, there, wanted, When.ALWAYS)
    assert found.holds
    assert found.value == pytest.approx(0.9)
    assert found.time == pytest.approx(0.5, abs=1e-3)
    (found,) = check(model, there, joint_positions({"shoulder": 0.0}, tolerance=0.8999), When.ALWAYS)
    assert not found.holds
    assert found.evidence is Evidence.PROVEN
    (found,) = check(model, there, joint_positions({"elbow": 0.2}, tolerance=0.0), When.ALWAYS)
    assert found.holds


def test_joints_that_follow_or_stand_still_are_known(tmp_path: Path) -> None:
    model = reduced(Scene(mixed_arm(tmp_path)), [0.0, 0.0, 0.0, 0.4])
    trajectory = quintic(model, [[0.0, 0.0, 0.0, 0.4], [0.0, 0.0, 0.0, 1.0]], 1.0)
    assert check(model, trajectory, joint_positions({"j5": -0.4}), When.END)[0].holds
    (found,) = check(model, trajectory, joint_positions({"j5": -0.1}, tolerance=0.2), When.ALWAYS)
    assert not found.holds
    assert found.value == pytest.approx(-0.4)


KIND = Kind(
    requirement=JointPositions,
    printed=[
        (to.joint_positions({"a": 0.5, "b": -1}), "a = 0.5, b = -1, within 0.0001"),
        (
            to.joint_positions({"a": 0.5, "b": 1}, tolerance=0.1, above={"a": 0.2}),
            "a = 0.5 (-0.1, +0.2), b = 1 (-0.1, +0.1)",
        ),
    ],
    relaxed=[to.joint_positions({"elbow": 0.2}, tolerance=0.1)],
    residuals={JointPosition: [lambda _: JointPosition(np.array([2, 0]))]},
    calls={
        "joint_positions": {
            "positions": {"panda_joint1": 0.1},
            "tolerance": 0.1,
            "below": {"panda_joint1": 0.1},
            "above": {},
        }
    },
)
