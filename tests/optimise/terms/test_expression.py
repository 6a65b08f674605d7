"""Residuals as CasADi expressions: the kinematics are Pinocchio's, derivatives right, plans hold them."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query
from trajopt.optimise.terms import constraint
from trajopt.optimise.terms.frames import relative_frame
from trajopt.optimise.terms.symbolic import SymbolicKinematics
from trajopt.optimise.terms.user_functions import Expression
from trajopt.problem.motion import Motion
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.errors import FrameNotFound, ProblemError, ShapeError


@pytest.fixture
def reduced(tmp_path: Path) -> ReducedModel:
    robot = odd_arm(tmp_path)
    held = to.placement((0.1, 0.02, 0.05), rpy=(0.1, 0.2, 0.3))
    scene = to.Scene(robot).add(
        "held", to.Box(0.1, 0.1, 0.1), held, frame="tip", touch_links=["tip", "finger"]
    )
    return reduce_model(scene, "all", robot.positions())


def motion(reduced: ReducedModel, count: int) -> Motion:
    lower, upper = np.maximum(reduced.limits.lower, -3.0), np.minimum(reduced.limits.upper, 3.0)
    knots = np.random.default_rng(4).uniform(lower, upper, (count, len(lower)))
    return Motion.through(knots, np.ones(count - 1, dtype=np.int64), Query(reduced))


@pytest.mark.parametrize(("frame", "reference"), [("tip", "world"), ("held", "slide"), ("finger", "fore")])
def test_kinematics_are_those_of_the_numeric_terms(reduced: ReducedModel, frame: str, reference: str) -> None:
    offset = np.array([0.1, -0.2, 0.3])
    term = Expression("point", lambda k: k.point(frame, offset, reference))
    turn = Expression("turn", lambda k: ca.vec(k.rotation(frame, reference).T))
    at = motion(reduced, 30)
    expected = relative_frame(reduced, at, frame, reference, offset)
    rows = term.linearise(at)
    np.testing.assert_allclose(rows.value.reshape(-1, 3), expected.point, atol=1e-12)
    np.testing.assert_allclose(
        rows.jacobian.sum(axis=1).reshape(-1, 3, 4), expected.point_jacobian, atol=1e-12
    )
    np.testing.assert_allclose(turn.linearise(at).value.reshape(-1, 3, 3), expected.rotation, atol=1e-12)


def test_derivative_is_automatic(reduced: ReducedModel) -> None:
    term = Expression("odd", lambda k: ca.vertcat(ca.norm_2(k.point("tip")), ca.sin(k.q[0]) * k.q[3] ** 2))
    at, step = motion(reduced, 12), 1e-6
    rows = term.linearise(at)
    direction = np.random.default_rng(1).normal(size=at.knots.shape)
    sampling = np.ones(len(at.knots) - 1, dtype=np.int64)
    ends = [Motion.through(at.knots + sign * step * direction, sampling, at.query) for sign in (1.0, -1.0)]
    numeric = (term.linearise(ends[0]).value - term.linearise(ends[1]).value) / (2.0 * step)
    predicted = np.einsum("mkn,mkn->m", rows.jacobian, direction[rows.knots])
    np.testing.assert_allclose(predicted, numeric, atol=1e-7)


def test_a_plan_holds_it(tmp_path: Path) -> None:
    arm = odd_arm(tmp_path)
    ends = [{"pan": pan, "reach": 0.1, "elbow": 0.4, "wrist": 0.0} for pan in (-0.8, 0.8)]
    high = to.Scene(arm).placement_of("tip", arm.positions(ends[0])).translation[2]
    height = Expression("height of the tip", lambda k: k.point("tip")[2])
    problem = to.Problem(
        scene=to.Scene(arm).add("post", to.Cylinder(0.05, 0.3), to.placement((0.75, 0.0, 0.0))),
        start=ends[0],
        goal=to.joint_positions(ends[1]),
        constraints=[constraint(height, lower=high - 0.02, upper=high + 0.02)],
    )
    plan = to.plan(problem).require()
    along = plan.trajectory(np.linspace(0.0, plan.trajectory.duration, 200))
    heights = [
        problem.scene.placement_of("tip", problem.reduced.all_positions(q)).translation[2] for q in along
    ]
    assert np.abs(np.array(heights) - high).max() <= 0.02 + 1e-3
    (check,) = (
        check for check in plan.certificate.checks if "height of the tip" in check.name + check.subject
    )
    assert check.holds


def test_unknown_columns_of_the_positions_are_refused(reduced: ReducedModel) -> None:
    at = motion(reduced, 3)
    with pytest.raises(ProblemError, match="scalar or a column"):
        Expression("wide", lambda k: k.rotation("tip")).linearise(at)
    with pytest.raises(ProblemError, match="symbols of its own, other"):
        Expression("strange", lambda k: k.q[0] * ca.SX.sym("other")).linearise(at)
    kinematics = SymbolicKinematics(reduced)
    with pytest.raises(FrameNotFound, match="tipp"):
        kinematics.point("tipp")
    with pytest.raises(ShapeError):
        kinematics.point("tip", (0.0, 0.0))
