"""Torques that hold a load against gravity: by hand, and what every kind is asked."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
import trajopt.optimise.terms
from tests.problem.requirements.kind import Kind
from tests.verify.arms import planar_arm, quintic, reduced
from trajopt.geometry import Query
from trajopt.optimise.terms.gravity_torque import GravityShare, HoldingTorque
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import GravityTorque
from trajopt.scene.reduced import payloads
from trajopt.verify import Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion


def test_a_rod_holds_a_load_by_hand(tmp_path: Path) -> None:
    """A planar arm in the plane of gravity, stretched: each joint bears the weights times their levers."""
    arm = planar_arm(tmp_path, axis="0 -1 0")
    scene = to.Scene(arm).add("load", to.Sphere(0.01), frame="tip", mass=3.0)
    model = reduced(scene, [0.0, 0.0])
    assert [(item.name, item.mass) for item in payloads(model)] == [("load", 3.0)]
    expected = 9.81 * np.array((0.25 + 0.75 + 1.01 * 0.0 + 3.01 * 1.0, 0.25 + 3.01 * 0.5))
    motion = Motion.single(np.zeros(2), Query(model))
    found = GravityShare(model, np.arange(2)).linearise(motion).value * 500.0
    assert found == pytest.approx(expected, abs=1e-9)
    rise = quintic(model, [[0.0, 0.0], [1.2, 0.0]], 1.0)
    timed = JudgedMotion(model, rise, kinematics=Kinematics(model), options=VerifyOptions())
    share = float(expected[0]) / 500.0
    for factor, holds in ((1.001, True), (0.999, False)):
        (check,) = check_requirement(to.gravity_torque(factor * share), timed, When.ALWAYS)
        assert check.holds == holds
        assert check.evidence is Evidence.SAMPLED
        assert check.subject == "shoulder"
    (at_end,) = check_requirement(to.gravity_torque(0.999 * share), timed, When.END)
    assert at_end.holds


KIND = Kind(
    requirement=GravityTorque,
    printed=[(to.gravity_torque(0.5), "gravity takes at most 50% of the effort limits")],
    relaxed=[to.gravity_torque(0.05)],
    residuals={
        GravityShare: [lambda at: GravityShare(at.reduced, np.arange(4))],
        HoldingTorque: [lambda _: HoldingTorque(np.array((80.0, 90.0, 60.0, np.inf)), np.full(4, -np.inf))],
    },
    calls={"gravity_torque": {"share": 0.9}},
)
