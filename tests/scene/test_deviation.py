"""No point of a robot is farther off than is said, wherever it stands and however its joints are off."""

import numpy as np
import pytest

import trajopt as to
from trajopt.scene.deviation import largest_deviation
from trajopt.values.shapes.shapes import bounding_box


@pytest.mark.parametrize("name", ["cup_past_pillar", "past_pillar_ur5", "past_pillar_xarm7", "planar_fold"])
def test_no_body_is_farther_off(name: str) -> None:
    try:
        reduced = to.named_problem(name).reduced
    except to.MissingExtra as error:
        pytest.skip(str(error))
    rng = np.random.default_rng(0)
    limits, errors = reduced.limits, np.full(len(reduced.joint_names), 2e-3)
    bound, worst = largest_deviation(reduced, errors), 0.0
    scene = reduced.scene
    for _ in range(50):
        here = rng.uniform(limits.lower, limits.upper)
        there = here + errors * rng.choice((-1.0, 1.0), len(errors))
        places = [reduced.all_positions(each) for each in (here, there)]
        for body in reduced.bodies:
            if body.joint == 0:
                continue
            lower, upper = bounding_box(body.shape)
            corners = np.where(np.indices((2, 2, 2)).reshape(3, 8).T, upper, lower)
            # Bodies are placed in joints: their owners' frames place them in the world.
            frame, placed = body.owner, None
            for each in (*scene.robot.bodies, *scene.object_bodies()):
                if each.owner == body.owner and each.shape is body.shape:
                    frame, placed = each.frame, each.placement
            assert placed is not None
            seen = [scene.placement_of(frame, place) * (placed * corners) for place in places]
            worst = max(worst, float(np.linalg.norm(seen[1] - seen[0], axis=1).max()))
    assert worst <= bound
    assert bound <= 6.0 * worst
