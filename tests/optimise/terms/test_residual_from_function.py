"""Residuals of plain functions, and requirements as costs."""

import numpy as np
import pytest

import trajopt as to
from trajopt.geometry import Query
from trajopt.optimise import terms
from trajopt.problem.motion import Motion
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError
from trajopt.verify import Evidence


@pytest.fixture(scope="module")
def planar() -> to.Robot:
    return to.load("planar2")


def problem(robot: to.Robot, **more: object) -> to.Problem:
    names = robot.groups[next(iter(robot.groups))].joints
    return to.Problem(
        scene=to.Scene(robot),
        start=dict.fromkeys(names, 0.0),
        goal=to.joint_positions({names[0]: 1.0, names[1]: 0.0}),
        **more,  # type: ignore[arg-type]
    )


def test_a_function_constraint_holds_and_is_certified(planar: to.Robot) -> None:
    """The elbow must be bent while the shoulder is half way: a bump that no built-in term has."""

    def bent(positions: Floats) -> float:
        return float(positions[1] - 0.5 * np.sin(np.pi * positions[0]) ** 2)

    item = terms.constraint(
        terms.residual_from_function("bent", bent), lower=-0.01, upper=np.inf, tolerance=2e-3
    )
    plan = to.plan(problem(planar, constraints=[item])).require()
    (found,) = [check for check in plan.certificate.checks if "bent" in check.name]
    assert found.name == "path: bent (finite differences)"
    assert found.evidence is Evidence.SAMPLED
    assert plan.trajectory(np.linspace(0.0, plan.trajectory.duration, 50))[:, 1].max() > 0.45


def test_a_given_jacobian_is_used_and_named(planar: to.Robot) -> None:
    reduced = reduce_model(to.Scene(planar), next(iter(planar.groups)), planar.positions())
    residual = terms.residual_from_function("sum", lambda q: q.sum(), jacobian=lambda q: np.ones(2) * 7.0)
    rows = residual.linearise(Motion.single(np.array((0.1, 0.2)), Query(reduced)))
    assert residual.name == "sum"
    assert rows.value == pytest.approx([0.3])
    assert rows.jacobian[0, 0] == pytest.approx([7.0, 7.0])
    nothing = residual.linearise(
        Motion.single(np.zeros(2), Query(reduced)).where(np.zeros(1, dtype=np.bool_))
    )
    assert len(nothing.value) == 0


def test_functions_of_wrong_shape_are_refused_by_name(planar: to.Robot) -> None:
    reduced = reduce_model(to.Scene(planar), next(iter(planar.groups)), planar.positions())
    motion = Motion.single(np.zeros(2), Query(reduced))
    for residual in (
        terms.residual_from_function("mine", lambda _: np.nan),
        terms.residual_from_function("mine", lambda _: np.zeros((2, 2))),
        terms.residual_from_function("mine", lambda q: q, jacobian=lambda _: np.zeros((3, 2))),
        terms.residual_from_function("mine", lambda q: np.zeros(1 + int(q[0] > 0.0))),
    ):
        with pytest.raises(ShapeError, match="mine"):
            residual.linearise(motion)
    with pytest.raises(ShapeError, match="step"):
        terms.residual_from_function("mine", lambda q: q, step=0.0)


def test_a_requirement_as_a_wish(planar: to.Robot) -> None:
    """A wish draws the motion towards it, and does not forbid to leave it."""
    group = planar.groups[next(iter(planar.groups))].joints
    wish = to.joint_positions({group[1]: 0.5}, tolerance=0.1)
    costs = (terms.Cost(terms.Velocity()), terms.Cost(terms.Acceleration()))
    plan = to.plan(problem(planar, costs=(*costs, terms.penalty(wish, 0.05)))).require()
    assert plan.path.knots[12, 1] > 0.2
    at = terms.Exceeded(wish).linearise(Motion.single(np.array((0.0, 0.0)), Query(plan.problem.reduced)))
    assert at.value == pytest.approx([0.4])
