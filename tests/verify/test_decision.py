"""The judge's decision: the certificate's verdict with less work.

`conftest.py` compares them on the motions of all other tests of the judge.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.verify.arms import mixed_arm, planar_arm, quintic, reduced, wavy
from tests.verify.conftest import Deciding
from tests.verify.test_required_clearance import THERE_AND_BACK, walled
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.arrays import readonly
from trajopt.values.shapes.shapes import Box, Sphere
from trajopt.verify import Judge, Specification, verify

NOTHING = Specification(goals=())


def crowded(folder: Path, seed: int) -> ReducedModel:
    """An arm among balls and boxes at random places, some of them with a clearance of their own."""
    rng = np.random.default_rng(seed)
    scene = Scene(mixed_arm(folder))
    for number in range(6):
        shape = Sphere(0.05) if number % 2 else Box(0.1, 0.05, 0.2)
        place = rng.uniform(-1.0, 1.0, 3)
        scene = scene.add(f"thing {number}", shape, to.placement(place / np.linalg.norm(place) * 0.9))
    return reduced(scene.with_clearance(0.002 * (seed % 3)), [0.0] * 4)


def test_verdicts_of_random_motions_are_the_same(tmp_path: Path, deciding: Deciding) -> None:
    before, verified = deciding.verdicts, 0
    for seed in range(60):
        model = crowded(tmp_path, seed)
        motion = wavy(model, seed, size=0.2 + 0.6 * (seed % 4) / 3.0)
        verified += verify(model, motion, goals=()).verified
    assert deciding.verdicts == before + 60
    assert 10 <= verified <= 50


def test_a_contact_that_ends_the_search_is_one(tmp_path: Path) -> None:
    ended = 0
    for seed in range(20):
        model = crowded(tmp_path, seed)
        motion, judge = wavy(model, seed, size=0.6), Judge(model)
        verdict = judge.decide(motion, NOTHING)
        if verdict.contact is not None:
            collisions = judge.examine(motion(verdict.contact.time)).collisions
            assert (verdict.contact.first, verdict.contact.second) in {
                (each.first, each.second) for each in collisions
            }
            assert not verdict.verified
            ended += 1
    assert 5 <= ended < 20


@pytest.mark.parametrize("missing", [-1e-3, -1e-4, -2e-5, 2e-5, 1e-4, 1e-3])
def test_verdicts_are_the_same_at_the_clearance_required(tmp_path: Path, missing: float) -> None:
    model = reduced(walled(tmp_path).with_clearance(0.03 + missing), THERE_AND_BACK[0])
    motion = quintic(model, THERE_AND_BACK, 1.0)
    assert verify(model, motion, goals=()).verified == (missing < 0.0)


@pytest.mark.parametrize("field", ["velocity", "acceleration", "jerk", "effort", "upper"])
def test_verdicts_are_the_same_at_limits(tmp_path: Path, field: str, deciding: Deciding) -> None:
    model = reduced(Scene(planar_arm(tmp_path, axis="0 1 0")), [0.1, 0.2])
    motion, loose = quintic(model, [[0.1, 0.2], [1.1, -0.3]], 1.0), model.limits
    tight = replace(loose, jerk=readonly(np.full(2, 1e5)))
    checks = verify(model, motion, goals=(), limits=tight).checks
    name = {"upper": "joint position", "effort": "torque"}.get(field, field)
    reached = next(check for check in checks if check.name == name)
    joint, before = loose.joint_names.index(reached.subject), deciding.verdicts
    verdicts: list[bool] = []
    for share in (-1e-3, -4e-6, -1.5e-6, -0.9e-6, -0.6e-6, -0.4e-6, 0.0, 1e-6, 1e-3):
        limit = np.array(getattr(tight, field))
        limit[joint] = abs(reached.value or 0.0) * (1.0 + share)
        limits = replace(tight, **{field: readonly(limit)})
        verdicts.append(verify(model, motion, goals=(), limits=limits).verified)
    assert deciding.verdicts == before + len(verdicts)
    assert not verdicts[0] and verdicts[-1] and verdicts == sorted(verdicts)


def test_a_decision_measures_less(tmp_path: Path) -> None:
    model = reduced(walled(tmp_path), THERE_AND_BACK[0])
    motion = quintic(model, THERE_AND_BACK, 1.0)
    decided, certified = Judge(model).decide(motion, NOTHING), Judge(model).certify(motion, NOTHING)
    assert decided.verified and certified.verified
    assert 2 * decided.counts.kinematics < certified.counts.kinematics
    assert 2 * decided.counts.distances < certified.counts.distances
