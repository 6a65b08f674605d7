"""A motion that begins when the scene's clock shows something: as one in the scene by a clock of its own."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.oracles.random_worlds import bare, free_limits, into, random_motion, random_things
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.verify import Certificate, Judge, Specification

SEEDS = range(60)


def asked(motion: to.Trajectory, reduced: ReducedModel, clock: float = 0.0) -> Specification:
    return Specification(
        goals=(),
        limits=free_limits(reduced.limits),
        start_positions=motion.positions[0],
        start_velocities=motion(0.0, 1),
        start_accelerations=motion(0.0, 2),
        clock=clock,
    )


def both(arm: to.Robot, seed: int) -> tuple[Certificate, Certificate]:
    """Judge the last part of a motion by the clock of the scene, and in the scene by a clock of its own."""
    rng = np.random.default_rng((18, seed))
    scene = bare(arm)
    reduced = reduce_model(scene, "arm", rng.uniform(-1.0, 1.0, len(arm.joint_names)))
    whole = random_motion(reduced, rng)
    scene = into(scene, random_things(reduced, whole, rng))
    clock = float(rng.uniform(0.0, 0.8) * whole.duration)
    part = whole.between(clock, whole.duration)
    here, later = (reduce_model(each, "arm", reduced.start) for each in (scene, scene.at(clock)))
    return (
        Judge(here).certify(part, asked(part, here, clock)),
        Judge(later).certify(part, asked(part, later)),
    )


def test_both_clocks_give_one_verdict(planar_arm: to.Robot) -> None:
    verdicts: list[bool] = []
    for seed in SEEDS:
        shifted, own = both(planar_arm, seed)
        assert shifted.verified == own.verified
        assert shifted.clearance == pytest.approx(own.clearance, abs=1e-7)
        assert shifted.at_fault == pytest.approx(own.at_fault, abs=1e-7)
        assert [check.holds for check in shifted.checks] == [check.holds for check in own.checks]
        verdicts.append(own.verified)
    assert 10 < sum(verdicts) < len(SEEDS) - 10


def test_a_prediction_ends_by_the_clock_of_the_scene(planar_arm: to.Robot) -> None:
    scene = bare(planar_arm)
    reduced = reduce_model(scene, "arm", np.zeros(len(planar_arm.joint_names)))
    track = to.Track.constant_velocity(to.placement((9.0, 0.0, 0.0)), (0.1, 0.0, 0.0))
    known = scene.add("passer", to.Sphere(0.1), motion=to.Prediction(track, until=2.0))
    here = reduce_model(known, "arm", reduced.start)
    still = np.tile(reduced.start_positions, (2, 1))
    motion = to.Trajectory(reduced.joint_names, np.array((0.0, 1.0)), still, 0.0 * still)
    for clock, verified in ((0.0, True), (0.99, True), (1.01, False), (3.0, False)):
        assert Judge(here).certify(motion, asked(motion, here, clock)).verified == verified


def test_a_motion_starts_at_the_stated_start(planar_arm: to.Robot) -> None:
    scene = bare(planar_arm)
    here = reduce_model(scene, "arm", np.zeros(len(planar_arm.joint_names)))
    away = np.full((2, len(here.joint_names)), 0.1)
    motion = to.Trajectory(here.joint_names, np.array((0.0, 1.0)), away, 0.0 * away)
    stated = asked(motion, here)
    assert Judge(here).certify(motion, stated).verified
    for start in (None, motion.positions[0] + 1e-3):
        assert not Judge(here).certify(motion, replace(stated, start_positions=start)).verified
