"""Body speeds: no pair approaches faster than its bound, for any joint velocities."""

import numpy as np
import pytest

import trajopt as to
from trajopt.driving.servo_program import BodySpeeds
from trajopt.geometry import Query
from trajopt.scene.reducing import reduce_model

STEP = 1e-6


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_no_distance_shrinks_faster(name: str) -> None:
    robot = to.load(name)
    scene = to.Scene(robot).add("box", to.Box(0.2, 0.2, 0.2), to.placement((0.6, 0.2, 0.3)))
    group = next(iter(robot.groups))
    reduced, rng = reduce_model(scene, group, np.zeros(len(robot.joint_names))), np.random.default_rng(3)
    query, speeds = Query(reduced), BodySpeeds(reduced)
    wide, tightest = np.full(len(reduced.pairs.first), 10.0), np.inf
    limits = reduced.limits
    lower, upper = np.maximum(limits.lower, -2.0), np.minimum(limits.upper, 2.0)
    for _ in range(60):
        at = rng.uniform(lower, upper)
        middle, spread = rng.uniform(-1.0, 1.0, (2, len(at)))
        low, high = middle - np.abs(spread) * 0.3, middle + np.abs(spread) * 0.3
        most = speeds.nearer(query.kinematics(at[None]), low, high)
        rates = rng.uniform(low, high)
        before, after = (query.close_pairs(each[None], wide) for each in (at, at + STEP * rates))
        then = dict(zip(after.pair.tolist(), after.distance.tolist(), strict=True))
        for pair, distance in zip(before.pair.tolist(), before.distance.tolist(), strict=True):
            if distance > 1e-3:
                nearing = (distance - then[pair]) / STEP
                assert nearing <= most[pair] + 1e-3
                tightest = min(tightest, float(most[pair] - nearing))
    assert tightest < 0.2
