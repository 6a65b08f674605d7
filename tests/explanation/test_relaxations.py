"""Every built-in requirement can be relaxed, and then holds wherever it held before."""

import numpy as np
import pytest

import trajopt as to
from trajopt.cartesian import follows_curve, line
from trajopt.model import requirements
from trajopt.model.requirements import Requirement
from trajopt.query import Query
from trajopt.terms import constrain
from trajopt.terms.motion import Motion
from trajopt.terms.residual import WHOLE

HERE = to.placement((0.4, 0.1, 0.2))
EXAMPLES: list[Requirement] = [
    to.joint_positions({"elbow": 0.2}, tolerance=0.1),
    to.coupled_joints({"elbow": 1.0, "wrist": -1.0}, tolerance=0.1),
    to.frame_placement("tip", HERE, position_tolerance=0.05, rotation_tolerance=0.3),
    to.axis_alignment("tip", tolerance=0.3),
    to.position_in_region("tip", to.Box(0.2, 0.1, 0.1), HERE),
    to.position_in_region("tip", to.Sphere(0.1), HERE),
    to.position_in_region("tip", to.Cylinder(0.1, 0.3), HERE),
    to.position_in_region("tip", to.Plane(), HERE),
    to.point_on_arc("tip", HERE, radius=0.2, tolerance=0.02),
    to.distance_between("tip", "world", lower=0.7, upper=0.8),
    to.gaze("tip", (1.0, 0.0, 0.0), angle=0.4),
    to.singularity_distance("tip", 0.05, length=0.0),
    to.line_of_sight("tip", (1.0, 0.5, 0.2), margin=0.05),
    to.gravity_torque(0.05),
    follows_curve("tip", line(HERE, to.placement((0.5, 0.1, 0.2))), position_tolerance=0.01),
]


@pytest.mark.parametrize("required", EXAMPLES, ids=lambda item: type(item).__name__)
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


def test_every_kind_has_an_example() -> None:
    kinds = {
        value
        for value in vars(requirements).values()
        if isinstance(value, type) and issubclass(value, Requirement) and value is not Requirement
    }
    assert {type(item) for item in EXAMPLES} == kinds
