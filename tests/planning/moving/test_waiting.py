"""Beginnings of a motion among what moves, against each beginning looked at by itself."""

from collections.abc import Iterator
from math import inf

import numpy as np
import pytest

import trajopt as to
from tests.planning.moving.test_path_time import arm, crowded, swinging
from trajopt.geometry import DynamicObstacles, evaluator
from trajopt.planning.moving.dynamic_timing import HALVINGS, MOST, STEP, Waiting
from trajopt.planning.moving.sampled_checks import INTERVAL, SampledChecks
from trajopt.scene.reduced import TimedModel
from trajopt.scene.reducing import reduce_model

__all__ = ["arm"]


def checks_among(timed: TimedModel) -> SampledChecks:
    return SampledChecks(DynamicObstacles(timed, evaluator(timed.reduced)))


def one_by_one(checks: SampledChecks, motion: to.Trajectory, dwell: float) -> Iterator[float]:
    """Yield how long a motion waits, as `Waiting` says of itself."""
    checks.start_at(motion(np.zeros(1)))
    end = motion.duration + dwell

    def clear(wait: float) -> bool:
        even = np.linspace(0.0, end, max(2, int(np.ceil(end / INTERVAL)) + 1))
        along = np.concatenate((even, np.clip(checks.obstacles.moments - wait, 0.0, end)))
        return not checks.near(motion(along), along + wait).any()

    if clear(0.0):
        yield 0.0
    last, before, found = checks.settled, 0.0, 0
    for wait in (*np.arange(STEP, last, STEP).tolist(), last):
        standing = np.arange(before, wait, INTERVAL)
        at_start = np.tile(motion(np.zeros(1)), (len(standing), 1))
        if found == MOST or checks.near(at_start, standing).any():
            return
        if clear(wait):
            sooner, blocked = wait, before
            for _ in range(0 if found else HALVINGS):
                middle = (blocked + sooner) / 2.0
                blocked, sooner = (blocked, middle) if clear(middle) else (middle, sooner)
            yield sooner
            found += 1
        before = wait


@pytest.mark.parametrize("dwell", [0.0, 0.4])
def test_start_times_match_a_check_of_each_one_alone(arm: to.Robot, dwell: float) -> None:
    waited = looked_at = looked_at_each = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        scene = crowded(arm, rng)
        scene = scene.add(
            "door", to.Box(0.5, 0.05, 0.5), to.placement((0.5, 0.3, 0.3)), appears=0.6, expires=1.7
        )
        reduced = reduce_model(scene, "all", np.zeros(len(arm.joint_names)))
        motion, timed = swinging(reduced, rng), reduced.timed
        assert timed is not None
        checks, each = checks_among(timed), checks_among(timed)
        expected = list(one_by_one(each, motion, dwell))
        found = [begun.duration - motion.duration for begun in Waiting(checks, dwell).beginnings(motion)]
        assert found == pytest.approx(expected, abs=1e-9)
        waited += any(wait > 2.0 * STEP for wait in expected)
        looked_at += checks.obstacles.query.counts.forward_kinematics
        looked_at_each += each.obstacles.query.counts.forward_kinematics
    assert waited >= 3
    assert looked_at < 0.8 * looked_at_each


def test_no_start_is_later_than_the_limit(arm: to.Robot) -> None:
    rng = np.random.default_rng(0)
    reduced = reduce_model(crowded(arm, rng), "all", np.zeros(len(arm.joint_names)))
    motion, timed = swinging(reduced, rng), reduced.timed
    assert timed is not None
    for latest in (0.0, 0.3, inf):
        begun = Waiting(checks_among(timed)).beginnings(motion, latest=latest)
        assert all(each.duration - motion.duration <= latest + 1e-9 for each in begun)
