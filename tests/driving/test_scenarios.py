"""The execution scenarios of the benchmark end as expected, and regressions that they found."""

import numpy as np
import pytest

import trajopt as to
from benchmarks.execution_scenarios import SCENARIOS, cup, cycle, supervised, words_of
from trajopt.driving import EventKind, IdealExecutor, Supervisor, SupervisorOptions
from trajopt.planning import on_the_way

SLOW = {10}
"""It plans among what moves again and again; its fast twin is that of a cart that is seen again."""


@pytest.mark.timeout(280)
@pytest.mark.parametrize(
    "number", [pytest.param(each, marks=pytest.mark.slow if each in SLOW else ()) for each in SCENARIOS]
)
def test_scenario_ends_as_expected(number: int) -> None:
    try:
        outcome = SCENARIOS[number].play()
    except to.MissingExtra as error:
        pytest.skip(str(error))
    assert outcome.expected, outcome.happened


def problem_or_skip() -> to.Problem:
    try:
        return cup()
    except to.MissingExtra as error:
        pytest.skip(str(error))


def kinds(supervisor: Supervisor) -> list[EventKind]:
    return [event.kind for event in supervisor.events]


def with_cart(problem: to.Problem, spreads: float) -> to.Scene:
    """A cart stands beside the way; it may have moved off in any direction since."""
    stands = to.Track.constant_velocity(to.placement((0.45, 0.75, 0.3)), (0.0, 0.0, 0.0))
    cart = to.Prediction(stands, (0.02, spreads, 0.0))
    return problem.scene.add("cart", to.Box(0.3, 0.3, 0.6), motion=cart)


def test_resumes_the_path_when_an_obstacle_is_seen_again() -> None:
    """It slows, stops and goes on, and no new plan is needed: the path is as clear as it was."""
    problem = problem_or_skip()
    arm, supervisor = supervised(problem)
    cycle(arm, supervisor, 0.1)
    supervisor.see(with_cart(problem, 0.4))
    cycle(arm, supervisor, 1.0)
    assert not arm.state().velocities.any()
    assert [kind for kind in kinds(supervisor)[:6] if kind is not EventKind.WORLD_CHANGED][:4] == [
        EventKind.STARTED, EventKind.SLOWING, EventKind.STALE, EventKind.STOPPING,
    ]  # fmt: skip
    assert "cart to within" in words_of(supervisor, EventKind.STALE)[0]
    supervisor.see(with_cart(problem, 0.02))
    cycle(arm, supervisor, 4.0)
    assert EventKind.RESUMED in kinds(supervisor) and kinds(supervisor)[-1] is EventKind.REACHED
    assert len(supervisor.seconds["plan"]) == 1
    assert arm.given is not None
    driven = arm.given.ahead(0.0, problem.reduced.joint_names)
    assert driven is not None and to.judge(on_the_way(problem, driven, 0.0), driven).verified


def passing(problem: to.Problem, begin: float, there: float) -> to.Scene:
    """A ball crosses where the tool passes, so far out of the way that only its time counts."""
    track = to.Track.through((begin, there, 2.0 * there - begin), [to.placement(p) for p in BALL])
    return problem.scene.add("ball", to.Sphere(0.06), motion=track)


BALL = ((0.95, 0.19, 0.27), (0.5, 0.19, 0.27), (0.95, 0.19, 0.27))


def test_retimes_the_path_for_a_passing_obstacle() -> None:
    problem = problem_or_skip()
    arm, supervisor = supervised(problem)
    cycle(arm, supervisor, 0.1)
    supervisor.see(passing(problem, 0.1, 0.6), 0.0)
    cycle(arm, supervisor, 6.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    assert EventKind.SLOWING in kinds(supervisor) and EventKind.STOPPING not in kinds(supervisor)
    assert "for ball" in words_of(supervisor, EventKind.SLOWING)[0]
    assert len(supervisor.seconds["plan"]) == 1
    assert arm.given is not None
    driven = arm.given.ahead(0.0, problem.reduced.joint_names)
    assert driven is not None
    among = to.Problem(
        scene=passing(problem, 0.1, 0.6), start=problem.start, goal=problem.goal, group=problem.group,
        constraints=problem.constraints,
    )  # fmt: skip
    assert to.judge(on_the_way(among, driven, 0.0), driven).verified


def test_replans_without_patience() -> None:
    problem = problem_or_skip()
    arm = IdealExecutor(problem.scene.robot.joint_names, problem.start_positions)
    supervisor = Supervisor(arm, problem, SupervisorOptions(patience=0.0))
    supervisor.go(problem)
    cycle(arm, supervisor, 0.1)
    supervisor.see(passing(problem, 0.1, 0.6), 0.0)
    cycle(arm, supervisor, 0.16)
    assert len(supervisor.seconds["plan"]) == 2 and "retime" not in supervisor.seconds


def test_resumes_the_path_after_missing_cycles() -> None:
    problem = problem_or_skip()
    arm, supervisor = supervised(problem)
    cycle(arm, supervisor, 0.2)
    arm.advance(0.5)
    assert not arm.state().velocities.any()
    cycle(arm, supervisor, 4.0)
    assert list(dict.fromkeys(kinds(supervisor))) == [
        EventKind.STARTED, EventKind.STOPPING, EventKind.RESUMED, EventKind.REACHED,
    ]  # fmt: skip
    assert len(supervisor.seconds["plan"]) == 1
    assert np.abs(arm.state().velocities).max() == 0.0
