"""Speeds of tools: measured by the judge's own kinematics, and proven at all times."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.verify.arms import mixed_arm, planar_arm, quintic, reduced, wavy
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import FrameNotFound, ProblemError
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Check, Evidence, VerifyOptions, verify
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.relative_motion import PointMotion

OFFSET = (0.1, -0.05, 0.2)


@pytest.fixture
def planar(tmp_path: Path) -> ReducedModel:
    return reduced(Scene(planar_arm(tmp_path)), [0.1, 0.2])


@pytest.fixture
def mixed(tmp_path: Path) -> ReducedModel:
    return reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])


def moving(model: ReducedModel, trajectory: Trajectory, frame: str) -> PointMotion:
    motion = JudgedMotion(model, trajectory, kinematics=Kinematics(model), options=VerifyOptions())
    return PointMotion(motion, frame, offset=np.array(OFFSET))


def tool_checks(model: ReducedModel, trajectory: Trajectory, limited: ToolSpeed) -> list[Check]:
    certificate = verify(model, trajectory, goals=(), tool_speeds=(limited,))
    return [check for check in certificate.checks if "tool" in check.name]


def smooth(model: ReducedModel, seed: int) -> Trajectory:
    rng = np.random.default_rng(seed)
    shape = (5, len(model.joint_names))
    rows = [rng.uniform(-size, size, shape) for size in (0.5, 1.0, 4.0)]
    for row in rows[1:]:
        row[[0, -1]] = 0.0
    rows[0][0] = 0.0
    times = np.linspace(0.0, 2.0, 5)
    return Trajectory(model.joint_names, times, rows[0] + model.start_positions, rows[1], rows[2])


def placements(model: ReducedModel, trajectory: Trajectory, frame: str, t: Floats) -> tuple[Floats, Floats]:
    poses = Kinematics(model).poses(trajectory(t))
    joint, place = model.attachment(frame)
    rotation, translation = poses.rotation[:, joint], poses.translation[:, joint]
    return rotation @ place.rotation, rotation @ (place * np.array(OFFSET)) + translation


@pytest.mark.parametrize("frame", ["a", "c", "d", "finger"])
def test_velocities_are_those_of_finite_differences(mixed: ReducedModel, frame: str) -> None:
    trajectory, step = smooth(mixed, 4), 1e-6
    t = np.linspace(0.1, 1.9, 23)
    velocity, turning = moving(mixed, trajectory, frame).speeds(t)
    before, after = (placements(mixed, trajectory, frame, t + sign * step) for sign in (-1.0, 1.0))
    np.testing.assert_allclose(velocity, (after[1] - before[1]) / (2.0 * step), atol=1e-6)
    turns = Rotation.from_matrix(after[0] @ before[0].swapaxes(1, 2)).as_rotvec() / (2.0 * step)
    np.testing.assert_allclose(turning, turns, atol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_bounds_on_changes_hold(mixed: ReducedModel, seed: int) -> None:
    trajectory = smooth(mixed, seed)
    point = moving(mixed, trajectory, "finger")
    edges = np.linspace(0.0, 2.0, 81)
    bounds = point.changes(edges[:-1], edges[1:])
    for place in range(80):
        t = np.linspace(edges[place] + 1e-9, edges[place + 1] - 1e-9, 41)
        for which, velocity in enumerate(point.speeds(t)):
            step = t[1] - t[0]
            first = np.linalg.norm(np.diff(velocity, axis=0), axis=1) / step
            second = np.linalg.norm(np.diff(velocity, 2, axis=0), axis=1) / step**2
            assert first.max() <= bounds.first[place, which] * (1.0 + 1e-6)
            assert second.max() <= bounds.second[place, which] * (1.0 + 1e-4)


def test_a_turning_shoulder_moves_the_tip_on_a_circle(planar: ReducedModel) -> None:
    trajectory = quintic(planar, [[0.1, 0.0], [1.1, 0.0]], 1.0)
    model = replace(planar, start=np.array([0.1, 0.0]))
    peak = 15.0 / 8.0  # of a minimum-jerk leg of 1 rad in 1 s; the tip is 1 m away
    above, below = (to.tool_speed("tip", linear=peak * k, angular=peak * k) for k in (1.0005, 0.9995))
    for check in tool_checks(model, trajectory, above):
        assert check.holds and check.evidence is Evidence.PROVEN
        assert check.value == pytest.approx(peak, rel=1e-3)
    found = tool_checks(model, trajectory, below)
    assert [check.unit for check in found] == ["m/s", "rad/s"]
    for check in found:
        assert not check.holds and check.required
        assert check.time == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize("seed", range(3))
def test_any_interpolation_is_judged(planar: ReducedModel, seed: int) -> None:
    cubic = wavy(planar, seed)
    linear = Trajectory(cubic.joint_names, cubic.times, cubic.positions)
    for trajectory in (smooth(planar, seed), cubic, linear):
        inner = np.linspace(0.0, trajectory.duration, 20_001)[:-1] + 1e-7
        velocity, _ = moving(planar, trajectory, "tip").speeds(inner)
        largest = float(np.linalg.norm(velocity, axis=1).max())
        passed, refused = (to.tool_speed("tip", linear=largest * k, offset=OFFSET) for k in (1.01, 0.99))
        assert tool_checks(planar, trajectory, passed)[0].holds
        assert not tool_checks(planar, trajectory, refused)[0].holds


def test_a_frame_at_rest_has_no_speed(planar: ReducedModel) -> None:
    (check,) = tool_checks(
        planar, quintic(planar, [[0.1, 0.2], [1.0, 1.0]], 1.0), to.tool_speed("base", linear=0.1)
    )
    assert check.holds and check.value == 0.0


def test_a_limit_must_be_meant(planar: ReducedModel) -> None:
    with pytest.raises(ProblemError, match="give a linear limit"):
        to.tool_speed("tip")
    with pytest.raises(ProblemError, match="angular limit must be positive"):
        to.tool_speed("tip", angular=0.0)
    with pytest.raises(FrameNotFound):
        tool_checks(planar, wavy(planar, 0), to.tool_speed("nothing", linear=1.0))


def test_a_planned_motion_keeps_the_tool_slow() -> None:
    arm = to.load("planar2")
    problem = to.Problem(
        scene=to.Scene(arm),
        start={"joint1": 0.0, "joint2": 0.5},
        goal=to.joint_positions({"joint1": 1.2, "joint2": -0.4}),
        tool_speed=to.tool_speed("tool", linear=0.2),
    )
    free, slow = to.plan(replace(problem, tool_speed=())).require(), to.plan(problem).require()
    assert slow.trajectory.duration > 1.5 * free.trajectory.duration
    (check,) = (check for check in slow.certificate.checks if check.name == "path: tool speed")
    assert 0.99 * 0.2 < (check.value or 0.0) <= 0.2
    assert "no faster    tool at most" in str(problem)
    mutated = to.Trajectory(
        slow.trajectory.joint_names, slow.trajectory.times * 0.99, slow.trajectory.positions
    )
    refused = verify(problem.reduced, mutated, goals=(), tool_speeds=problem.tool_speeds)
    assert "path: tool speed" in {check.name for check in refused.failed}


def test_a_steady_speed_may_not_sag_nor_be_all_ramp(planar: ReducedModel) -> None:
    """The first joint alone turns: the tip's speed is its rate times 1.1 m."""
    limited = to.tool_speed("tip", linear=1.1 * 0.5, steady=0.1)

    def judged(times: list[float], rates: list[float]) -> Check:
        at, speed = np.array(times), np.array(rates)
        turned = np.concatenate(([0.0], np.cumsum(np.diff(at) * (speed[1:] + speed[:-1]) / 2)))
        knots = np.column_stack((turned, np.zeros(len(at))))
        motion = Trajectory(planar.joint_names, at, knots, np.column_stack((speed, 0.0 * speed)))
        certificate = verify(planar, motion, goals=(), tool_speeds=(limited,))
        (check,) = (check for check in certificate.checks if check.name == "path: steady speed")
        assert check.evidence is Evidence.PROVEN or not check.holds
        return check

    top = 0.5 * 1.1 / tip_radius(planar)
    assert judged([0.0, 0.1, 1.0, 1.1], [0.0, top, top, 0.0]).holds
    short = judged([0.0, 0.1, 0.5, 0.5001, 0.5002, 1.0, 1.1], [0.0, top, top, 0.7 * top, top, top, 0.0])
    assert not short.holds and short.time == pytest.approx(0.5001, abs=1e-4), "shorter than the samples"
    sagging = judged([0.0, 0.1, 0.5, 1.0, 1.1], [0.0, top, 0.7 * top, top, 0.0])
    assert not sagging.holds and sagging.time == pytest.approx(0.5, abs=0.01)
    assert (
        "it is slowest at 0.50 s, where the way turns by 1" in sagging.detail and "`blend`" in sagging.detail
    )
    slow = judged([0.0, 0.1, 1.0, 1.1], [0.0, 0.5 * top, 0.5 * top, 0.0])
    assert not slow.holds and "0% of the way" in slow.detail
    ramps = judged([0.0, 1.0, 1.05, 2.05], [0.0, top, top, 0.0])
    assert not ramps.holds


def tip_radius(model: ReducedModel) -> float:
    """Return how far the tip is from the first joint's axis with the arm stretched [m]."""
    return float(
        np.linalg.norm(model.scene.placement_of("tip", model.all_positions(np.zeros(2))).translation)
    )


def test_a_steady_speed_is_a_share_of_a_limit() -> None:
    for wrong in (0.0, 1.0, -0.1):
        with pytest.raises(ProblemError, match="steady is a drop"):
            to.tool_speed("tip", linear=1.0, steady=wrong)
    with pytest.raises(ProblemError, match="steady is a drop"):
        to.tool_speed("tip", angular=1.0, steady=0.1)
    assert "steady within 10%" in repr(to.tool_speed("tip", linear=1.0, steady=0.1))
