"""Curves: against formulas of their own, and what they refuse."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

import trajopt as to
from trajopt.tasks.cartesian import Curve, arc_about, arc_through, circle, joined, line, polyline, spline
from trajopt.values.arrays import Floats
from trajopt.values.curve import TURN_LENGTH
from trajopt.values.errors import ProblemError
from trajopt.verify.checks.curves import CurvePlaces

MANY = settings(max_examples=25, deadline=None)


def random_poses(rng: np.random.Generator, count: int) -> list[to.Placement]:
    return [to.placement(rng.uniform(-0.5, 0.5, 3), rpy=rng.uniform(-1.0, 1.0, 3)) for _ in range(count)]


def every_kind(rng: np.random.Generator) -> list[Curve]:
    a, b, c, d = random_poses(rng, 4)
    return [
        line(a, b),
        polyline((a, b, c, d)),
        polyline((a, b, c, d), blend=0.05),
        spline((a, b, c, d)),
        spline((a, b, c, a)),
        arc_through(a, b.translation, c),
        circle(a, radius=0.2, rotation=b.rotation, sweep=-2.0),
        joined((line(a, b), spline((b, c, d)))),
    ]


def test_a_line_is_slerp_and_lerp() -> None:
    a, b = random_poses(np.random.default_rng(1), 2)
    way = line(a, b)
    share = np.linspace(0.0, 1.0, 7)
    places = way(share * way.length)
    turned = Slerp([0, 1], Rotation.from_matrix(np.stack((a.rotation, b.rotation))))(share)
    assert places.rotation == pytest.approx(turned.as_matrix())
    assert places.translation == pytest.approx(
        a.translation + share[:, None] * (b.translation - a.translation)
    )
    assert way.length == pytest.approx(float(np.linalg.norm(b.translation - a.translation)))
    assert line(a, to.placement(a.translation, rotation=b.rotation)).length == pytest.approx(
        TURN_LENGTH * float(Rotation.from_matrix(a.rotation.T @ b.rotation).magnitude())
    )


@given(seed=st.integers(0, 10**6))
@MANY
def test_an_arc_keeps_its_radius_and_passes_its_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = random_poses(rng, 2)
    passed = rng.uniform(-0.5, 0.5, 3)
    way = arc_through(a, passed, b)
    points = way(np.linspace(0.0, way.length, 2001)).translation
    centre = way.pieces[0].points[0]
    radius = np.linalg.norm(a.translation - centre)
    assert np.linalg.norm(points - centre, axis=1) == pytest.approx(radius)
    assert points[0] == pytest.approx(a.translation)
    assert points[-1] == pytest.approx(b.translation)
    step = way.length / 2000
    assert np.linalg.norm(points - passed, axis=1).min() <= step
    about = arc_about(a, b, centre=centre)
    assert about.pieces[0].sweep <= np.pi + 1e-9
    if way.pieces[0].sweep < np.pi - 1e-3:
        assert about(np.linspace(0.0, about.length, 2001)).translation == pytest.approx(points, abs=1e-9)


def test_points_without_an_arc_are_refused() -> None:
    a, b = to.placement((1.0, 0.0, 0.0)), to.placement((-1.0, 0.0, 0.0))
    with pytest.raises(ProblemError, match="span no plane"):
        arc_about(a, b, centre=(0, 0, 0))
    with pytest.raises(ProblemError, match="one radius"):
        arc_about(a, to.placement((0, 1.1, 0)), centre=(0, 0, 0))
    with pytest.raises(ProblemError, match="lie on a line"):
        arc_through(a, (0, 0, 0), b)
    for call in (
        lambda: line(a, a),
        lambda: polyline((a,)),
        lambda: polyline((a, b), blend=-0.1),
        lambda: spline((a, b)),
        lambda: circle(a, radius=0.0, rotation=np.eye(3)),
        lambda: line(a, b) + line(a, b),
        lambda: joined(()),
    ):
        with pytest.raises(ProblemError):
            call()


def test_a_rounded_corner_stays_near_and_is_smooth() -> None:
    poses = [to.placement(p, rpy=(0, 0, t)) for p, t in (((0, 0, 0), 0), ((1, 0, 0), 0.5), ((1, 1, 0), -0.5))]
    sharp, way = polyline(poses), polyline(poses, blend=0.1)
    assert sharp.length == pytest.approx(2.0)
    assert way.length < sharp.length
    s = np.linspace(0.0, way.length, 20001)
    points = way(s).translation
    corner = np.linalg.norm(points - poses[1].translation, axis=1)
    assert 0.0 < corner.min() < 0.1
    off = np.minimum(np.abs(points[:, 1]), np.abs(points[:, 0] - 1.0))
    assert off[corner > 0.1].max() < 1e-9
    directions = np.diff(points, axis=0)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    assert np.linalg.norm(np.diff(directions, axis=0), axis=1).max() < 2e-3
    assert way.poses[1] == pytest.approx(s[corner.argmin()], abs=1e-3)
    assert [way.pose_before(at) for at in (0.0, 0.5, way.poses[1], way.length)] == [0, 0, 1, 2]


def test_a_spline_passes_its_poses_smoothly() -> None:
    poses = random_poses(np.random.default_rng(4), 5)
    way = spline([*poses, poses[0]])
    at = way(way.poses)
    assert at.translation == pytest.approx(np.array([pose.translation for pose in (*poses, poses[0])]))
    assert at.rotation == pytest.approx(np.array([pose.rotation for pose in (*poses, poses[0])]))
    for edge in (*way.edges[1:-1], 0.0):
        step = 1e-5
        before = way(np.array((edge or way.length,)) - np.array((2, 1, 0))[:, None].ravel() * step)
        after = way(np.array((edge,)) + np.arange(3) * step)
        slopes = [np.diff(side.translation, axis=0) / step for side in (before, after)]
        # The parameter is not the length, so that only the direction goes on.
        units = [slope.mean(axis=0) / np.linalg.norm(slope.mean(axis=0)) for slope in slopes]
        assert units[0] == pytest.approx(units[1], abs=1e-2)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=8, deadline=None)
def test_the_judge_reads_the_same_curve(seed: int) -> None:
    """Two readings of the data, and bounds on derivatives against differences of the first one."""
    rng = np.random.default_rng(seed)
    for way in every_kind(rng):
        judge = CurvePlaces(way)
        s = np.sort(rng.uniform(0.0, way.length, 12))
        places, (rotation, point) = way(s), judge.at(s)
        assert point == pytest.approx(places.translation, abs=1e-12)
        assert rotation == pytest.approx(places.rotation, abs=1e-12)
        for begin, end in pairwise(s.tolist()):
            _bounds_hold(way, judge, begin, end)


def _bounds_hold(way: Curve, judge: CurvePlaces, begin: float, end: float) -> None:
    """What a chord leaves out is within a bound by second derivatives and kinks, as the judge uses it."""
    bends = judge.bends(np.array((begin,)), np.array((end,)))
    length = end - begin
    places = way(np.linspace(begin, end, 21))
    share = np.linspace(0.0, 1.0, 21)[:, None]
    turned: Floats = places.rotation.reshape(-1, 9)
    turning = np.sqrt(2.0) * (bends.second[0, 1] + bends.rate[0, 1] ** 2)
    for values, second, kink in (
        (places.translation, bends.second[0, 0], bends.kinks[0, 0]),
        (turned, turning, np.sqrt(2.0) * bends.kinks[0, 1]),
    ):
        chord = (1.0 - share) * values[0] + share * values[-1]
        off = np.linalg.norm(values - chord, axis=1).max()
        assert off <= second * length**2 / 8.0 + kink * length / 4.0 + 1e-12


@MANY
@given(seed=st.integers(0, 10**6), share=st.floats(0.0, 0.95))
def test_the_rest_of_a_curve_is_on_it(seed: int, share: float) -> None:
    for curve in every_kind(np.random.default_rng(seed)):
        begin = share * curve.length
        rest = curve.after(begin)
        assert rest.length == pytest.approx(curve.length - begin)
        along = np.linspace(0.0, rest.length, 9)
        places, same = rest(along), curve(begin + along)
        np.testing.assert_allclose(places.translation, same.translation, atol=1e-9)
        np.testing.assert_allclose(places.rotation, same.rotation, atol=1e-9)
        assert rest.poses[0] == 0.0
        assert (np.diff(rest.poses) > 0.0).all()
        with pytest.raises(ProblemError, match="s must be from 0"):
            curve.after(curve.length)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_the_way_along_a_curve_is_tracked_from_its_beginning(share: float) -> None:
    """Also on curves that cross themselves, or end where they begin."""
    eight = [to.placement((0.1 * x, 0.1 * y, 0.3)) for x, y in ((0, 0), (1, 1), (1, 0), (0, 1), (0, 0))]
    for curve in (
        *every_kind(np.random.default_rng(3)),
        polyline(eight),
        circle(eight[0], radius=0.1, rotation=np.eye(3)),
    ):
        reached = share * curve.length
        lengths = np.linspace(0.0, reached, 2 + int(reached / 0.003))
        assert curve.travelled(curve(lengths)) == pytest.approx(reached, abs=2e-3)
