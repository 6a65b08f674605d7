"""What a start, a goal or a waypoint just holds is held there, and nothing is given away elsewhere."""

from collections.abc import Callable

import numpy as np
import pytest

import trajopt as to
from trajopt.geometry import Query
from trajopt.optimise.terms import Constraint
from trajopt.optimise.transcription.margins import MOST_KEPT, TaperedConstraint, tapered
from trajopt.problem.residual import WHOLE
from trajopt.values.arrays import Rows

WIDE, HAIR = 1.0, 1e-6
LAST = 12


def turned() -> to.Requirement:
    """The hand's x axis within 1 rad of the world's: shoulder and elbow together."""
    return to.axis_alignment("hand", axis=(1, 0, 0), direction=(1, 0, 0), tolerance=WIDE)


def inside() -> to.Requirement:
    """The hand no farther than 0.8 m in y, nor left of -0.2 m."""
    return to.position_in_region("hand", to.Box(4.0, 1.0, 1.0), to.placement((0.0, 0.3, 0.1)))


def apart() -> to.Requirement:
    """The hand at 0.5 to 0.99 m from the shoulder."""
    return to.distance_between("hand", "upper", lower=0.5, upper=0.99)


def rows(value: float, place: float) -> Rows:
    jacobian = np.zeros((1, 1, 2))
    return Rows(
        np.array([value]), jacobian, np.zeros((1, 1), dtype=int), np.zeros(1, dtype=int), np.array([place])
    )


def written(arm: to.Robot, **stops: float) -> Constraint:
    """The turn, for stops at a shoulder's angle each."""
    problem = to.Problem(
        scene=to.Scene(arm), group="arm", start={}, goal=to.joint_positions({"shoulder": 0.1})
    )
    query = Query(problem.reduced)
    places = [int(name.removeprefix("at_")) for name in stops]
    positions = np.array([(angle, 0.0) for angle in stops.values()])
    (item,) = tapered(turned(), query, WHOLE, places, positions, LAST)
    return item


def test_bounds_end_at_the_clearance_of_a_stop(planar_arm: to.Robot) -> None:
    item = written(planar_arm, at_0=0.98, at_12=0.5)
    assert isinstance(item, TaperedConstraint) and [stop.place for stop in item.stops] == [0]

    def upper(place: float) -> float:
        return float(item.bounds(rows(0.0, place))[1][0])

    kept = WIDE - MOST_KEPT["rad"]
    assert upper(0.0) == pytest.approx(0.98)
    assert kept < upper(1.5) < 0.98
    assert upper(3.0) == upper(12.0) == pytest.approx(kept)
    assert 0.98 + item.tolerance < WIDE, "what counts as held is held"


def test_nothing_is_given_away_where_it_is_not_needed(planar_arm: to.Robot) -> None:
    assert not isinstance(written(planar_arm, at_0=0.5, at_12=-0.8), TaperedConstraint)
    beyond = written(planar_arm, at_0=1.2, at_12=0.5)
    assert not isinstance(beyond, TaperedConstraint), "what is broken is no stop to go by"


def test_a_wide_tolerance_is_tightened_only_as_retiming_needs(planar_arm: to.Robot) -> None:
    """A straight line that holds a wide cone by 0.06 rad all the way is the motion."""
    wide = to.axis_alignment("hand", axis=(1, 0, 0), direction=(1, 0, 0), tolerance=2.5)
    problem = to.Problem(
        scene=to.Scene(planar_arm), group="arm", start={"shoulder": 2.44, "elbow": 0.0},
        goal=to.joint_positions({"shoulder": 1.44, "elbow": 1.0}), constraints=[wide],
    )  # fmt: skip
    result = to.plan(problem)
    path = result.require().path
    assert result.counts["attempts"] == 1
    assert np.abs(path.knots.sum(axis=1) - 2.44).max() < 0.02


CASES: dict[str, tuple[Callable[[], to.Requirement], tuple[float, float], tuple[float, float]]] = {
    "turn, start": (turned, (WIDE - HAIR, 0.0), (-0.5, 0.3)),
    "turn, goal": (turned, (-0.5, 0.3), (WIDE - HAIR, 0.0)),
    "turn, both": (turned, (0.97, 0.0), (-0.97, 0.0)),
    "region, start": (inside, (float(np.arcsin(0.799)), 0.0), (0.2, 0.5)),
    "region, goal": (inside, (0.2, 0.5), (-float(np.arcsin(0.1999)), 0.0)),
    "distance, goal": (apart, (0.2, 1.2), (0.6, 2.0 * float(np.arccos(0.9899)))),
}


@pytest.mark.parametrize("name", CASES)
def test_ends_that_just_fulfil_the_requirement(planar_arm: to.Robot, name: str) -> None:
    required, start, goal = CASES[name]
    first, last = (dict(zip(("shoulder", "elbow"), values, strict=True)) for values in (start, goal))
    problem = to.Problem(
        scene=to.Scene(planar_arm), group="arm", start=first, goal=to.joint_positions(last),
        constraints=[required()],
    )  # fmt: skip
    result = to.plan(problem)
    assert result.verified, result.message
    assert result.counts["attempts"] == 1, "the straight line will do"
