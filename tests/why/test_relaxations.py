"""Every built-in requirement can be relaxed, and then holds wherever it held before."""

import numpy as np
import pytest

import trajopt as to
from tests.problem.requirements.kind import kinds
from trajopt.geometry import Query
from trajopt.optimise.terms import constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import WHOLE


@pytest.mark.parametrize(
    "required", [item for kind in kinds() for item in kind.relaxed], ids=lambda item: type(item).__name__
)
def test_wider_is_weaker(arm: to.Robot, required: Requirement) -> None:
    scene = to.Scene(arm).add("post", to.Cylinder(0.1, 1.0), to.placement((0.7, 0.3, 0.0)))
    reduced = to.Problem(scene=scene, start={}, goal=to.joint_positions({"pan": 0.0})).reduced
    rng = np.random.default_rng(2)
    positions = rng.uniform(-1.5, 1.5, (300, 4)) * (1, 0.1, 1, 1) + (0, 0.15, 0, 0)
    motion = Motion.each(positions, Query(reduced))
    before = excess(required, motion)
    ways = required.relaxations
    assert ways
    for way in ways:
        amount = 0.4 * way.largest
        wider = way.apply(amount)
        after = excess(wider, motion)
        assert (after <= before + 1e-9).all()
        assert (after < before - 1e-6).any(), "nothing is gained"
        assert f"{way.now / way.unit.size:.3g} to" in way.words(amount)
        assert type(wider) is type(required)


def excess(required: Requirement, motion: Motion) -> np.ndarray:
    """How far each configuration is outside of what is required."""
    worst = np.zeros(len(motion.positions))
    for item in constrain(required, motion.query.reduced, WHOLE):
        rows = item.residual.linearise(motion)
        lower, upper = item.bounds(rows)
        outside = np.maximum(np.maximum(lower - rows.value, rows.value - upper), 0.0)
        np.maximum.at(worst, rows.knots[:, 0], outside)
    return worst
