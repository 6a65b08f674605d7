"""Limits of mimic joints: kept by plans, refused by the judge, and named where they bind."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.robot.test_mimics import Stated, planar
from tests.verify.arms import quintic, reduced
from trajopt.optimise.kinematics import random_configurations
from trajopt.robot.joints import JointLimits, LimitKind
from trajopt.robot.loading.mimics import followed_limits
from trajopt.robot.loading.urdf import Mimic
from trajopt.values.errors import MimicOutOfRange, ProblemError
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Examination, examine, verify

WIDE = 'lower="-3" upper="3" velocity="2" effort="500"'
CHAIN: Stated = {"m1": ("j1", -2.0, 0.1), "m2": ("m1", 1.5, 0.0)}
"""m1 = -2 j1 + 0.1 and m2 = -3 j1 + 0.15."""


def arm(folder: Path, last: str = WIDE, *, stated: Stated = CHAIN, yaml: str = "") -> to.Robot:
    """The chain, with the limits of its last joint, and a `joint_limits.yaml` beside it."""
    robot = planar(
        folder, stated, limits={"j1": WIDE, "m1": 'lower="-9" upper="9" velocity="99" effort="1"', "m2": last}
    )
    if not yaml:
        return robot
    (folder / "limits.yaml").write_text(f"joint_limits: {yaml}")
    return to.Robot.from_urdf(folder / "planar.urdf", limits=folder / "limits.yaml")


def failed(certificate: Certificate) -> dict[str, str]:
    """The joint of each check that does not hold, by quantity."""
    return {check.name: check.subject for check in certificate.failed}


def solved(robot: to.Robot, goal: float) -> Trajectory:
    problem = to.Problem(scene=to.Scene(robot), start={"j1": 0.0}, goal=to.joint_positions({"j1": goal}))
    result = to.plan(problem)
    assert result.status is to.Status.SOLVED, result.reason
    assert result.trajectory is not None
    return result.trajectory


@pytest.mark.parametrize(
    ("last", "name"),
    [
        ('lower="-1" upper="1" velocity="99" effort="1"', "joint position"),
        ('lower="-9" upper="9" velocity="0.9" effort="1"', "velocity"),
    ],
)
def test_a_hand_made_motion_that_takes_a_mimic_joint_beyond_its_limits_is_refused(
    tmp_path: Path, last: str, name: str
) -> None:
    model = reduced(to.Scene(arm(tmp_path, last)), [0.0])
    certificate = verify(model, quintic(model, [[0.0], [0.5]], 3.0), goals=())
    assert failed(certificate) == {name: "m2"}
    assert "m2, which follows j1, reaches" in certificate.failed[0].detail
    # m2 = -3 j1 + 0.15, and the fastest of a quintic is 15/8 of its mean velocity.
    expected = {"joint position": -1.35, "velocity": -3.0 * 0.5 / 3.0 * 15.0 / 8.0}[name]
    assert certificate.failed[0].value == pytest.approx(expected)


@pytest.mark.parametrize(
    ("yaml", "name"),
    [
        ("{m2: {has_acceleration_limits: true, max_acceleration: 0.9}}", "acceleration"),
        ("{m2: {has_jerk_limits: true, max_jerk: 3.0}}", "jerk"),
    ],
)
def test_accelerations_and_jerks_of_mimic_joints_are_judged(tmp_path: Path, yaml: str, name: str) -> None:
    free = 'lower="-9" upper="9" velocity="99" effort="1"'
    model = reduced(to.Scene(arm(tmp_path, free, yaml=yaml)), [0.0])
    assert failed(verify(model, quintic(model, [[0.0], [0.5]], 3.0), goals=()))[name] == "m2"
    unlimited = reduced(to.Scene(arm(tmp_path, free)), [0.0])
    assert verify(unlimited, quintic(unlimited, [[0.0], [0.5]], 3.0), goals=()).verified


def test_unstated_limits_of_a_mimic_joint_do_not_bind(tmp_path: Path) -> None:
    robot = arm(tmp_path, 'lower="-9" upper="9" velocity="0" effort="1"')
    place = robot.joint_names.index("m2")
    assert robot.limits.velocity[place] == robot.limits.acceleration[place] == np.inf
    assert not any(note.startswith("m2") for note in robot.limits.defaulted)


def test_plans_keep_velocity_and_acceleration_of_mimic_joints(tmp_path: Path) -> None:
    yaml = "{m2: {has_acceleration_limits: true, max_acceleration: 1.2}}"
    slow = solved(arm(tmp_path, 'lower="-9" upper="9" velocity="0.6" effort="1"', yaml=yaml), 0.5)
    times = np.linspace(0.0, slow.duration, 2000)
    assert np.abs(3.0 * slow(times, 1)).max() <= 0.6 * (1.0 + 1e-6)
    assert np.abs(3.0 * slow(times, 2)).max() <= 1.2 * (1.0 + 1e-6)
    assert np.abs(3.0 * slow(times, 1)).max() > 0.5, "the mimic joint is what binds"


def test_a_goal_beyond_the_range_of_a_mimic_joint_names_it(tmp_path: Path) -> None:
    robot = arm(tmp_path, 'lower="-1" upper="1" velocity="9" effort="1"')
    problem = to.Problem(scene=to.Scene(robot), start={"j1": 0.0}, goal=to.joint_positions({"j1": 0.5}))
    result = to.plan(problem)
    assert result.status is to.Status.GOAL_OUT_OF_LIMITS
    assert (
        "m2, which follows j1, at -77.35 deg (-1.3500 rad) is 20.05 deg outside [-57.3, 57.3] deg"
        in result.reason
    )
    goal = to.joint_positions({"j1": 0.5}, tolerance=0.01)
    again = to.plan(to.Problem(scene=to.Scene(robot), start={"j1": 0.0}, goal=goal))
    assert again.status is to.Status.GOAL_OUT_OF_LIMITS and "m2, which follows j1" in again.reason
    assert solved(robot, 0.38).positions[-1] == pytest.approx(0.38)


def test_a_start_beyond_the_range_of_a_mimic_joint_names_it(tmp_path: Path) -> None:
    robot = arm(tmp_path, 'lower="-1" upper="1" velocity="9" effort="1"')
    problem = to.Problem(scene=to.Scene(robot), start={"j1": 0.5}, goal=to.joint_positions({"j1": 0.0}))
    result = to.plan(problem)
    assert result.status is to.Status.START_OUT_OF_LIMITS
    assert (
        "m2, which follows j1, at -77.35 deg (-1.3500 rad) is 20.05 deg outside [-57.3, 57.3] deg"
        in result.reason
    )
    seen: Examination = examine(problem.reduced, np.array((0.5,)))
    assert [(item.joint, item.follows) for item in seen.out_of_limits] == [("m2", "j1")]


def test_refuses_a_start_velocity_beyond_the_limit_of_a_mimic_joint(tmp_path: Path) -> None:
    robot = arm(tmp_path, 'lower="-9" upper="9" velocity="0.6" effort="1"')
    with pytest.raises(
        ProblemError, match=r"its velocity limit is 11\.46 deg/s \(the limit of m2, which follows j1\)"
    ):
        to.Problem(
            scene=to.Scene(robot),
            start={"j1": 0.0},
            goal=to.joint_positions({"j1": 0.5}),
            start_velocity={"j1": 0.3},
        )


@pytest.mark.parametrize("multiplier", [0.0, 1.0, -1.0])
def test_a_range_that_the_leader_never_reaches_is_refused_by_name(tmp_path: Path, multiplier: float) -> None:
    stated: Stated = {"m1": ("j1", multiplier, 0.0), "m2": ("m1", 1.0, 0.0)}
    robot = arm(tmp_path, 'lower="4" upper="5" velocity="9" effort="1"', stated=stated)
    with pytest.raises(MimicOutOfRange, match="m2, which follows j1, ") as caught:
        reduced(to.Scene(robot), [0.0])
    assert (caught.value.joint, caught.value.source) == ("m2", "j1")


def test_a_mimic_joint_that_never_moves_binds_nothing(tmp_path: Path) -> None:
    stated: Stated = {"m1": ("j1", 0.0, 0.3), "m2": ("m1", 1.0, 0.0)}
    robot = arm(tmp_path, 'lower="0.2" upper="0.4" velocity="0.001" effort="1"', stated=stated)
    model = reduced(to.Scene(robot), [0.0])
    assert (model.limits.lower[0], model.limits.upper[0], model.limits.velocity[0]) == (-3.0, 3.0, 2.0)
    assert solved(robot, 1.0).positions[-1] == pytest.approx(1.0)


def test_samples_keep_mimic_joints_within_their_ranges(tmp_path: Path) -> None:
    model = reduced(to.Scene(arm(tmp_path, 'lower="-1" upper="1" velocity="9" effort="1"')), [0.0])
    drawn = random_configurations(model, 200, rng=np.random.default_rng(1)).positions
    last = -3.0 * np.asarray(drawn)[:, 0] + 0.15
    assert np.abs(last).max() <= 1.0 and np.ptp(last) > 1.5


NUMBERS = st.floats(-3.0, 3.0).map(lambda x: round(x, 2))


@settings(deadline=None)
@given(multiplier=NUMBERS, offset=NUMBERS, ends=st.tuples(NUMBERS, NUMBERS), position=NUMBERS)
def test_the_range_of_the_leader_is_where_all_are_in_their_ranges(
    multiplier: float, offset: float, ends: tuple[float, float], position: float
) -> None:
    lower, upper = min(ends), max(ends)
    some = np.array((1.0, 2.0))
    limits = JointLimits(("a", "b"), np.array((-2.0, lower)), np.array((2.0, upper)), some, some, some, some)
    stands = multiplier * position + offset
    inside = -2.0 <= position <= 2.0 and lower <= stands <= upper
    near = min(abs(stands - lower), abs(stands - upper), abs(abs(position) - 2.0)) < 1e-6
    try:
        found = followed_limits(limits, ("a",), {"b": Mimic("a", multiplier, offset)})
    except MimicOutOfRange:
        assert not inside or near
        return
    allowed = bool(found.lower[0] <= position <= found.upper[0])
    assert allowed == inside or near
    size = abs(multiplier)
    assert found.velocity[0] == (min(1.0, 2.0 / size) if size else 1.0)
    assert (("a", LimitKind.VELOCITY) in found.binding) == (size > 2.0)
