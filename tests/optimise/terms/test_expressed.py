"""Every residual that has a CasADi expression: value and derivative are those of its numeric twin."""

from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import trajopt as to
from tests.optimise.terms.test_derivatives import FACTORIES, every_term
from tests.optimise.terms.worlds import World, world
from tests.problem.requirements.kind import kinds
from trajopt.optimise import terms
from trajopt.optimise.terms.alignment import AxisAngle
from trajopt.optimise.terms.frame_placement import FramePlacementError
from trajopt.optimise.terms.joint_positions import Rolling
from trajopt.optimise.terms.positions import PointDistance, RegionCoordinates
from trajopt.optimise.terms.symbolic import Symbolic, SymbolicKinematics
from trajopt.problem.motion import Motion
from trajopt.problem.residual import Residual
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere

MEASURED = {
    *(term for kind in kinds() for term in kind.measured),
    terms.SoftClearance,
    terms.Clearance,
    terms.LostManipulability,
    terms.FunctionResidual,
    terms.Exceeded,
    terms.Velocity,
    terms.Acceleration,
    terms.Jerk,
    Rolling,
}
"""Terms without an expression: measured, a user's function, of several knots, or of their places."""


def regions() -> list[Callable[[World], Residual]]:
    where = to.placement((0.3, 0.1, 0.2), rpy=(0.1, 0.2, 0.3))
    shapes = (Box(0.2, 0.3, 0.4), Sphere(0.1), Cylinder(0.1, 0.3), Plane())

    def one(shape: Box | Sphere | Cylinder | Plane) -> Callable[[World], Residual]:
        return lambda at: RegionCoordinates(
            at.reduced, to.position_in_region("held", [(shape, where)], offset=(0.01, 0.02, 0.03))
        )

    return [one(shape) for shape in shapes]


def agree(residual: Residual, at: World, rng: np.random.Generator) -> int:
    kinematics = SymbolicKinematics(at.reduced)
    assert isinstance(residual, Symbolic)
    column = residual.expression(kinematics)
    function = ca.Function("f", [kinematics.q], [column, ca.jacobian(column, kinematics.q)])
    limits = at.reduced.limits
    lower, upper = np.maximum(limits.lower, -3.0), np.minimum(limits.upper, 3.0)
    positions = rng.uniform(lower, upper, (12, len(lower)))
    rows = residual.linearise(Motion.each(positions, at.query))
    for row, value in enumerate(rows.value):
        values, slopes = (np.array(part) for part in function(positions[int(rows.place[row])]))
        component = int(rows.component[row])
        assert values[component, 0] == pytest.approx(value, abs=1e-12)
        assert slopes[component] == pytest.approx(rows.jacobian[row, 0], abs=1e-9)
    return len(rows.value)


@pytest.mark.parametrize("term", sorted(set(every_term()) - MEASURED, key=lambda cls: cls.__name__))
def test_expression_agrees_with_the_numbers(term: type, tmp_path: Path) -> None:
    at = world(tmp_path, Sphere(0.15), to.placement((0.5, 0.1, 0.3)))
    rng = np.random.default_rng(4)
    for build in FACTORIES[term]:
        assert agree(build(at), at, rng) > 0


def test_each_kind_of_region_agrees(tmp_path: Path) -> None:
    at = world(tmp_path, Sphere(0.15), to.placement((0.5, 0.1, 0.3)))
    rng = np.random.default_rng(8)
    for build in regions():
        assert agree(build(at), at, rng) > 0


def test_members_that_are_not_the_nearest_are_within_their_bounds(tmp_path: Path) -> None:
    at = world(tmp_path, Sphere(0.15), to.placement((0.5, 0.1, 0.3)))
    (residual,) = (build(at) for build in FACTORIES[RegionCoordinates])
    assert isinstance(residual, RegionCoordinates)
    (item,) = terms.constrain(residual.required, at.reduced, terms.Window())
    kinematics = SymbolicKinematics(at.reduced)
    assert isinstance(residual, Symbolic)
    column = residual.expression(kinematics)
    function = ca.Function("f", [kinematics.q], [column])
    positions = np.random.default_rng(1).uniform(-1.0, 1.0, (20, 4))
    rows = residual.linearise(Motion.each(positions, at.query))
    for sample, position in enumerate(positions):
        rest = set(range(16)) - set(rows.component[rows.place == sample].tolist())
        values = np.array(function(position)).ravel()
        for component in rest:
            assert item.lower[component] <= values[component] <= item.upper[component]


@pytest.mark.parametrize("term", sorted(MEASURED, key=lambda cls: cls.__name__))
def test_measured_terms_have_no_expression(term: type, tmp_path: Path) -> None:
    at = world(tmp_path, Sphere(0.15), to.placement((0.5, 0.1, 0.3)))
    assert not isinstance(FACTORIES[term][0](at), Symbolic)


def test_slopes_are_finite_where_lengths_vanish(tmp_path: Path) -> None:
    """On an arc, on its axis, along a direction: roots of nothing have a slope here."""
    at = world(tmp_path, Sphere(0.15), to.placement((0.5, 0.1, 0.3)))
    kinematics = SymbolicKinematics(at.reduced)
    q = np.array((0.2, 0.1, 0.4, -0.3))
    here = at.reduced.scene.placement_of("tip", at.reduced.all_positions(q))
    residuals = (
        FramePlacementError(at.reduced, to.frame_placement("tip", here)),
        AxisAngle(
            at.reduced,
            to.axis_alignment("tip", axis=(0, 0, 1), direction=here.rotation[:, 2], tolerance=0.1),
        ),
        PointDistance(
            at.reduced, to.distance_between("tip", "base", upper=1, second_offset=here.translation)
        ),
    )
    for residual in residuals:
        assert isinstance(residual, Symbolic)
        column = residual.expression(kinematics)
        slopes = ca.Function("f", [kinematics.q], [ca.jacobian(column, kinematics.q)])(q)
        assert np.isfinite(np.array(slopes)).all()
