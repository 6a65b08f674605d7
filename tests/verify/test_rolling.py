"""Bases on two driven wheels: planned without sliding sideways, and judged by what their wheels would do."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.robot.test_moving_base import NAMES, Made, cart, plane
from trajopt.optimise.methods import method_named
from trajopt.optimise.terms.joint_positions import Rolling
from trajopt.planning.status import Status
from trajopt.problem.motion import Motion
from trajopt.robot.bases import Drive
from trajopt.values.errors import ModelError, ProblemError
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Check, CheckKind, Evidence, verify

__all__ = ["cart"]
Cart = Callable[..., to.Robot]


@pytest.fixture
def driven(cart: Made) -> Cart:
    """Load the cart as one on two driven wheels."""
    return lambda **changes: cart(base=plane(drive=Drive.DIFFERENTIAL, **changes))


def asked(robot: to.Robot, goal: to.Requirement, **changes: Any) -> to.Problem:
    fields: dict[str, Any] = {"scene": to.Scene(robot), "group": "all_of_it", "start": {}, "goal": goal}
    return to.Problem(**{**fields, **changes})


def at(x: float, y: float, yaw: float, **arm: float) -> to.Requirement:
    return to.joint_positions(
        dict(zip(NAMES, (x, y, yaw), strict=True)) | {"shoulder": 0.0, "elbow": 0.0, **arm}
    )


def rolled(certificate: Certificate) -> Check:
    (check,) = (item for item in certificate.checks if item.kind is CheckKind.ROLLING)
    return check


def strays(trajectory: Trajectory) -> float:
    """Drive the wheels as planned by many small arcs, and measure how far beside the plan they get."""
    times = np.linspace(0.0, trajectory.duration, 20_001)
    middle, step = (times[1:] + times[:-1]) / 2.0, np.diff(times)
    (vx, vy, _), yaw = trajectory(middle, 1)[:, :3].T, trajectory(middle)[:, 2]
    forward = vx * np.cos(yaw) + vy * np.sin(yaw)
    driven = np.cumsum(forward * step * np.stack((np.cos(yaw), np.sin(yaw))), axis=1).T
    planned = trajectory(times[1:])[:, :2] - trajectory(np.zeros(1))[:, :2]
    return float(np.linalg.norm(planned - driven, axis=1).max())


@pytest.mark.parametrize(
    ("x", "y", "yaw"), [(2.5, 1.5, 0.0), (0.0, 0.7, 0.0), (-1.0, 1.0, 1.6), (0.0, 0.0, 2.0), (-2.0, 0.0, 0.0)]
)
def test_a_differential_base_rolls_wherever_it_goes(driven: Cart, x: float, y: float, yaw: float) -> None:
    """An S, to the side, backwards around a bend, a turn on the spot, straight back; the arm moves along."""
    plan = to.plan(asked(driven(), at(x, y, yaw, shoulder=0.5, elbow=1.0))).require()
    check = rolled(plan.certificate)
    assert check.holds and check.evidence is Evidence.PROVEN and check.bound == 0.01
    independent = strays(plan.trajectory)
    assert check.value == pytest.approx(independent, abs=1e-5) and independent <= 0.01


def test_a_pose_out_of_reach_around_a_post(driven: Cart) -> None:
    robot = driven()
    scene = to.Scene(robot).add("post", to.Cylinder(0.2, 1.0), to.placement((1.6, 0.0, 0.5)))
    goal = to.frame_placement("tool", to.placement((3.2, 0.1, 0.4)), rotation_tolerance=0.1)
    plan = to.plan(asked(robot, goal, scene=scene, knots=24)).require()
    assert rolled(plan.certificate).holds and strays(plan.trajectory) <= 0.01
    finer = to.plan(asked(robot, goal, scene=scene)).require()
    assert strays(finer.trajectory) < 0.6 * strays(plan.trajectory), "more knots roll better"
    assert len(finer.path.knots) == 48 and asked(robot, goal, group="arm").knots == 24


def test_a_slide_to_the_side_is_refused_however_slow(driven: Cart, cart: Made) -> None:
    """A slip speed would pass where the motion is slow enough; how far the wheels stray does not."""
    q = np.zeros((2, 5))
    q[1, 1] = 0.012
    for duration in (1.0, 1000.0):
        for rates in (None, np.zeros((2, 5))):
            motion = Trajectory(driven().group("all_of_it").joints, np.array((0.0, duration)), q, rates)
            for robot, holds in ((driven(), False), (driven(drift=0.02), True), (cart(base=plane()), None)):
                problem = asked(robot, at(0.0, 0.012, 0.0))
                certificate = verify(problem.reduced, motion, goals=problem.goals)
                if holds is None:
                    assert not [item for item in certificate.checks if item.kind is CheckKind.ROLLING]
                    continue
                check = rolled(certificate)
                assert check.holds is holds and check.value == pytest.approx(0.012, abs=2e-4)
                assert check.evidence is (Evidence.PROVEN if holds else Evidence.SAMPLED)


def test_the_judges_bound_holds_for_simulated_wheels(driven: Cart) -> None:
    """Random motions, most of them slides: the value is that of driving them by small arcs."""
    rng = np.random.default_rng(4)
    names = driven().group("all_of_it").joints
    for _ in range(20):
        count = int(rng.integers(2, 6))
        times = np.concatenate(((0.0,), np.cumsum(rng.uniform(0.2, 2.0, count))))
        shape = (count + 1, 5)
        rates = [rng.normal(size=shape) for _ in range(int(rng.integers(0, 3)))]
        motion = Trajectory(names, times, rng.normal(size=shape), *rates)
        problem = asked(driven(drift=float(rng.uniform(0.5, 3.0))), at(0.0, 0.0, 0.0))
        check = rolled(verify(problem.reduced, motion, goals=problem.goals))
        truth = strays(motion)
        assert check.bound is not None and check.value == pytest.approx(truth, abs=0.011 * check.bound)
        assert check.holds is (truth <= check.bound) or abs(truth - check.bound) < 1e-3


def test_the_term_has_the_exact_derivative_and_holds_on_arcs(driven: Cart) -> None:
    rng = np.random.default_rng(5)
    term, knots = Rolling((0, 1, 2)), rng.normal(size=(6, 5))

    def value(x: np.ndarray) -> np.ndarray:
        sampling = np.ones(len(x) - 1, dtype=np.int64)
        return term.linearise(Motion.through(x, sampling, None)).value  # pyright: ignore

    rows = term.linearise(Motion.through(knots, np.ones(5, dtype=np.int64), None))  # pyright: ignore
    for k in range(6):
        for j in range(5):
            step = np.zeros_like(knots)
            step[k, j] = 1e-6
            slope = (value(knots + step) - value(knots - step)) / 2e-6
            own = np.where(rows.knots == k, rows.jacobian[:, :, j], 0.0).sum(axis=1)
            assert slope == pytest.approx(own, abs=1e-8)
    angle = np.linspace(0.0, 2.0, 6)
    arc = np.zeros((6, 5))
    arc[:, 0], arc[:, 1], arc[:, 2] = 0.7 * np.sin(angle), 0.7 * (1.0 - np.cos(angle)), angle
    assert np.abs(value(arc)).max() < 1e-12


def test_the_arm_alone_knows_of_no_wheels(driven: Cart) -> None:
    plan = to.plan(
        asked(driven(), to.joint_positions({"shoulder": 1.0, "elbow": 0.5}), group="arm")
    ).require()
    assert not [item for item in plan.certificate.checks if item.kind is CheckKind.ROLLING]


def test_methods_of_casadi_object_by_name(driven: Cart) -> None:
    result = to.plan(asked(driven(), at(1.0, 0.0, 0.0)), method=method_named("ipopt"))
    assert result.status is Status.METHOD_CANNOT and "'rolling'" in result.reason


def test_part_of_a_rolling_base_is_not_a_group(cart: Made) -> None:
    from tests.robot.test_moving_base import SRDF

    srdf = SRDF.replace("</robot>", f'<group name="x"><joint name="{NAMES[0]}"/></group></robot>')
    assert cart(srdf=srdf, base=plane()).group("x").joints == NAMES[:1]
    with pytest.raises(ModelError, match=r"group 'x'.*need all of them"):
        cart(srdf=srdf, base=plane(drive=Drive.DIFFERENTIAL))
    with pytest.raises(ProblemError, match="drift must be positive"):
        plane(drift=0.0)
