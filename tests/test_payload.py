"""Masses that are carried: by hand, by the planner's model and by the judge's own account of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from tests.verify.arms import mixed_arm, planar_arm, reduced, wavy
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise import terms
from trajopt.problem.residual import WHOLE
from trajopt.scene.reduced import loaded_model
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.verify import VerifyOptions
from trajopt.verify.checks.torques import inverse_dynamics, payload_torques
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion


def loaded(scene: to.Scene, frame: str, mass: float) -> to.Scene:
    return scene.add("load", to.Box(0.1, 0.1, 0.1), to.placement((0.1, 0.02, 0.03)), frame=frame, mass=mass)


def test_planner_and_judge_agree_on_the_torque_of_a_load(tmp_path: Path) -> None:
    """Composite inertias in pinocchio against d'Alembert's principle, on joints of every kind."""
    scene = loaded(to.Scene(mixed_arm(tmp_path)), "finger", 2.5)
    model = reduced(scene, [0.1, -0.2, 0.05, 0.3])
    there = wavy(model, 4)
    motion = JudgedMotion(model, there, kinematics=Kinematics(model), options=VerifyOptions())
    times, torques = inverse_dynamics(motion)
    inner = (times[:, None] != there.times).all(axis=1)
    q, v, a = (there(times[inner], order) for order in range(3))
    heavy = DynamicsQuery(replace(model, model=loaded_model(model)))
    assert torques[inner] == pytest.approx(heavy.torque(q, v, a), abs=1e-8)
    light = DynamicsQuery(model).torque(q, v, a)
    assert np.abs(torques[inner] - light).max() > 1.0


def test_turning_a_bar_takes_its_moment_of_inertia(tmp_path: Path) -> None:
    scene = to.Scene(planar_arm(tmp_path)).add("bar", to.Box(0.6, 0.02, 0.02), frame="tip", mass=5.0)
    still, faster = np.zeros((1, 2)), np.array([[0.0, 1.0]])
    needed = payload_torques(Kinematics(reduced(scene, [0.0, 0.0])), still, still, faster)
    moment = 5.0 * (0.6**2 + 0.02**2) / 12.0
    assert needed[0] == pytest.approx([5.0 * 1.0 * 0.5 + moment, 5.0 * 0.5**2 + moment])


def test_attaching_sets_or_keeps_the_mass(tmp_path: Path) -> None:
    scene = to.Scene(odd_arm(tmp_path)).add("cup", to.Sphere(0.05), to.placement((0.5, 0, 0)), mass=0.4)
    held = scene.attach("cup", "tip", placement=to.placement((0, 0, 0.1)))
    assert held.object("cup").mass == 0.4
    assert scene.attach("cup", "tip", placement=to.placement((0, 0, 0.1)), mass=0.9).object("cup").mass == 0.9
    with pytest.raises(ShapeError, match="negative"):
        scene.attach("cup", "tip", placement=to.placement((0, 0, 0.1)), mass=-1.0)
    robot = scene.robot
    goal = to.joint_positions({"elbow": 0.1})
    standing = to.Problem(scene=scene, start=robot.positions(), goal=goal).reduced
    assert loaded_model(standing) is standing.model
    carried = to.Problem(scene=held, start=robot.positions(), goal=goal).reduced
    before, after = (pin.computeTotalMass(one) for one in (carried.model, loaded_model(carried)))
    assert after - before == pytest.approx(0.4)


def test_a_share_that_means_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="share"):
        to.gravity_torque(1.5)
    model = reduced(to.Scene(planar_arm(tmp_path)), [0.0, 0.0])
    (item,) = terms.constrain(to.gravity_torque(0.5), model, WHOLE)
    assert (item.lower[0], item.upper[0]) == pytest.approx((-0.45, 0.45))
