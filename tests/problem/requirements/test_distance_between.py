"""Distances between points: formulas, verdicts, and what every kind is asked."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trajopt as to
import trajopt.optimise.terms
from tests.optimise.terms.worlds import World
from tests.problem.requirements.kind import Kind
from tests.problem.requirements.sound import (
    MANY_CONFIGURATIONS,
    MANY_MOTIONS,
    OFFSET,
    TIP_OFFSET,
    positions,
    tip,
    verdict,
    violation,
)
from tests.verify.arms import mixed_arm, quintic, reduced, wavy
from trajopt.optimise.terms.positions import PointDistance
from trajopt.problem.requirements import (
    DistanceBetween,
    distance_between,
)
from trajopt.problem.residual import Residual
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.errors import ProblemError


@MANY_CONFIGURATIONS
@given(at=positions)
def test_distances(odd: ReducedModel, at: tuple[float, ...]) -> None:
    full = odd.all_positions(np.array(at))
    other = odd.scene.placement_of("slide", full) * np.array((0.0, 0.1, 0.0))
    expected = float(np.linalg.norm(tip(odd, at) - other))
    for lower, upper in ((0.0, 0.3), (0.2, 0.4), (0.5, np.inf)):
        need = to.distance_between(
            "tip", "slide", lower=lower, upper=upper, first_offset=TIP_OFFSET, second_offset=(0, 0.1, 0)
        )
        excess = max(lower - expected if lower else -np.inf, expected - upper)
        found = violation(odd, need, at)
        assert found == pytest.approx(excess, abs=1e-9)


def test_the_nearest_moment_of_two_points_is_seen(gantry: ReducedModel) -> None:
    past = quintic(gantry, [[-0.5, 0.1], [0.5, 0.1]], 1.0)
    holds, worst = verdict(gantry, past, distance_between("b", "world", lower=0.1001))
    assert not holds
    assert worst.time == pytest.approx(0.5, abs=0.02)
    assert verdict(gantry, past, distance_between("b", "world", lower=0.0999, upper=0.51))[0]
    assert not verdict(gantry, past, distance_between("b", "world", upper=0.509))[0]


@given(seed=st.integers(0, 10**6))
@MANY_MOTIONS
def test_distances_agree_with_dense_sampling(tmp_path: Path, seed: int) -> None:
    model = reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])
    there = wavy(model, seed, size=(0.1, 0.5, 1.0)[seed % 3])
    scene = model.scene
    apart = []
    for q in there(np.linspace(0.0, there.duration, 300)):
        full = model.all_positions(q)
        apart.append(
            np.linalg.norm(
                scene.placement_of("finger", full) * OFFSET - scene.placement_of("a", full).translation
            )
        )
    low, high = min(apart), max(apart)
    for lower, upper, holds in (
        (0.99 * low, 1.01 * high, True),
        (1.01 * low + 1e-4, 1.02 * high, False),
        (0.0, 0.99 * high, False),
    ):
        wanted = distance_between("finger", "a", lower=lower, upper=upper, first_offset=OFFSET)
        assert verdict(model, there, wanted)[0] == holds


def test_bad_input_is_refused() -> None:
    with pytest.raises(ProblemError):
        to.distance_between("a", "b")
    with pytest.raises(ProblemError):
        to.distance_between("a", "b", lower=0.2, upper=0.1)


def apart(at: World) -> Residual:
    required = to.distance_between(
        "held", "slide", lower=0.1, upper=0.5, first_offset=(0, 0.1, 0), second_offset=(0, 0, 0.2)
    )
    return PointDistance(at.reduced, required)


KIND = Kind(
    requirement=DistanceBetween,
    printed=[
        (to.distance_between("a", "b", lower=0.05), "a and b at least 50 mm apart"),
        (to.distance_between("a", "b", upper=0.4), "a and b at most 0.4 m apart"),
        (to.distance_between("a", "b", lower=0.05, upper=0.4), "a and b 50 mm to 0.4 m apart"),
    ],
    relaxed=[to.distance_between("tip", "world", lower=0.7, upper=0.8)],
    residuals={PointDistance: [apart]},
    calls={
        "distance_between": {
            "first": "panda_hand_tcp",
            "second": "box",
            "lower": 0.1,
            "upper": 0.5,
            "first_offset": (0.1, 0.0, 0.2),
        }
    },
)
