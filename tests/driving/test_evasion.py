"""Stops that turn away: proven where neither a stop on the path nor one of all joints is."""

import numpy as np
import pytest

import trajopt as to
from tests.driving.test_supervisor import CYCLE
from trajopt.driving import EventKind, IdealExecutor, Supervisor
from trajopt.driving import soonest_stop as stops
from trajopt.verify import examine


@pytest.fixture(scope="module")
def problem() -> to.Problem:
    try:
        return to.named_problem("past_pillar_xarm7")
    except to.MissingExtra as error:
        pytest.skip(str(error))


def surprised(problem: to.Problem, place: tuple[float, float, float]) -> tuple[IdealExecutor, Supervisor]:
    """Drive for 0.2 s; then a cube is seen close to the tool, and the next cycle stops for it."""
    arm = IdealExecutor(problem.scene.robot.joint_names, problem.start_positions)
    arm.tolerance[:] = 1e-4
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    while arm.now() < 0.2 - 1e-9:
        supervisor.cycle()
        arm.advance(CYCLE)
    supervisor.see(problem.scene.add("cube", to.Box(0.08, 0.08, 0.08), to.placement(place)))
    supervisor.cycle()
    return arm, supervisor


@pytest.mark.parametrize(
    "place",
    [(0.432, -0.111, 0.53), (0.432, -0.137, 0.616), (0.374, -0.176, 0.593), (0.495, -0.187, 0.46)],
)
def test_robot_turns_away_if_no_other_stop_is_clear(
    problem: to.Problem, place: tuple[float, float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    arm, supervisor = surprised(problem, place)
    kinds = [event.kind for event in supervisor.events]
    assert EventKind.STOPPING in kinds and EventKind.UNPROVEN_STOP not in kinds
    reduced = to.Problem(
        scene=supervisor.scene, group=problem.group, start=problem.start_positions, goal=problem.goal
    ).reduced
    columns = problem.scene.robot.index(problem.reduced.joint_names)
    last = supervisor.committed.end
    while arm.now() < last:
        arm.advance(2e-3)
        assert examine(reduced, arm.state().positions[columns]).clear
    assert not arm.state().velocities.any()
    monkeypatch.setattr(stops, "evading_stops", lambda *others: iter(()))
    _, without = surprised(problem, place)
    words = {event.kind: event.words for event in without.events}
    assert words[EventKind.UNPROVEN_STOP].startswith("no clear stop was found: "), "another stop is clear"


def test_robot_that_is_already_too_near_does_not_turn_away(problem: to.Problem) -> None:
    robot = problem.scene.robot
    arm, supervisor = surprised(problem, (5.0, 5.0, 5.0))
    here = np.array(problem.start_positions)
    here[robot.index(arm.joint_names)] = supervisor.committed(arm.now())[0]
    tool = problem.scene.placement_of("link7", robot.followed(here)).translation
    supervisor.see(problem.scene.add("cube", to.Box(0.08, 0.08, 0.08), to.placement(tool)))
    supervisor.cycle()
    unproven = [event for event in supervisor.events if event.kind is EventKind.UNPROVEN_STOP]
    assert len(unproven) == 1 and "cube" in unproven[0].words
    assert unproven[0].words.startswith("the robot is too near to an obstacle when a stop can begin: ")
