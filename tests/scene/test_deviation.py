"""No point of a robot is farther off than is said, wherever it stands and however its joints are off."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.scene.model_error import largest_deviation
from trajopt.values.arrays import Floats
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


def facing_arms(path: Path) -> to.Problem:
    """Two arms of one joint each, a bar of 0.5 m, whose tips are 0.1 m apart at zero."""
    text = '<robot name="two"><link name="base"/>'
    for name, x, along in (("left", -0.55, 1.0), ("right", 0.55, -1.0)):
        text += (
            f'<link name="{name}"><collision><origin xyz="{0.25 * along} 0 0"/><geometry>'
            f'<box size="0.5 0.05 0.05"/></geometry></collision></link><joint name="{name}_joint" '
            f'type="revolute"><parent link="base"/><child link="{name}"/><origin xyz="{x} 0 0"/>'
            '<axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="50" velocity="2"/></joint>'
        )
    path.write_text(text + "</robot>")
    robot = to.Robot.from_urdf(path)
    return to.Problem(
        scene=to.Scene(robot), start=dict.fromkeys(robot.joint_names, 0.0), goal={"left_joint": 1.0}
    )


def test_two_arms_that_are_off_towards_each_other_count_both(tmp_path: Path) -> None:
    reduced = facing_arms(tmp_path / "two.urdf").reduced
    scene, errors = reduced.scene, np.full(2, 1e-3)
    tips = (("left", np.array((0.5, 0.0, 0.0))), ("right", np.array((-0.5, 0.0, 0.0))))

    def apart(positions: Floats) -> float:
        placed = [scene.placement_of(link, reduced.all_positions(positions)) * tip for link, tip in tips]
        return float(np.linalg.norm(placed[0] - placed[1]))

    # Both bars point the same way, side by side: each error brings its tip straight to the other.
    here = np.array((np.pi / 2.0, -np.pi / 2.0))
    nearer = max(
        apart(here) - apart(here + errors * np.array(signs)) for signs in ((1, 1), (-1, -1), (1, -1), (-1, 1))
    )
    alone = largest_deviation(reduced, errors * np.array((1.0, 0.0)))
    assert alone < nearer <= largest_deviation(reduced, errors)
