"""Knots that a smooth path passes through, although its corners are rounded."""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings

from tests.timing.retime_cases import make_limits, make_path, polylines
from trajopt.robot.joints import JointLimits
from trajopt.timing import Retimed, RetimeOptions, retime
from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError
from trajopt.values.trajectory import Path, Trajectory

ZIGZAG = make_path([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]])


def nearest(found: object, knot: Floats) -> float:
    """The least distance of a motion from a position: coarse samples, and fine ones around their minima.

    A motion may come by more than once.
    """
    assert isinstance(found, Retimed)
    motion = found.trajectory
    coarse = np.linspace(0.0, motion.duration, 4001)
    away = np.pad(np.linalg.norm(motion(coarse) - knot, axis=1), 1, constant_values=np.inf)
    near = (away[1:-1] <= away[:-2]) & (away[1:-1] <= away[2:])
    return min(_nearest_around(motion, knot, centre, coarse[1]) for centre in coarse[near].tolist())


def _nearest_around(motion: Trajectory, knot: Floats, centre: float, width: float) -> float:
    least = np.inf
    for _ in range(4):
        times = np.clip(np.linspace(centre - width, centre + width, 1001), 0.0, motion.duration)
        away = np.linalg.norm(motion(times) - knot, axis=1)
        centre, width, least = float(times[away.argmin()]), width / 100.0, float(away.min())
    return least


def test_cuts_a_corner_that_need_not_be_passed() -> None:
    assert nearest(retime(ZIGZAG, make_limits(2)), ZIGZAG.knots[1]) > 1e-3


def test_passes_the_knots_that_are_named() -> None:
    found = retime(ZIGZAG, make_limits(2), through=(1, 2))
    assert max(nearest(found, ZIGZAG.knots[knot]) for knot in (1, 2)) < 1e-6


def test_passing_takes_less_time_than_stopping() -> None:
    limits = make_limits(2)
    passing = retime(ZIGZAG, limits, through=(1, 2))
    legs = [retime(make_path(ZIGZAG.knots[i : i + 2].tolist()), limits) for i in range(3)]
    assert isinstance(passing, Retimed)
    assert passing.trajectory.duration < sum(
        leg.trajectory.duration for leg in legs if isinstance(leg, Retimed)
    )


TWICE = make_path(
    [[1.0, 1.0], [0.0, 1.0], [-1.0, 1.0], [0.0, 1.0], [0.0, -1.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]
)
"""Comes by its knot (0, 0) before it passes it."""


@settings(max_examples=30, deadline=None)
@given(polylines())
@example((TWICE, make_limits(2, velocity=(1.76933713, 3.46265499), acceleration=(2.22318665, 12.20703965))))
def test_passes_any_inner_knots(case: tuple[Path, JointLimits]) -> None:
    path, limits = case
    inner = path.knots[1:-1]
    # On a position limit a corner has no room to move outwards.
    room = np.minimum(inner - limits.lower, limits.upper - inner).min(axis=1, initial=np.inf)
    through = tuple((1 + np.flatnonzero(room > 0.01)).tolist())
    assume(through)
    found = retime(path, limits, through=through, options=RetimeOptions(path_tolerance=2e-3))
    assume(isinstance(found, Retimed))
    assert max(nearest(found, path.knots[knot]) for knot in through) < 1e-4


@pytest.mark.parametrize("knot", [0, 3, -1])
def test_rejects_ends(knot: int) -> None:
    with pytest.raises(ShapeError, match="between 1 and 2"):
        retime(ZIGZAG, make_limits(2), through=(knot,))
