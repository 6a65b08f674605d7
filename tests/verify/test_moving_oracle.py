"""The judge among moving things against an oracle that shares nothing with it contradicts no verdict."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

import trajopt as to
from tests.oracles.moving_world import Oracle
from tests.oracles.random_worlds import bare, free_limits, into, random_motion, random_things
from tests.robots_for_tests import odd_arm
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.verify import verify
from trajopt.verify.certificate import Certificate, CheckKind, Evidence

ROBOTS = {"panda": "panda_arm", "ur5": "manipulator", "xarm7": "xarm7", "planar": "arm", "odd": "all"}
"""Their groups; the planar arm has a gripper, the odd one joints that slide, turn without end and mimic."""
NEAR = 2e-5
"""By so much the judge's distances, which are lower bounds, may be less than Coal's [m]."""
ALIKE = 2e-6
"""By so much may Coal's be less than the judge's [m]."""


@pytest.fixture(scope="module")
def scenes(planar_arm: to.Robot, tmp_path_factory: pytest.TempPathFactory) -> dict[str, to.Scene]:
    try:
        loaded = {name: bare(to.load(name)) for name in ("panda", "ur5", "xarm7")}
    except to.MissingExtra as error:
        pytest.skip(str(error))
    return {**loaded, "planar": bare(planar_arm), "odd": bare(odd_arm(tmp_path_factory.mktemp("robot")))}


def compare(certificate: Certificate, oracle: Oracle, required: float) -> str:
    """Compare a verdict with the oracle, and say what it was."""
    (check,) = (check for check in certificate.checks if check.kind is CheckKind.CLEARANCE)
    (at_fault,) = (check for check in certificate.checks if check.kind is CheckKind.AT_FAULT)
    if check.holds:
        assert certificate.at_fault >= certificate.clearance > required
        assert oracle.first_below(min(certificate.clearance, 0.2) - ALIKE) is None
    elif check.evidence is Evidence.SAMPLED:
        assert check.time is not None and check.value is not None
        measured = oracle.between(*check.subject.split(" - "), check.time)
        assert measured <= required + NEAR, "refuted, though it is farther than was asked"
        assert measured <= 0.0 or check.value <= measured + ALIKE
    if at_fault.holds:
        assert at_fault.value is None or at_fault.value > required
        least = inf if at_fault.value is None else at_fault.value
        assert oracle.first_below(min(least, 0.2) - ALIKE, moving=True) is None
    elif at_fault.evidence is Evidence.SAMPLED:
        assert at_fault.time is not None
        assert oracle.between(*at_fault.subject.split(" - "), at_fault.time) <= required + NEAR
    return f"{check.evidence.value}, at fault {at_fault.evidence.value}"


def random_case(scenes: dict[str, to.Scene], seed: int) -> str:
    """Judge a random motion in a random world, and compare."""
    rng = np.random.default_rng(seed)
    name = list(ROBOTS)[seed % len(ROBOTS)]
    required = float(rng.uniform(0.0, 0.02)) if rng.random() < 0.3 else 0.0
    scene = scenes[name].with_clearance(required)
    reduced = reduced_of(scene, ROBOTS[name], rng)
    motion = random_motion(reduced, rng)
    things = random_things(reduced, motion, rng)
    among = reduce_model(into(scene, things), ROBOTS[name], reduced.start)
    certificate = verify(among, motion, goals=(), limits=free_limits(among.limits))
    return compare(certificate, Oracle(reduced, motion, things), required)


def reduced_of(scene: to.Scene, group: str, rng: np.random.Generator) -> ReducedModel:
    """Return the robot at a random start, well within its limits."""
    limits = scene.robot.limits
    lower, upper = np.maximum(limits.lower, -2.0), np.minimum(limits.upper, 2.0)
    return reduce_model(scene, group, lower + rng.uniform(0.1, 0.9, len(lower)) * (upper - lower))


def planned_case(scenes: dict[str, to.Scene], seed: int) -> bool:
    """Plan in a random world, and compare if there is a motion; say whether there is."""
    rng = np.random.default_rng(seed)
    name = list(ROBOTS)[seed % len(ROBOTS)]
    reduced = reduced_of(scenes[name], ROBOTS[name], rng)
    room = 0.05 * (reduced.limits.upper - reduced.limits.lower).clip(max=1.0)
    away = reduced.start_positions + rng.uniform(-1.0, 1.0, len(room))
    away = np.clip(away, reduced.limits.lower + room, reduced.limits.upper - room)
    goal = dict(zip(reduced.joint_names, away.tolist(), strict=True))
    problem = to.Problem(
        scene=scenes[name], group=ROBOTS[name], start=reduced.start, goal=to.joint_positions(goal)
    )
    still = to.plan(problem, budget=to.Budget(attempts=1))
    if not still.verified:
        return False
    things = random_things(reduced, still.require().trajectory, rng)
    among = replace(problem, scene=into(scenes[name], things))
    result = to.plan(among, budget=to.Budget(attempts=2))
    if result.verified:
        plan = result.require()
        compare(plan.certificate, Oracle(reduced, plan.trajectory, things), 0.0)
    return result.verified


@pytest.mark.parametrize("block", range(6))
def test_no_verdict_on_a_random_motion_is_contradicted(scenes: dict[str, to.Scene], block: int) -> None:
    found = [random_case(scenes, seed) for seed in range(10 * block, 10 * block + 10)]
    assert len(set(found)) > 1, "some are proven, some refuted"


def test_no_motion_that_was_planned_is_contradicted(scenes: dict[str, to.Scene]) -> None:
    assert sum(planned_case(scenes, seed) for seed in range(10)) > 1


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("block", range(20))
def test_none_of_many_verdicts_is_contradicted(scenes: dict[str, to.Scene], block: int) -> None:
    for seed in range(1000 + 100 * block, 1100 + 100 * block):
        random_case(scenes, seed)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("block", range(10))
def test_none_of_many_motions_that_were_planned_is_contradicted(
    scenes: dict[str, to.Scene], block: int
) -> None:
    assert sum(planned_case(scenes, seed) for seed in range(10 * block, 10 * block + 10)) > 1
