"""The judge's verdict on coupled joints: exact between samples, mimicking joints included."""

from pathlib import Path

import pytest

from tests.verify.arms import mixed_arm, quintic, reduced
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import coupled_joints
from trajopt.model.scene import Scene
from trajopt.model.trajectory import Trajectory
from trajopt.verify import Check, Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import Motion


def judged(model: ReducedModel, there: Trajectory, when: When, tolerance: float) -> Check:
    motion = Motion(model, there, kinematics=Kinematics(model), options=VerifyOptions())
    wanted = coupled_joints({"j1": 1.0, "j4": -1.0, "j5": 2.0}, 0.2, tolerance=tolerance)
    (found,) = check_requirement(wanted, motion, when)
    return found


def test_the_extreme_between_points_is_exact(tmp_path: Path) -> None:
    """With j5 = 0.1 - j4 / 2 the sum is j1 - 2 j4 + 0.2: it leaves its value by j1 - 2 j4."""
    model = reduced(Scene(mixed_arm(tmp_path)), [0.0, 0.0, 0.0, 0.0])
    there = quintic(model, [[0.0] * 4, [0.9, 0.5, 0.1, 0.2], [0.0] * 4], 1.0)
    assert judged(model, there, When.END, 1e-3).holds
    found = judged(model, there, When.ALWAYS, 0.501)
    assert found.holds
    assert found.evidence is Evidence.PROVEN
    assert found.value == pytest.approx(0.5)
    assert found.time == pytest.approx(0.5, abs=1e-3)
    assert not judged(model, there, When.ALWAYS, 0.499).holds
