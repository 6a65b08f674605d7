"""The checker's bounds hold against exact fractions, other kinematics and samples, and are narrow."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx
from scipy.spatial.transform import Rotation

from tests.files.proof.conftest import Checker, Document
from tests.files.proof.dense import curve, placed

Numbers = np.ndarray


@pytest.fixture(scope="module")
def rng() -> np.random.Generator:
    return np.random.default_rng(11)


def exact(values: Numbers) -> list[Fraction]:
    return [Fraction(value) for value in values.ravel().tolist()]


@pytest.mark.parametrize("name", ["__add__", "__sub__", "__mul__", "__truediv__"])
def test_operations_contain_the_exact_result(name: str, checker: Checker, rng: np.random.Generator) -> None:
    intervals = checker.modules["intervals"]
    sizes = 10.0 ** rng.integers(-8, 8, size=(2, 500))
    one, other = rng.standard_normal((2, 500)) * sizes
    other = np.abs(other) if name == "__truediv__" else other
    found = getattr(intervals.exactly(one), name)(intervals.exactly(other))
    wide = getattr(intervals.Interval(one, one + sizes[0]), name)(intervals.Interval(other, other + sizes[1]))
    for place, (a, b) in enumerate(zip(exact(one), exact(other), strict=True)):
        result = getattr(Fraction, name)(a, b)
        assert Fraction(found.low[place]) <= result <= Fraction(found.high[place])
        for da in (0, Fraction(1, 3), 1):
            for db in (0, Fraction(1, 3), 1):
                inner = a + da * (Fraction(one[place] + sizes[0, place]) - a)
                outer = b + db * (Fraction(other[place] + sizes[1, place]) - b)
                result = getattr(Fraction, name)(inner, outer)
                assert Fraction(wide.low[place]) <= result <= Fraction(wide.high[place])
    assert (found.high - found.low <= 5e-16 * np.maximum(np.abs(found.high), 1e-300)).all()


def test_a_divisor_that_may_vanish_gives_no_number(checker: Checker) -> None:
    intervals = checker.modules["intervals"]
    with np.errstate(all="ignore"):
        found = intervals.exactly([1.0, 1.0]) / intervals.Interval(np.array([0.0, -1.0]), np.ones(2))
    assert np.isnan(found.low).all() and np.isnan(found.high).all()


def test_sines_and_cosines_contain_the_exact_ones(checker: Checker, rng: np.random.Generator) -> None:
    intervals = checker.modules["intervals"]
    angles = np.concatenate((rng.standard_normal(200) * 4.0, [0.0, np.pi, -np.pi / 2, 1e-300, 1e10]))
    found = intervals.sine_and_cosine(intervals.Interval(angles, np.nextafter(angles, np.inf)))
    before = ctx.prec
    ctx.prec = 200
    try:
        for place, angle in enumerate(angles.tolist()):
            for interval, ball in zip(found, arb(angle).sin_cos(), strict=True):
                assert not ball < arb(float(interval.low[place]))
                assert not ball > arb(float(interval.high[place]))
    finally:
        ctx.prec = before
    assert np.max(found[0].high[:200] - found[0].low[:200]) < 1e-14
    with np.errstate(all="ignore"):
        lost = intervals.sine_and_cosine(intervals.exactly([np.nan, np.inf]))
    assert all(np.isnan(side.low).all() for side in lost)


def test_support_functions_are_bounded_tightly(checker: Checker, rng: np.random.Generator) -> None:
    shapes, intervals = checker.modules["shapes"], checker.modules["intervals"]
    vertices, directions = rng.standard_normal((20, 3)), rng.standard_normal((50, 3))
    found = shapes.Hull(vertices, 0.0).support(intervals.exactly(directions))
    for place, direction in enumerate(directions):
        largest = max(
            sum(a * b for a, b in zip(exact(direction), exact(vertex), strict=True)) for vertex in vertices
        )
        assert largest <= Fraction(found[place]) <= largest + Fraction(1, 10**13)
    ring = np.linspace(0.0, 2.0 * np.pi, 2000)
    for bottom, top in ((0.3, 0.3), (0.3, 0.0), (0.1, 0.4)):
        rims = [
            np.stack((r * np.cos(ring), r * np.sin(ring), np.full(2000, z)), 1)
            for r, z in ((bottom, -0.5), (top, 0.5))
        ]
        sampled = (np.vstack(rims) @ directions.T).max(axis=0)
        bound = shapes.Frustum(bottom, top, 1.0).support(intervals.exactly(directions))
        assert (bound >= sampled - 1e-15).all() and (bound <= sampled + 1e-5).all()
    round_hull = shapes.Hull(np.zeros((1, 3)), 0.25).support(intervals.exactly(directions))
    assert np.allclose(round_hull, 0.25 * np.linalg.norm(directions, axis=1), rtol=1e-14)


def arm(rng: np.random.Generator, degree: int) -> Document:
    """A tree of five joints, one that slides and one that mimics, with a random motion."""
    joints: list[dict[str, Any]] = []
    for number, parent in enumerate((0, 1, 2, 2, 4)):
        place = {
            "joint": parent,
            "rotation": Rotation.random(random_state=number).as_quat()[[3, 0, 1, 2]].tolist(),
            "translation": rng.uniform(-0.5, 0.5, 3).tolist(),
        }
        axis = rng.standard_normal(3)
        joints.append(
            {
                "name": f"j{number}", "place": place, "turns": number != 2,
                "axis": (axis / np.linalg.norm(axis)).tolist(), "coordinate": min(number, 3),
                "factor": -0.5 if number == 4 else 1.0, "offset": 0.1 * number,
                **dict.fromkeys(("lower", "upper", "velocity", "acceleration", "jerk")),
            }
        )  # fmt: skip
    values = [rng.uniform(-1.0, 1.0, (4, 4)).tolist() for _ in range((degree + 1) // 2)]
    place = {"joint": 0, "rotation": [1, 0, 0, 0], "translation": [0, 0, 0]}
    ends = dict.fromkeys(("positions", "velocities", "accelerations"), [0.0] * 4)
    return {
        "title": "arm",
        "motion": {"coordinates": list("abcd"), "times": [0.0, 0.7, 1.1, 2.0], "values": values},
        "drives": [], "joints": joints,
        "ends": {**ends, "tolerance": 9, "speed": 9, "rests": False},
        "excess": 0,
        "parts": [{"owner": "a", "place": place, "shape": {"kind": "half-space"}}],
        "changes": [], "pairs": [], "excused": [], "contacts": [], "requirements": [], "judged": [],
    }  # fmt: skip


@pytest.mark.parametrize("degree", [3, 5])
def test_motion_and_kinematics_contain_others(
    degree: int, checker: Checker, rng: np.random.Generator
) -> None:
    stated = arm(rng, degree)
    statement = checker.modules["statement"].read_statement(stated)
    grid = np.unique(np.concatenate((stated["motion"]["times"], rng.uniform(0.0, 2.0, 40))))
    found = checker.modules["kinematics"].GridKinematics(statement, grid)
    turns, origins = placed(stated, grid)
    for interval, value in ((found.rotation, turns), (found.translation, origins)):
        assert (interval.low - 1e-14 <= value).all() and (value <= interval.high + 1e-14).all()
        assert np.max(interval.high - interval.low) < 1e-12
    polynomial = curve(stated)
    for order, bound in enumerate(found.motion.bounds):
        for share in np.linspace(0.001, 0.999, 21):
            value = polynomial(grid[:-1] + share * np.diff(grid), order)
            slack = 1e-9 * (1.0 + np.abs(value))
            assert (bound.low - slack <= value).all() and (value <= bound.high + slack).all()
    cells = np.diff(grid)[:, None]
    spread = found.motion.bounds[0].high - found.motion.bounds[0].low
    assert (spread <= cells * found.motion.bounds[1].size + 1e-12).all()


@pytest.mark.parametrize("degree", [3, 5])
@pytest.mark.parametrize(
    ("joint", "seen"), [(5, 0), (5, 2), (3, 0), (3, 1), (1, 0), (5, 4), (5, 3), (3, 5), (0, 5)]
)
def test_travel_bounds_derivatives(
    degree: int, joint: int, seen: int, checker: Checker, rng: np.random.Generator
) -> None:
    stated = arm(rng, degree)
    statement = checker.modules["statement"].read_statement(stated)
    grid = np.unique(np.concatenate((stated["motion"]["times"], np.linspace(0.0, 2.0, 20))))
    found = checker.modules["kinematics"].GridKinematics(statement, grid)
    intervals, point = checker.modules["intervals"], rng.uniform(-0.3, 0.3, 3)
    path = found.translation[:, joint] + intervals.turned(found.rotation[:, joint], intervals.exactly(point))
    begin = np.arange(len(grid) - 1)
    travel = found.travel(joint, path, 0.0, begin, begin + 1, np.full(len(begin), seen))
    for place in begin.tolist():
        times, step = np.linspace(grid[place], grid[place + 1], 12, retstep=True)
        turns, origins = placed(stated, times)
        world = origins[:, joint] + turns[:, joint] @ point
        local = np.einsum("tji,tj->ti", turns[:, seen], world - origins[:, seen])
        for order, bound in enumerate((travel.velocity, travel.acceleration, travel.jerk), start=1):
            sizes = np.linalg.norm(np.diff(local, order, axis=0) / step**order, axis=1)
            assert sizes.max() <= bound[place] * (1.0 + 1e-6) + 1e-5
    assert np.isfinite(travel.jerk).all()


@pytest.mark.parametrize("degree", [3, 5])
@pytest.mark.parametrize(("joint", "seen"), [(5, 0), (5, 2), (5, 3), (3, 5), (0, 5)])
def test_turning_bounds_unit_vectors(
    degree: int, joint: int, seen: int, checker: Checker, rng: np.random.Generator
) -> None:
    stated = arm(rng, degree)
    modules = checker.modules
    statement = modules["statement"].read_statement(stated)
    grid = np.unique(np.concatenate((stated["motion"]["times"], np.linspace(0.0, 2.0, 20))))
    found = modules["kinematics"].GridKinematics(statement, grid)
    place = modules["statement"].FixedPlace(joint, None, None)
    bound = modules["requirement"].FrameView(place, seen).turning(found)
    for cell, most in enumerate(bound.tolist()):
        times, step = np.linspace(grid[cell], grid[cell + 1], 12, retstep=True)
        turns, _ = placed(stated, times)
        local = turns[:, seen].swapaxes(1, 2) @ turns[:, joint]
        sizes = np.linalg.norm(np.diff(local, 2, axis=0) / step**2, axis=1)
        assert sizes.max() <= most * (1.0 + 1e-6) + 1e-5
    assert np.isfinite(bound).all()


def test_rotation_vectors_are_bounded(checker: Checker, rng: np.random.Generator) -> None:
    import sys

    intervals, rule = checker.modules["intervals"], checker.modules["rule_placement"]
    assert "rule_placement" not in sys.modules
    for size in (0.0, 1e-9, 1e-3, 0.5, 2.0, 3.0):
        vector = rng.standard_normal(3)
        vector *= size / np.linalg.norm(vector)
        x, y, z, w = Rotation.from_rotvec(vector).as_quat()
        rotation = intervals.rotation_of(np.array((w, x, y, z)))
        found = rule.rotation_vectors(*rule.skew_and_cosine(rotation[None]))[0]
        assert (found >= np.abs(vector) - 1e-15).all() and (found <= np.abs(vector) + 1e-8).all()
    half = rule.rotation_vectors(*rule.skew_and_cosine(intervals.exactly(np.diag((1.0, -1.0, -1.0))[None])))
    assert not (half <= 1e9).all()
