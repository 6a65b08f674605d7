"""A curve among the path constraints of a problem: planned where the knots do, else `follow` is named."""

import trajopt as to
from trajopt.tasks.cartesian import follow, follows_curve, polyline


def test_a_failure_because_of_a_curve_names_follow() -> None:
    """Around a blended corner 24 knots do not hold a tenth of a millimetre; `follow` takes more."""
    scene = to.Scene(to.load("panda"))
    here = scene.placement_of("panda_hand_tcp", scene.robot.positions("ready"))
    corners = [here, here * to.placement((0, -0.2, 0)), here * to.placement((0, -0.2, 0.15))]
    curve = follows_curve("panda_hand_tcp", polyline(corners, blend=0.03))
    goal = to.frame_placement("panda_hand_tcp", corners[-1])
    problem = to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal, constraints=[curve])
    result = to.plan(problem, budget=to.Budget(attempts=1))
    assert result.status is to.Status.STUCK
    assert "trajopt.tasks.cartesian.follow is made for curves" in result.message
    assert follow(scene, curve, group="panda_arm", start="ready").fraction == 1.0
