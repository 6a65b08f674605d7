"""Limits of joints, torques and the two ends: each passes when it should and fails when it should."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from tests.verify.arms import joint, link, mixed_arm, planar_arm, quintic, reduced, robot, wavy
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.shapes.shapes import Box
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Check, Evidence, VerifyOptions, verify
from trajopt.verify.checks.torques import inverse_dynamics
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion


@pytest.fixture
def model(tmp_path: Path) -> ReducedModel:
    return reduced(Scene(planar_arm(tmp_path, axis="0 1 0")), [0.1, 0.2])


def limits_of(model: ReducedModel, **changes: list[float]) -> JointLimits:
    return replace(model.limits, **{name: readonly(np.array(value)) for name, value in changes.items()})


def checks(certificate: Certificate, name: str) -> list[Check]:
    return [check for check in certificate.checks if check.name == name]


def leg(model: ReducedModel) -> Trajectory:
    """One minimum-jerk leg of 1 rad and -0.5 rad in one second."""
    return quintic(model, [[0.1, 0.2], [1.1, -0.3]], 1.0)


def test_a_good_motion_passes(model: ReducedModel) -> None:
    certificate = verify(model, leg(model), goals=())
    assert certificate.verified, str(certificate)
    found = {check.name for check in certificate.checks}
    assert found >= {"clearance", "start", "start at rest", "end at rest"}
    assert found >= {"joint position", "velocity", "acceleration", "torque"}


@pytest.mark.parametrize(
    ("name", "field", "order", "peak"),
    [
        ("velocity", "velocity", 1, 15.0 / 8.0),
        ("acceleration", "acceleration", 2, 10.0 / np.sqrt(3.0)),
        ("jerk", "jerk", 3, 60.0),
    ],
)
def test_peaks_of_a_minimum_jerk_leg_are_exact(
    model: ReducedModel, name: str, field: str, order: int, peak: float
) -> None:
    close = verify(model, leg(model), goals=(), limits=limits_of(model, **{field: [peak, peak]}))
    (check,) = checks(close, name)
    assert abs(check.value or 0.0) == pytest.approx(peak, rel=1e-7)
    assert check.holds
    assert check.evidence is Evidence.PROVEN
    assert check.subject == "shoulder"
    assert check.unit == f"rad/{('', 's', 's^2', 's^3')[order]}"
    below = [peak * (1 - 3e-6), peak]
    tight = verify(model, leg(model), goals=(), limits=limits_of(model, **{field: below}))
    (check,) = checks(tight, name)
    assert not check.holds
    assert not tight.verified
    assert check.slack == pytest.approx(-peak * 3e-6, rel=1e-3)


def sampled(model: ReducedModel, function: Callable[[Floats, int], Floats]) -> Trajectory:
    """A quintic trajectory of 41 points whose shoulder follows a function of time with its derivatives."""
    times = np.linspace(0.0, 1.0, 41)
    rows = [np.zeros((41, 2)) for _ in range(3)]
    for order, row in enumerate(rows):
        row[:, 0] = function(times, order)
    return Trajectory(model.joint_names, times, rows[0] + model.start_positions, rows[1], rows[2])


def rest_to_rest(t: Floats, order: int) -> Floats:
    """t^4 (1 - t)^4 and its derivatives: its jerk vanishes at the ends, its acceleration too."""
    polynomial = np.polynomial.Polynomial((0, 0, 0, 0, 1, -4, 6, -4, 1))
    return polynomial.deriv(order)(t) if order else polynomial(t)


def test_jerk_is_limited_at_all_times(model: ReducedModel) -> None:
    motion = sampled(model, rest_to_rest)
    peak = float(np.abs(motion(np.linspace(0.0, 1.0, 100_001), 3)).max())
    (check,) = checks(
        verify(model, motion, goals=(), limits=limits_of(model, jerk=[peak * 1.0001, 1.0])), "jerk"
    )
    assert check.holds and check.required and check.evidence is Evidence.PROVEN
    assert abs(check.value or 0.0) == pytest.approx(peak, rel=1e-4)
    tight = verify(model, motion, goals=(), limits=limits_of(model, jerk=[peak * 0.999, 1.0]))
    assert [check.name for check in tight.failed] == ["jerk"]
    assert tight.failed[0].subject == "shoulder"


def test_jumps_of_acceleration_break_any_jerk_limit(model: ReducedModel) -> None:
    motion = sampled(model, rest_to_rest)
    assert motion.accelerations is not None
    high = limits_of(model, jerk=[1e9, np.inf])
    assert verify(model, motion, goals=(), limits=high).verified
    for row in (0, -1):
        pushed = np.array(motion.accelerations)
        pushed[row, 0] += 1e-3
        mutated = replace(motion, accelerations=pushed)
        (check,) = verify(model, mutated, goals=(), limits=high).failed
        assert (check.name, check.subject) == ("jerk", "shoulder")
        assert "jumps by 0.0573 deg/s^2" in check.detail
    cubic = Trajectory(motion.joint_names, motion.times, motion.positions, motion.velocities)
    assert [check.name for check in verify(model, cubic, goals=(), limits=high).failed] == ["jerk"]


def test_positions_between_the_points_count(model: ReducedModel) -> None:
    overshoot = Trajectory(
        model.joint_names,
        np.array((0.0, 1.0, 2.0)),
        np.array(((0.1, 0.2), (0.9, 0.2), (0.1, 0.2))),
        np.array(((0.0, 0.0), (3.0, 0.0), (0.0, 0.0))),
    )
    peak = overshoot(np.linspace(0.0, 2.0, 200_001))[:, 0].max()
    assert peak > 0.95
    holds = verify(model, overshoot, goals=(), limits=limits_of(model, upper=[peak + 1e-5, 3.0]))
    assert checks(holds, "joint position")[0].holds
    fails = verify(model, overshoot, goals=(), limits=limits_of(model, upper=[peak - 1e-5, 3.0]))
    (check,) = checks(fails, "joint position")
    assert not check.holds
    assert check.value == pytest.approx(peak, abs=1e-7)
    assert overshoot(check.time or 0.0)[0] == pytest.approx(peak, abs=1e-7)
    low = verify(model, overshoot, goals=(), limits=limits_of(model, lower=[-3.0, 0.25]))
    assert checks(low, "joint position")[0].bound == 0.25


def test_every_joint_beyond_its_limit_is_listed(model: ReducedModel) -> None:
    certificate = verify(model, leg(model), goals=(), limits=limits_of(model, velocity=[1.0, 0.5]))
    assert [check.subject for check in checks(certificate, "velocity")] == ["shoulder", "elbow"]
    assert len(certificate.failed) == 2


def test_joints_without_limits(model: ReducedModel) -> None:
    unlimited = limits_of(model, lower=[-np.inf] * 2, upper=[np.inf] * 2)
    (check,) = checks(verify(model, leg(model), goals=(), limits=unlimited), "joint position")
    assert check.holds
    assert check.bound is None


def test_accelerations_of_a_cubic_are_judged_with_their_jumps(model: ReducedModel) -> None:
    cubic = Trajectory(
        model.joint_names,
        np.array((0.0, 1.0)),
        np.array(((0.1, 0.2), (1.1, 0.2))),
        np.zeros((2, 2)),
    )
    certificate = verify(model, cubic, goals=(), limits=limits_of(model, acceleration=[6.0, 6.0]))
    (check,) = checks(certificate, "acceleration")
    assert abs(check.value or 0.0) == pytest.approx(6.0)
    assert certificate.verified
    assert not verify(model, cubic, goals=(), limits=limits_of(model, acceleration=[5.99, 6.0])).verified


def test_a_linear_trajectory_states_speeds_only(model: ReducedModel) -> None:
    straight = Trajectory(
        model.joint_names, np.array((0.0, 0.5, 1.5)), np.array(((0.1, 0.2), (0.6, 0.2), (0.7, 0.2)))
    )
    certificate = verify(model, straight, goals=(), limits=limits_of(model, velocity=[1.0, 1.0]))
    assert certificate.verified
    names = {check.name for check in certificate.checks}
    assert not names & {"acceleration", "torque", "start at rest"}
    assert any("linear" in note for note in certificate.notes)
    assert not verify(model, straight, goals=(), limits=limits_of(model, velocity=[0.99, 1.0])).verified


def test_the_start_must_be_the_robots(model: ReducedModel) -> None:
    elsewhere = quintic(model, [[0.1, 0.21], [1.0, 0.0]], 1.0)
    certificate = verify(model, elsewhere, goals=())
    assert [check.name for check in certificate.failed] == ["start"]
    assert certificate.failed[0].subject == "elbow"
    assert certificate.failed[0].value == pytest.approx(0.01)


@pytest.mark.parametrize(("row", "name"), [(0, "start at rest"), (-1, "end at rest")])
def test_both_ends_are_at_rest(model: ReducedModel, row: int, name: str) -> None:
    velocities = np.zeros((2, 2))
    velocities[row, 1] = 1e-3
    moving = Trajectory(
        model.joint_names, np.array((0.0, 1.0)), np.array(((0.1, 0.2), (0.4, 0.2))), velocities
    )
    assert [check.name for check in verify(model, moving, goals=()).failed] == [name]


def gravity_torques(shoulder: float, elbow: float) -> tuple[float, float]:
    """Rods of 1 kg with centres at 0.25 m, and 0.01 kg at the tip, about y in gravity along -z."""
    g = 9.81
    far = g * (1.0 * 0.25 + 0.01 * 0.5) * np.cos(shoulder + elbow)
    near = g * (1.0 * 0.25 + 1.01 * 0.5) * np.cos(shoulder)
    return -(near + far), -far


def test_torques_of_standing_still_are_those_of_gravity(model: ReducedModel) -> None:
    still = quintic(model, [[0.1, 0.2], [0.1, 0.2]], 1.0)
    motion = JudgedMotion(model, still, kinematics=Kinematics(model), options=VerifyOptions())
    times, torques = inverse_dynamics(motion)
    expected = gravity_torques(0.1, 0.2)
    np.testing.assert_allclose(torques, np.tile(expected, (len(times), 1)), atol=1e-9)
    holds = limits_of(model, effort=[abs(expected[0]) + 1e-4, np.inf])
    (check,) = checks(verify(model, still, goals=(), limits=holds), "torque")
    assert check.holds
    assert check.evidence is Evidence.SAMPLED
    assert check.unit == "Nm"
    breaks = limits_of(model, effort=[abs(expected[0]) - 1e-4, abs(expected[1]) - 1e-4])
    assert len(checks(verify(model, still, goals=(), limits=breaks), "torque")) == 2


def test_torques_of_a_motion_do_its_work(model: ReducedModel) -> None:
    """Power integrates to the change of potential energy between two states of rest."""
    motion = JudgedMotion(
        model, leg(model), kinematics=Kinematics(model), options=VerifyOptions(sample_step=1e-3)
    )
    times, torques = inverse_dynamics(motion)
    work = np.trapezoid((torques * leg(model)(times, 1)).sum(axis=1), times)
    data = model.model.createData()
    heights = [pin.computePotentialEnergy(model.model, data, q) for q in leg(model).positions]
    assert work == pytest.approx(heights[1] - heights[0], rel=1e-5)


def test_a_mimicking_joint_burdens_the_joint_it_follows(tmp_path: Path) -> None:
    model = reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])
    trajectory = wavy(model, 3)
    motion = JudgedMotion(
        model, trajectory, kinematics=Kinematics(model), options=VerifyOptions(sample_step=1e-3)
    )
    times, torques = inverse_dynamics(motion)
    energy = [_energy(model, trajectory(t), trajectory(t, 1)) for t in (0.0, 1.9)]
    power = (torques * trajectory(times, 1)).sum(axis=1)
    before = times <= 1.9
    work = np.trapezoid(power[before], times[before])
    assert work == pytest.approx(energy[1] - energy[0], rel=1e-4, abs=1e-3)


def _energy(model: ReducedModel, positions: Floats, velocities: Floats) -> float:
    data = model.model.createData()
    q = model.configuration(positions)
    kinetic = pin.computeKineticEnergy(model.model, data, q, model.mimic_matrix @ velocities)
    return float(kinetic + pin.computePotentialEnergy(model.model, data, q))


def test_units_of_a_slide(tmp_path: Path) -> None:
    slide = robot(tmp_path, link("base"), link("hand"), joint("z", "base", "hand", kind="prismatic"))
    model = reduced(Scene(slide), [0.0])
    certificate = verify(model, quintic(model, [[0.0], [0.1]], 1.0), goals=())
    units = {check.name: check.unit for check in certificate.checks}
    assert units["joint position"] == "m"
    assert units["velocity"] == "m/s"
    assert units["torque"] == "N"
    assert units["start"] == "m"


def test_massless_attached_objects_are_noted(tmp_path: Path) -> None:
    scene = Scene(planar_arm(tmp_path)).add(
        "load", Box(0.1, 0.1, 0.1), frame="tip", touch_links=["tip", "lower", "upper"]
    )
    model = reduced(scene, [0.1, 0.2])
    assert any("without the mass of load" in note for note in verify(model, leg(model), goals=()).notes)


def test_another_robots_trajectory_is_refused(model: ReducedModel) -> None:
    strange = Trajectory(("elbow", "shoulder"), np.array((0.0, 1.0)), np.zeros((2, 2)))
    with pytest.raises(ProblemError, match="elbow, shoulder"):
        verify(model, strange, goals=())
    with pytest.raises(ShapeError):
        Trajectory(("elbow",), np.array((0.0, 1.0)), np.zeros((2, 2)))
    with pytest.raises(ProblemError, match="resolution"):
        VerifyOptions(resolution=0.0)
