"""What would help where things that move leave no motion: each change is planned, and so is half of it."""

from dataclasses import replace

import pytest

import trajopt as to
from trajopt.planning.status import Certainty
from trajopt.why.explain import changes_in_time
from trajopt.why.explanation import Explanation

PLANE = 0.1
"""Height at which the planar arm moves [m]."""
AT_GOAL, AWAY = to.placement((0.0, 0.75, PLANE)), to.placement((0.0, 3.0, PLANE))


def problem(scene: to.Scene) -> to.Problem:
    start, goal = {"shoulder": 0.0, "elbow": 0.0}, {"shoulder": 1.5, "elbow": 0.0}
    return to.Problem(scene=scene, group="arm", start=start, goal=to.joint_positions(goal))


def plan(asked: to.Problem) -> to.Result:
    return to.plan(asked, budget=to.Budget(attempts=2))


def explained(asked: to.Problem, *, plan_again: bool = True) -> Explanation:
    return to.explain(plan(asked), plan_again=plan_again, plan=plan)


def remedies(found: Explanation) -> dict[str, float]:
    assert found.remedies is not None
    for remedy in found.remedies:
        assert remedy.result.verified and not remedy.half.verified
        assert plan(remedy.problem).verified
    return {remedy.what: remedy.amount for remedy in found.remedies}


def test_an_obstacle_at_the_goal_is_removed_or_delayed(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.1), AT_GOAL, appears=0.1)
    found = explained(problem(scene))
    assert found.status is to.Status.GOAL_OCCUPIED and found.certainty is Certainty.PROVEN
    assert "in the way" in str(found).lower() and "remove ball" in str(found)
    by = remedies(found)
    assert by["ball"] == 1.0 and 0.0 < by["time of ball"] < 2.0
    assert "let ball appear" in str(found)
    assert found.as_dict()["remedies"]


def test_an_obstacle_that_sweeps_the_start_is_removed_or_avoided_by_another_start(
    planar_arm: to.Robot,
) -> None:
    fast = to.Track.through([0.0, 0.25], [to.placement((0.75, y, PLANE)) for y in (-1.0, 1.0)])
    found = explained(problem(to.Scene(planar_arm).add("ball", to.Sphere(0.2), motion=fast)))
    assert found.status is to.Status.INEVITABLE and found.configuration is not None
    by = remedies(found)
    assert by["ball"] == 1.0 and by["time of the start"] < 0.6
    assert "and be elsewhere before" in str(found)


def test_more_time_until_a_deadline_is_offered(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.1), AT_GOAL, expires=2.0)
    found = explained(replace(problem(scene), finish_by=1.9))
    assert remedies(found)["deadline"] == pytest.approx(0.2, abs=0.15)
    assert "more, until 2." in str(found)


def test_objects_on_a_removed_object_are_removed(planar_arm: to.Robot) -> None:
    track = to.Track.through([0.0, 0.3], [AWAY, AT_GOAL])
    scene = to.Scene(planar_arm).add("tray", to.Box(0.4, 0.4, 0.1), motion=track)
    scene = scene.add("cup", to.Sphere(0.05), to.placement((0.0, 0.0, 0.1)), frame="tray")
    result = plan(problem(scene))
    assert result.blocks
    (without,) = (
        change for change in changes_in_time(result.problem, result.blocks) if change.what == "tray"
    )
    assert not without.apply(1.0).scene.objects and without.apply(0.5) is result.problem


def test_without_planning_again_nothing_is_tried(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.1), AT_GOAL, appears=0.1)
    found = explained(problem(scene), plan_again=False)
    assert found.remedies is None and found.blocks and "closed" in found.grounds
