"""The order of targets and the posture at each, against all tours."""

from dataclasses import replace
from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from trajopt.robot.joints import JointLimits
from trajopt.tasks.tour import Tours
from trajopt.timing.time_scaling import travel_time


def drawn(seed: int, groups: int, nodes: int) -> Tours:
    rng = np.random.default_rng(seed)
    places = rng.uniform(size=(groups * nodes, 2))
    between = np.linalg.norm(places[:, None] - places[None], axis=-1) + rng.uniform(
        0.0, 0.2, (len(places),) * 2
    )
    return Tours(
        np.repeat(np.arange(groups), nodes),
        np.linalg.norm(places, axis=1),
        between,
        rng.uniform(size=len(places)),
    )


def every_cost(tours: Tours, groups: int) -> list[float]:
    nodes = [np.flatnonzero(tours.groups == group) for group in range(groups)]
    return [
        tours.cost(np.array(tour))
        for order in permutations(range(groups))
        for tour in product(*(nodes[group] for group in order))
    ]


@pytest.mark.parametrize("seed", range(12))
def test_small_tours_are_the_shortest_of_all(seed: int) -> None:
    tours = drawn(seed, 5, 3)
    tour = tours.shortest(np.random.default_rng(0))
    assert tours.cost(tour) == pytest.approx(min(every_cost(tours, 5)), rel=1e-9)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000), st.integers(1, 12), st.integers(1, 4))
def test_a_tour_has_one_node_of_each_group(seed: int, groups: int, nodes: int) -> None:
    tours = drawn(seed, groups, nodes)
    tour = tours.shortest(np.random.default_rng(0), kicks=3)
    assert sorted(tours.groups[tour]) == list(range(groups))


@settings(deadline=None, max_examples=100)
@given(st.floats(0.0, 5.0), st.floats(0.1, 3.0), st.floats(0.1, 20.0))
def test_the_rest_to_rest_time_matches_a_trapezoidal_profile(way: float, speed: float, rate: float) -> None:
    """The area under the fastest speed profile of that duration is the way."""
    limits = one_joint(speed, rate)
    time = float(travel_time(np.zeros(1), np.array([way]), limits, rests=True))
    t = np.linspace(0.0, time, 20_001)
    profile = np.minimum(np.minimum(rate * t, rate * (time - t)), speed)
    assert float(np.trapezoid(profile, t)) == pytest.approx(way, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("speed", [0.3, 3.0])
@pytest.mark.parametrize("rate", [2.0, 50.0, np.inf])
@pytest.mark.parametrize("way", [1e-3, 0.05, 0.4, 5.0])
def test_a_jerk_limit_lengthens_the_way_from_rest_to_rest(way: float, rate: float, speed: float) -> None:
    """The largest speed that is reached is found by bisection."""
    jerk = 10.0

    def ramp(reached: float) -> float:
        peak = min(rate, np.sqrt(reached * jerk))
        return reached / peak + peak / jerk

    reached = brentq(lambda each: each * ramp(each) - way, 1e-9, 1e3)
    expected = 2.0 * ramp(reached) if reached <= speed else way / speed + ramp(speed)
    limits = replace(one_joint(speed, rate), jerk=np.array([jerk]))
    time = float(travel_time(np.zeros(1), np.array([way]), limits, rests=True))
    assert time == pytest.approx(expected, rel=1e-6)


def test_in_passing_only_the_speed_counts() -> None:
    assert travel_time(np.zeros(1), np.array([3.0]), one_joint(1.5, 2.0), rests=False) == pytest.approx(2.0)


def one_joint(speed: float, rate: float) -> JointLimits:
    wide = np.array([np.inf])
    return JointLimits(("joint",), -wide, wide, np.array([speed]), np.array([rate]), wide, wide)
