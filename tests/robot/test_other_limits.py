"""Jerk limits for robots that state none: chosen where asked for, named, and held."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.robot.robot import DEFAULT_RISE
from trajopt.values.errors import JointNotFound, ProblemError, ShapeError

LIMITS = """
joint_limits:
  elbow: {has_jerk_limits: true, max_jerk: 7}
"""


def one(robot: to.Robot, joint: str) -> float:
    return float(robot.limits.jerk[robot.joint_names.index(joint)])


def acceleration(robot: to.Robot, joint: str) -> float:
    return float(robot.limits.acceleration[robot.joint_names.index(joint)])


@pytest.fixture
def arm(tmp_path: Path) -> to.Robot:
    odd_arm(tmp_path)
    (tmp_path / "limits.yaml").write_text(LIMITS)
    return to.load(tmp_path / "odd.urdf", limits=tmp_path / "limits.yaml")


def test_stated_limits_stay_and_chosen_ones_are_named(arm: to.Robot) -> None:
    assert np.isinf(one(arm, "pan")) and one(arm, "elbow") == 7.0
    limited = arm.with_jerk_limits()
    assert one(limited, "pan") == pytest.approx(acceleration(arm, "pan") / DEFAULT_RISE)
    assert one(limited, "elbow") == 7.0
    chosen = [note for note in limited.limits.defaulted if " jerk " in note]
    assert any(note.startswith("pan jerk ") for note in chosen)
    assert not any(note.startswith("elbow ") for note in chosen)
    assert "pan" in limited.notes[-1] and "reached in 0.1 s" in limited.notes[-1]
    assert "elbow" not in limited.notes[-1]
    assert np.isinf(one(limited, "follow")) == np.isinf(acceleration(arm, "follow"))
    assert limited.with_jerk_limits() is limited


def test_a_time_is_for_stated_limits_too_but_never_loosens_them(arm: to.Robot) -> None:
    slow = arm.with_jerk_limits(rise=2.0)
    for joint in ("pan", "elbow"):
        assert one(slow, joint) == pytest.approx(acceleration(arm, joint) / 2.0)
    assert one(arm.with_jerk_limits(rise=0.01), "elbow") == 7.0
    some = arm.with_jerk_limits(rise=2.0, joints=["pan"])
    assert one(some, "elbow") == 7.0 and one(some, "pan") == one(slow, "pan")


def test_invalid_times_and_unknown_joints_are_refused(arm: to.Robot) -> None:
    with pytest.raises(ShapeError, match="rise"):
        arm.with_jerk_limits(rise=0.0)
    with pytest.raises(JointNotFound, match="pan"):
        arm.with_jerk_limits(joints=["pann"])
    with pytest.raises(ProblemError, match="limit_jerk"):
        to.load("planar2", limit_jerk="yes")  # pyright: ignore[reportArgumentType]


def test_a_plan_keeps_the_chosen_limits_and_notes_them(planar_arm: to.Robot, tmp_path: Path) -> None:
    problem = to.Problem(
        scene=to.Scene(planar_arm),
        group="arm",
        start={"shoulder": 0.0, "elbow": 0.5},
        goal=to.joint_positions({"shoulder": 1.0, "elbow": 1.0}),
    )
    free = to.plan(problem).require()
    assert any("jerk is not limited" in note and "shoulder" in note for note in free.certificate.notes)
    limited = planar_arm.with_jerk_limits()
    held = to.plan(replace(problem, scene=to.Scene(limited))).require()
    assert any(check.name == "jerk" and check.holds for check in held.certificate.checks)
    assert any(
        note.startswith("limit chosen: shoulder jerk 2292 deg/s^3 (no limit stated)")
        for note in held.certificate.notes
    )
    assert not any("jerk is not limited" in note for note in held.certificate.notes)
    jerk = held.trajectory(np.linspace(0.0, held.trajectory.duration, 5000), 3)
    assert np.abs(jerk).max() <= 40.0 * (1.0 + 1e-6)
    assert held.trajectory.duration > free.trajectory.duration


def test_load_chooses_them_too(tmp_path: Path) -> None:
    odd_arm(tmp_path)
    assert np.isinf(one(to.load(tmp_path / "odd.urdf"), "pan"))
    assert np.isfinite(one(to.load(tmp_path / "odd.urdf", limit_jerk=True), "pan"))
    assert to.load("planar2", limit_jerk=True).notes == to.load("planar2").notes


@pytest.mark.parametrize(("lower", "upper"), [(4.0, np.inf), (-np.inf, -4.0)])
def test_a_limit_on_one_side_beyond_half_a_turn_is_planned_with(lower: float, upper: float) -> None:
    """Positions were drawn between it and half a turn on its other side: an error of numpy."""
    arm = to.load("planar2")
    limits = replace(arm.limits, lower=np.array([-3.0, lower]), upper=np.array([3.0, upper]))
    scene = to.Scene(replace(arm, limits=limits))
    near = float(np.clip(0.0, lower + 0.5, upper - 0.5))
    goal = scene.placement_of("tool", arm.positions({"joint1": 0.5, "joint2": near}))
    problem = to.Problem(
        scene=scene,
        start=[0.0, near],
        goal=to.frame_placement("tool", goal, rotation_tolerance=np.inf),
    )
    assert to.plan(problem).verified
