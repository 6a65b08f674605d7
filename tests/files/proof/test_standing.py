"""A motion that is proven in one scene, in scenes with moved objects."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import trajopt as to
from tests.files.proof.conftest import requirements_problem
from tests.files.proof.test_clouds import measured_post, past
from trajopt.files.proof import StandingMotion, standing
from trajopt.values.errors import ProblemError


@pytest.fixture(scope="module")
def held(planar_plan: to.Plan) -> StandingMotion:
    return StandingMotion(planar_plan.problem, planar_plan.trajectory)


@pytest.fixture
def unjudged(monkeypatch: pytest.MonkeyPatch) -> None:
    def judge(*_: object) -> None:
        raise AssertionError("the motion was judged again")

    monkeypatch.setattr(standing, "judge", judge)


@pytest.mark.usefixtures("unjudged")
def test_an_object_that_moves_far_away_needs_no_judge(held: StandingMotion) -> None:
    scene = held.problem.scene
    assert held.proven_in(scene)
    assert held.proven_in(scene.move("post", to.placement((2.0, 0.3, 0.1))))
    assert held.proven_in(scene.move("post", to.placement((0.65, 0.0, 0.9), rpy=(1.5, 0.2, 0.0))))


@pytest.mark.usefixtures("unjudged")
def test_an_object_may_move_beside_a_cloud() -> None:
    problem = past(measured_post())
    scene = problem.scene.add("other", to.Box(0.1, 0.1, 0.1), to.placement((2.0, 0.0, 0.1)))
    problem = replace(problem, scene=scene)
    held = StandingMotion(problem, to.plan(problem).require().trajectory)
    assert held.proven_in(scene.move("other", to.placement((2.0, 0.3, 0.1))))


def test_answers_are_those_of_the_judge(held: StandingMotion) -> None:
    rng, scene, seen = np.random.default_rng(3), held.problem.scene, set[bool]()
    for _ in range(40):
        where = to.placement((*rng.uniform(-1.2, 1.2, 2), 0.1), rpy=rng.uniform(-1.0, 1.0, 3))
        moved = scene.move("post", where)
        verified = to.judge(replace(held.problem, scene=moved), held.trajectory).verified
        assert held.proven_in(moved) == verified
        seen.add(verified)
    assert seen == {True, False}


def test_balls_of_the_motion_show_that_objects_of_each_shape_keep_apart(
    planar_plan: to.Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Near objects need the finest balls; none of them is shown to be apart that the judge refuses."""
    rng, shown, problem = np.random.default_rng(5), 0, planar_plan.problem
    shapes = to.Box(0.1, 0.2, 0.1), to.Sphere(0.05), to.Capsule(0.03, 0.2), to.Cone(0.05, 0.2)
    for shape in shapes:
        scene = problem.scene.add("thing", shape, to.placement((2.0, 0.0, 0.0)))
        held = StandingMotion(replace(problem, scene=scene), planar_plan.trajectory)
        with monkeypatch.context() as patch:
            patch.setattr(standing, "judge", lambda *_: SimpleNamespace(verified=False))
            for _ in range(30):
                where = to.placement(
                    rng.uniform((-1.0, -1.0, -0.2), (1.2, 1.2, 0.4)), rpy=rng.uniform(-2.0, 2.0, 3)
                )
                moved = scene.move("thing", where)
                if held.proven_in(moved):
                    shown += 1
                    assert to.judge(replace(problem, scene=moved), planar_plan.trajectory).verified
    assert 60 < shown < 120


@pytest.mark.usefixtures("unjudged")
def test_other_changes_are_judged(held: StandingMotion) -> None:
    scene = held.problem.scene
    box = scene.add("box", to.Box(0.1, 0.1, 0.1), to.placement((2.0, 0.0, 0.0)))
    plane = to.Scene(scene.robot).add("plane", to.Plane(), to.placement((0.0, 0.0, -1.0)))
    for changed in (box, scene.remove("post"), scene.with_clearance(0.1), plane):
        with pytest.raises(AssertionError, match="judged again"):
            held.proven_in(changed)


def test_requirements_that_depend_on_all_objects_are_judged(
    planar_plan: to.Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = replace(planar_plan.problem, waypoints=())
    sight = to.line_of_sight("tool", (0.0, 0.0, 3.0), origin=(0.0, 0.0, 0.2))
    seeing = StandingMotion(replace(problem, constraints=(sight,)), planar_plan.trajectory)
    asked: list[object] = []
    monkeypatch.setattr(standing, "judge", lambda given, _: asked.append(given) or planar_plan.certificate)
    seeing.proven_in(problem.scene.move("post", to.placement((2.0, 0.3, 0.1))))
    assert asked


def test_a_motion_that_is_refused_does_not_stand(planar_plan: to.Plan) -> None:
    with pytest.raises(ProblemError, match="judge refuses"):
        StandingMotion(requirements_problem(), planar_plan.trajectory)
