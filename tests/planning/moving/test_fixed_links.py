"""A link that no joint moves, met by something: no motion is to blame, and none changes it."""

from dataclasses import replace

import pytest
from trajopt.ros.commander.moveit_msgs.msg import MoveItErrorCodes

import trajopt as to
from trajopt.planning.status import Certainty
from trajopt.server.move_group.outcome import code_of

FAST = to.Budget(attempts=1)
UNDER = 0.02
"""Half the thickness of the base, whose middle is at a height of 0 [m]: the arm moves in that of 0.1 m."""


def problem(scene: to.Scene) -> to.Problem:
    goal = to.joint_positions({"shoulder": 1.5, "elbow": 0.0})
    return to.Problem(scene=scene, group="arm", start={"shoulder": 0.0, "elbow": 0.0}, goal=goal)


def passing(robot: to.Robot, begin: float, end: float) -> to.Scene:
    """Return a scene with a ball that rolls beneath the arm, and 10 mm into its base."""
    places = [to.placement((x, 0.0, -UNDER - 0.03)) for x in (-1.0, 1.0)]
    return to.Scene(robot).add("ball", to.Sphere(0.04), motion=to.Track.through([begin, end], places))


def test_an_obstacle_that_meets_the_base_is_reported_without_a_motion(planar_arm: to.Robot) -> None:
    result = to.plan(problem(passing(planar_arm, 0.0, 1.0)), budget=FAST)
    assert result.status is to.Status.FIXED_LINK_MET and result.certainty is Certainty.PROVEN
    assert "ball meets base, which no joint of the group moves, from 0.4" in result.reason
    assert "no motion within the limits is over before 0.9" in result.reason
    assert "escapes" not in result.reason
    (block,) = result.blocks
    assert block.subjects == ("base", "ball") and block.amount == pytest.approx(0.01, abs=1e-3)
    assert block.begin is not None and block.end is not None and 0.4 < block.begin < 0.5 < block.end < 0.6
    assert code_of(result).val == MoveItErrorCodes.START_STATE_IN_COLLISION
    assert not to.plan(problem(passing(planar_arm, 0.0, 1.0)), budget=to.Budget(attempts=3)).verified


def test_a_motion_that_ends_before_the_base_is_met_is_accepted(planar_arm: to.Robot) -> None:
    alone = to.plan(problem(to.Scene(planar_arm))).require().trajectory.duration
    result = to.plan(problem(passing(planar_arm, 1.1 * alone, 1.1 * alone + 1.0)), budget=FAST)
    assert result.verified
    stays = replace(problem(passing(planar_arm, 1.1 * alone, 1.1 * alone + 1.0)), dwell=10.0)
    refused = to.plan(stays, budget=FAST)
    assert refused.status is to.Status.FIXED_LINK_MET and refused.certainty is Certainty.PROVEN
    assert "and then stays for 10 s" in refused.reason


def test_without_a_proof_that_nothing_is_faster_it_is_evidence(planar_arm: to.Robot) -> None:
    alone = to.plan(problem(to.Scene(planar_arm))).require().trajectory.duration
    # The base is met when the motion is nearly over.
    result = to.plan(problem(passing(planar_arm, alone - 0.6, alone + 0.4)), budget=FAST)
    assert result.status is to.Status.FIXED_LINK_MET and result.certainty is Certainty.EVIDENCE
    assert f"the motion without what changes takes {alone:.2f} s" in result.reason


def test_the_blocking_obstacle_and_the_deadline_of_the_base_are_both_reported(planar_arm: to.Robot) -> None:
    post = to.placement((0.5, 0.45, 0.1))
    scene = passing(planar_arm, 5.0, 6.0).add("post", to.Cylinder(0.05, 0.5), post, appears=0.1)
    scene = scene.add("wall", to.Box(0.02, 0.02, 0.5), to.placement((0.22, 0.2, 0.1)), appears=0.1)
    result = to.plan(problem(scene), budget=FAST)
    assert result.status is to.Status.BLOCKED_IN_TIME
    assert "a motion has to be over before ball meets base" in result.reason


def test_the_two_may_be_let_touch(planar_arm: to.Robot) -> None:
    found = to.plan(problem(passing(planar_arm, 0.0, 1.0)), budget=FAST).explain(plan_again=True)
    assert found.status is to.Status.FIXED_LINK_MET and "as near to each other whatever" in str(found)
    assert found.remedies is not None
    remedy = next(item for item in found.remedies if item.what == "contact of base and ball")
    assert remedy.result.verified and "let ball touch base" in str(found)


def test_a_link_of_another_group_is_not_moved_either(planar_arm: to.Robot) -> None:
    goal = to.joint_positions({"left_slide": 0.04})
    places = [to.placement((0.25, y, 0.1)) for y in (-1.0, 1.0)]
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.05), motion=to.Track.through([0.0, 0.5], places))
    asked = to.Problem(scene=scene, group="gripper", start={"left_slide": 0.0}, goal=goal)
    result = to.plan(asked, budget=FAST)
    assert result.status is to.Status.FIXED_LINK_MET and result.blocks[0].subjects == ("upper", "ball")
