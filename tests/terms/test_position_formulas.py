"""Residuals about points against independent formulas: held exactly where geometry says so."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.arrays import Floats
from trajopt.errors import ProblemError, ShapeError
from trajopt.model.reduced import ReducedModel, reduce_model
from trajopt.model.requirements import Requirement
from trajopt.query import Query
from trajopt.terms import constrain
from trajopt.terms.motion import Motion
from trajopt.terms.residual import WHOLE

MANY = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
positions = st.tuples(st.floats(-6, 6), st.floats(0, 0.3), st.floats(-2.5, 2.5), st.floats(-3, 3))
points = st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(0.0, 0.8))
rpys = st.tuples(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3))
OFFSET = np.array((0.01, 0.02, 0.03))


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    robot = odd_arm(tmp_path_factory.mktemp("robot"))
    return reduce_model(to.Scene(robot), "all", robot.positions())


def violation(reduced: ReducedModel, required: Requirement, at: tuple[float, ...]) -> float:
    """Largest violation of the requirement's rows, without inset."""
    motion = Motion.single(np.array(at), Query(reduced))
    worst = -np.inf
    for item in constrain(required, reduced, WHOLE, inset=0.0):
        rows = item.residual.linearise(motion)
        lower, upper = item.bounds(rows)
        worst = max(worst, float(np.maximum(lower - rows.value, rows.value - upper).max()))
    return worst


def tip(reduced: ReducedModel, at: tuple[float, ...], reference: str = "world") -> Floats:
    full = reduced.all_positions(np.array(at))
    scene = reduced.scene
    return scene.placement_of(reference, full).inverse() * (scene.placement_of("tip", full) * OFFSET)


@MANY
@given(at=positions, where=points, rpy=rpys, size=st.floats(0.05, 0.8))
def test_regions(
    reduced: ReducedModel,
    at: tuple[float, ...],
    where: tuple[float, ...],
    rpy: tuple[float, ...],
    size: float,
) -> None:
    placed = to.placement(where, rpy=rpy)
    x, y, z = placed.inverse() * tip(reduced, at, "slide")
    inside = {
        to.Box(size, 2 * size, 0.5 * size): max(abs(x) - size / 2, abs(y) - size, abs(z) - size / 4),
        to.Sphere(size): (x * x + y * y + z * z) ** 0.5 - size,
        to.Cylinder(size, 2 * size): max((x * x + y * y) ** 0.5 - size, abs(z) - size),
        to.Plane(): z,
    }
    for shape, excess in inside.items():
        need = to.position_in_region("tip", shape, placed, reference="slide", offset=OFFSET)
        assert violation(reduced, need, at) == pytest.approx(excess, abs=1e-9)
    union = to.position_in_region(
        "tip", [(s, placed) for s in inside if not isinstance(s, to.Plane)], reference="slide", offset=OFFSET
    )
    solid = min(excess for shape, excess in inside.items() if not isinstance(shape, to.Plane))
    assert (violation(reduced, union, at) <= 0.0) == (solid <= 0.0)


@MANY
@given(at=positions, through=points, direction=rpys)
def test_lines_and_planes(
    reduced: ReducedModel, at: tuple[float, ...], through: tuple[float, ...], direction: tuple[float, ...]
) -> None:
    axis = np.array(direction)
    if np.linalg.norm(axis) < 1e-3:
        return
    unit = axis / np.linalg.norm(axis)
    off = tip(reduced, at) - np.array(through)
    line = to.point_on_line("tip", through, axis, tolerance=0.01, offset=OFFSET)
    expected = float(np.linalg.norm(np.cross(off, unit))) - 0.01
    assert violation(reduced, line, at) == pytest.approx(expected, abs=1e-8)
    plane = to.point_on_plane("tip", through, axis, tolerance=0.01, offset=OFFSET)
    assert violation(reduced, plane, at) == pytest.approx(abs(float(off @ unit)) - 0.01, abs=1e-8)


@MANY
@given(at=positions, where=points, rpy=rpys)
def test_arcs(
    reduced: ReducedModel, at: tuple[float, ...], where: tuple[float, ...], rpy: tuple[float, ...]
) -> None:
    """Off a circle as densely sampled, and within the tolerance of the arc where the rows hold."""
    placed = to.placement(where, rpy=rpy)
    point = placed.inverse() * tip(reduced, at)
    for sweep in (2.0 * np.pi, 2.0):
        angle = np.linspace(0.0, sweep, 20001)
        ring = 0.3 * np.stack((np.cos(angle), np.sin(angle), 0.0 * angle), axis=1)
        expected = float(np.linalg.norm(ring - point, axis=1).min())
        within = max(0.9 * expected, 1e-3)
        need = to.point_on_arc(
            "tip", placed, radius=0.3, sweep=sweep, tolerance=min(within, 0.29), offset=OFFSET
        )
        assert violation(reduced, need, at) > 0.0 or expected < 1e-3
        if sweep > 3.0 and expected < 0.25:
            assert violation(reduced, need, at) == pytest.approx(expected - need.tolerance, abs=1e-6)


@MANY
@given(at=positions)
def test_distances(reduced: ReducedModel, at: tuple[float, ...]) -> None:
    full = reduced.all_positions(np.array(at))
    other = reduced.scene.placement_of("slide", full) * np.array((0.0, 0.1, 0.0))
    expected = float(np.linalg.norm(tip(reduced, at) - other))
    for lower, upper in ((0.0, 0.3), (0.2, 0.4), (0.5, np.inf)):
        need = to.distance_between(
            "tip", "slide", lower=lower, upper=upper, first_offset=OFFSET, second_offset=(0, 0.1, 0)
        )
        excess = max(lower - expected if lower else -np.inf, expected - upper)
        found = violation(reduced, need, at)
        assert found == pytest.approx(excess, abs=1e-9)


@MANY
@given(at=positions, where=points, behind=st.booleans())
def test_gaze(reduced: ReducedModel, at: tuple[float, ...], where: tuple[float, ...], behind: bool) -> None:
    """Angle and range by the cosine rule, in the world; a target behind still has a slope."""
    frame = reduced.scene.placement_of("tip", reduced.all_positions(np.array(at)))
    axis = np.array((1.0, 0.0, 0.2)) / np.linalg.norm((1.0, 0.0, 0.2))
    eye = frame * OFFSET
    target = eye - 0.4 * frame.rotation @ axis if behind else np.array(where)
    way = target - eye
    distance = float(np.linalg.norm(way))
    angle = float(np.arccos(np.clip(way @ frame.rotation @ axis / distance, -1.0, 1.0)))
    need = to.gaze("tip", target, angle=0.3, axis=axis, origin=OFFSET, nearest=0.2, farthest=0.5)
    excess = max(angle - 0.3, 0.2 - distance, distance - 0.5)
    assert violation(reduced, need, at) == pytest.approx(excess, abs=1e-6)
    (cone, _) = constrain(need, reduced, WHOLE, inset=0.0)
    slope = cone.residual.linearise(Motion.single(np.array(at), Query(reduced))).jacobian
    if behind:
        assert angle == pytest.approx(np.pi, abs=1e-6)
        assert np.linalg.norm(slope) > 1e-3


def test_the_program_keeps_a_share_of_the_tolerance_in_hand(reduced: ReducedModel) -> None:
    need = to.position_in_region("tip", to.Box(0.1, 0.02, 2.0))
    (item,) = constrain(need, reduced, WHOLE)
    assert item.upper[:3] == pytest.approx((0.045, 0.009, 0.995))
    (item,) = constrain(to.distance_between("tip", "slide", lower=0.2, upper=0.24), reduced, WHOLE)
    assert (item.lower[3], item.upper[3]) == pytest.approx((0.202, 0.238))


def test_bad_input_is_refused() -> None:
    for call in (
        lambda: to.position_in_region("tip", []),
        lambda: to.position_in_region("tip", [(to.Cone(0.1, 0.1), to.placement((0, 0, 0)))]),  # type: ignore[list-item]
        lambda: to.point_on_line("tip", (0, 0, 0), (0, 0, 1), tolerance=0.0),
        lambda: to.point_on_arc("tip", to.placement((0, 0, 0)), radius=0.1, tolerance=0.2),
        lambda: to.point_on_arc("tip", to.placement((0, 0, 0)), radius=0.1, tolerance=0.01, sweep=7.0),
        lambda: to.distance_between("a", "b"),
        lambda: to.gaze("a", (0, 0, 0), angle=0.3, nearest=0.5, farthest=0.4),
        lambda: to.distance_between("a", "b", lower=0.2, upper=0.1),
    ):
        with pytest.raises(ProblemError):
            call()
    with pytest.raises(ShapeError, match="angle"):
        to.gaze("tip", (0, 0, 0), angle=4.0)
    with pytest.raises(ShapeError, match="normal"):
        to.point_on_plane("tip", (0, 0, 0), (0, 0, 0), tolerance=0.1)
