"""An explanation as a picture: words above, and what is in the way in red."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.simulation import RenderingUnavailable
from trajopt.viewer import draw_explanation
from trajopt.viewer.explained import _clock, _with_goals

START = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}


def red_share(path: Path) -> float:
    """Share of the picture that is clearly red."""
    with Image.open(path) as image:
        red, green, blue = np.moveaxis(np.asarray(image.convert("RGB")).astype(float), 2, 0)
    return float(((red > 1.6 * green) & (red > 1.6 * blue) & (red > 80.0)).mean())


@pytest.mark.parametrize("pan", [0.0, 1.0, 2.0], ids=["in collision", "on the way", "free"])
def test_only_the_obstacle_is_red(tmp_path: Path, pan: float) -> None:
    robot = odd_arm(tmp_path)
    scene = to.Scene(robot).add("post", to.Cylinder(0.06, 1.0), to.placement((0.6, 0.0, 0.3)))
    if pan == 1.0:
        scene = scene.add("sheet", to.Box(1.6, 0.02, 3.0), to.placement((0.95, 0.0, 0.0)))
    goal = to.joint_positions({**START, "pan": pan})
    found = to.plan(to.Problem(scene=scene, start=START, goal=goal)).explain()
    assert (found.status is to.Status.SOLVED) is (pan == 2.0)
    try:
        path = draw_explanation(found, tmp_path / "why.png", width=320, height=240)
    except RenderingUnavailable as reason:
        pytest.skip(str(reason))
    with Image.open(path) as image:
        assert image.width == 320 and image.height > 240, "the words stand over the picture"
    # A thousandth is some 70 pixels: more than edges of another colour, less than anything drawn red.
    assert (red_share(path) > 0.001) is (pan != 2.0)


def test_a_goal_out_of_reach_is_drawn_as_a_ball(tmp_path: Path) -> None:
    robot = odd_arm(tmp_path)
    goal = to.frame_placement("tip", to.placement((1.4, 0.0, 0.3)), rotation_tolerance=np.inf)
    found = to.plan(to.Problem(scene=to.Scene(robot), start=START, goal=goal)).explain()
    try:
        path = draw_explanation(found, tmp_path / "why.png", width=320, height=240)
    except RenderingUnavailable as reason:
        pytest.skip(str(reason))
    assert 0.0 < red_share(path) < 0.05
    assert not found.problem.scene.objects, "the problem itself has no such thing"


def test_a_dynamic_obstacle_is_drawn_at_the_time_of_blocking(tmp_path: Path) -> None:
    robot = odd_arm(tmp_path)
    goal = {**START, "pan": 1.0}
    there = to.Scene(robot).placement_of("tip", robot.positions(goal)).translation
    comes = to.Track.through(
        (0.0, 0.2), [to.placement(there + np.array((9.0, 0.0, 0.0))), to.placement(there)]
    )
    scene = to.Scene(robot).add("ball", to.Sphere(0.08), motion=comes)
    found = to.plan(to.Problem(scene=scene, start=START, goal=to.joint_positions(goal))).explain()
    assert found.status is not to.Status.SOLVED and "ball" in str(found)
    try:
        path = draw_explanation(found, tmp_path / "why.png", width=320, height=240)
    except RenderingUnavailable as reason:
        pytest.skip(str(reason))
    seen = _with_goals(found.problem, _clock(found)).scene.objects["ball"].placement.translation
    assert np.linalg.norm(seen - there) < 0.2
    assert red_share(path) > 0.005
