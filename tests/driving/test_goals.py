"""Several goals, goals passed within a radius, and moving goals."""

from collections.abc import Callable
from dataclasses import replace
from math import inf

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import Event, EventKind, IdealExecutor, Supervisor, SupervisorOptions
from trajopt.values.arrays import Floats
from trajopt.values.errors import FrameNotFound, ProblemError
from trajopt.verify import Judge

CYCLE = 0.02
DOWN = (np.pi, 0.0, 0.0)
NEAR, FAR = (0.45, -0.25, 0.45), (0.45, 0.25, 0.45)
TOOL = "panda_hand_tcp"


@pytest.fixture(scope="module")
def problem() -> to.Problem:
    """A Panda above a table."""
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    scene = to.Scene(panda).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    return to.Problem(scene=scene, group="panda_arm", start="ready", goal=above(NEAR))


def above(point: tuple[float, float, float]) -> to.Requirement:
    return to.frame_placement(TOOL, to.placement(point, rpy=DOWN))


def supervised(
    problem: to.Problem, options: SupervisorOptions | None = None
) -> tuple[IdealExecutor, Supervisor]:
    arm = IdealExecutor(problem.scene.robot.joint_names, problem.start_positions)
    return arm, Supervisor(arm, problem, options or SupervisorOptions())


def drive(
    arm: IdealExecutor,
    supervisor: Supervisor,
    until: float = 20.0,
    each: Callable[[float], None] | None = None,
) -> list[tuple[float, Floats, Floats]]:
    """Cycle until all is done; return times, positions and velocities of the joints, every 5 ms."""
    driven: list[tuple[float, Floats, Floats]] = []
    while supervisor.busy and arm.now() < until - 1e-9:
        if each is not None:
            each(arm.now())
        supervisor.cycle()
        for _ in range(4):
            state = arm.state()
            driven.append((state.stamp, state.positions, state.velocities))
            arm.advance(CYCLE / 4)
    return driven


def kinds(supervisor: Supervisor) -> list[EventKind]:
    return [event.kind for event in supervisor.events]


def first(supervisor: Supervisor, kind: EventKind) -> Event:
    return next(event for event in supervisor.events if event.kind is kind)


def tool_at(problem: to.Problem, positions: Floats) -> Floats:
    return problem.scene.placement_of(TOOL, positions).translation


def holds(problem: to.Problem, positions: Floats, goal: to.Requirement) -> bool:
    columns = problem.scene.robot.index(problem.reduced.joint_names)
    return all(check.holds for check in Judge(problem.reduced).check(positions[columns], [goal]))


def test_no_margins_are_measured_before_a_motion_without_waypoints_begins(
    problem: to.Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    arm, supervisor = supervised(problem)
    monkeypatch.setattr(Judge, "certify", lambda *_: pytest.fail("a certificate was measured"))
    supervisor.go(problem)
    drive(arm, supervisor)
    assert kinds(supervisor) == [EventKind.STARTED, EventKind.REACHED]


def test_next_goal_is_planned_during_the_motion_and_begun_without_a_pause(
    problem: to.Problem,
) -> None:
    arm, supervisor = supervised(problem)
    supervisor.go(problem)
    supervisor.then(replace(problem, goal=above(FAR)))
    driven = drive(arm, supervisor)
    assert kinds(supervisor) == [EventKind.STARTED, EventKind.REACHED, EventKind.REACHED]
    assert len(supervisor.seconds["plan"]) == len(supervisor.seconds["plan ahead"]) == 1
    reached = first(supervisor, EventKind.REACHED).time
    here = min(driven, key=lambda row: float(np.linalg.norm(tool_at(problem, row[1]) - NEAR)))
    assert reached - CYCLE - 1e-9 <= here[0] <= reached + 1e-9
    rests = sum(not velocities.any() for time, _, velocities in driven if time > 0.2) * CYCLE / 4
    assert rests < 3 * CYCLE
    assert holds(problem, arm.state().positions, above(FAR))


def test_a_goal_with_a_blend_radius_is_passed_within_it_without_a_stop(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    supervisor.go(problem, blend_radius=0.06)
    supervisor.then(replace(problem, goal=above(FAR)))
    driven = drive(arm, supervisor)
    assert kinds(supervisor) == [EventKind.STARTED, EventKind.PASSED, EventKind.REACHED]
    away = min(float(np.linalg.norm(tool_at(problem, row[1]) - NEAR)) for row in driven)
    assert away <= 0.06 + 1e-3
    begins, ends = first(supervisor, EventKind.STARTED).time + 0.2, driven[-1][0] - 0.15
    slowest = min(np.abs(rate).max() for time, _, rate in driven if begins < time < ends)
    assert slowest > 0.05
    stopping, patient = supervised(problem)
    patient.go(problem)
    patient.then(replace(problem, goal=above(FAR)))
    drive(stopping, patient)
    assert arm.now() < stopping.now()


def test_many_goals_are_passed_in_order(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    places = [NEAR, (0.55, 0.0, 0.5), FAR, (0.4, 0.0, 0.6)]
    for number, place in enumerate(places):
        supervisor.then(replace(problem, goal=above(place)), blend_radius=0.05 if number % 2 else 0.0)
    drive(arm, supervisor)
    ends = [kind for kind in kinds(supervisor) if kind in (EventKind.PASSED, EventKind.REACHED)]
    assert len(ends) == 4 and ends[0] is ends[2] is ends[3] is EventKind.REACHED
    assert EventKind.STOPPING not in kinds(supervisor)
    assert holds(problem, arm.state().positions, above(places[-1]))


def test_a_next_goal_that_cannot_be_reached_leaves_the_robot_at_the_first(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    supervisor.go(problem, blend_radius=0.06)
    supervisor.then(replace(problem, goal=above((2.0, 0.0, 0.4))))
    drive(arm, supervisor, 6.0)
    assert holds(problem, arm.state().positions, above(NEAR))
    assert not arm.state().velocities.any()
    said = first(supervisor, EventKind.NO_PLAN)
    assert "to the next goal" in said.words and said.time < first(supervisor, EventKind.REACHED).time
    assert EventKind.STOPPING not in kinds(supervisor) and supervisor.blocked


def test_obstacle_on_the_way_to_the_next_goal_is_avoided(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    supervisor.go(problem, blend_radius=0.05)
    supervisor.then(replace(problem, goal=above(FAR)))
    crate = problem.scene.add("crate", to.Box(0.1, 0.05, 0.2), to.placement((0.5, 0.05, 0.4)))
    judge = Judge(replace(problem, scene=crate).reduced)

    def appears(now: float) -> None:
        if now > 0.5 and supervisor.scene is not crate:
            supervisor.see(crate)

    columns = problem.scene.robot.index(problem.reduced.joint_names)
    for _, positions, _ in drive(arm, supervisor, each=appears):
        assert judge.examine(positions[columns]).clear
    assert kinds(supervisor)[-1] is EventKind.REACHED
    assert EventKind.UNPROVEN_STOP not in kinds(supervisor)
    assert holds(problem, arm.state().positions, above(FAR))


def with_cup(problem: to.Problem, y: float) -> to.Scene:
    """The world as a camera sees it: the cup, a quarter of a metre below where the tool is to go."""
    where = to.placement((0.5, y, 0.05))
    if "cup" in problem.scene.objects:
        return problem.scene.move("cup", where)
    return problem.scene.add("cup", to.Cylinder(radius=0.03, length=0.1), where)


ABOVE_CUP = to.placement((0.0, 0.0, 0.3), rpy=DOWN)


def test_moving_frame_is_followed_and_reached_at_its_rest(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    scene = with_cup(problem, -0.2)
    supervisor.see(scene)
    supervisor.follow_goal("cup", offset=ABOVE_CUP, tool=TOOL)

    def moves(now: float) -> None:
        supervisor.see(scene.move("cup", to.placement((0.5, min(-0.2 + 0.3 * now, 0.1), 0.05))))

    drive(arm, supervisor, each=moves)
    assert kinds(supervisor)[-1] is EventKind.REACHED and kinds(supervisor).count(EventKind.REACHED) == 1
    assert kinds(supervisor).count(EventKind.REPLANNED) >= 3
    assert EventKind.STOPPING not in kinds(supervisor)
    assert tool_at(problem, arm.state().positions) == pytest.approx((0.5, 0.1, 0.35), abs=3e-3)


def test_a_world_without_the_followed_frame_is_refused_and_changes_nothing(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    supervisor.see(with_cup(problem, -0.2))
    supervisor.follow_goal("cup", offset=ABOVE_CUP, tool=TOOL)
    supervisor.cycle()
    with pytest.raises(FrameNotFound, match="cup"):
        supervisor.see(problem.scene)
    drive(arm, supervisor)
    assert kinds(supervisor)[-1] is EventKind.REACHED


def test_function_returns_the_goal_or_none(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)

    def seen() -> to.Requirement | None:
        now = arm.now()
        return None if 0.1 < now < 0.2 else above(NEAR if now < 0.15 else FAR)

    supervisor.follow_goal(seen)
    drive(arm, supervisor)
    assert kinds(supervisor) == [EventKind.STARTED, EventKind.REPLANNED, EventKind.REACHED]
    assert 0.2 <= first(supervisor, EventKind.REPLANNED).time < 0.25
    assert holds(problem, arm.state().positions, above(FAR))


def test_a_goal_is_held_for_a_time_before_it_is_reached(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    supervisor.follow_goal(lambda: above(NEAR), hold=0.5)
    rests: list[float] = []

    def stands(now: float) -> None:
        if now > 0.2 and not supervisor.moving:
            rests.append(now)

    drive(arm, supervisor, each=stands)
    assert rests[-1] - rests[0] == pytest.approx(0.5, abs=2.5 * CYCLE)
    assert not supervisor.busy


def test_goal_with_infinite_hold_is_followed_again_after_a_rest(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    supervisor.follow_goal(lambda: above(NEAR if arm.now() < 3.0 else FAR), hold=inf)
    drive(arm, supervisor, 6.0)
    assert supervisor.busy and not supervisor.moving
    assert holds(problem, arm.state().positions, above(FAR))
    supervisor.stop()
    assert not supervisor.busy


def test_frame_on_a_track_is_met_at_the_end_of_the_motion(problem: to.Problem) -> None:
    """The cup is said once to be on its way: the motion leads to where it will be."""
    arm, supervisor = supervised(problem)
    track = to.Track.constant_velocity(to.placement((0.5, -0.2, 0.05)), (0.0, 0.3, 0.0), end=1.0)
    cup = problem.scene.add("cup", to.Cylinder(radius=0.03, length=0.1), motion=track)
    supervisor.see(cup, 0.0)
    supervisor.follow_goal("cup", offset=ABOVE_CUP, tool=TOOL)
    drive(arm, supervisor)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    assert EventKind.STOPPING not in kinds(supervisor)
    assert tool_at(problem, arm.state().positions) == pytest.approx((0.5, 0.1, 0.35), abs=3e-3)


def test_a_goal_out_of_reach_leaves_the_robot_at_the_last_one_and_is_tried_again(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem, SupervisorOptions(retry=0.5))
    away = above((2.0, 0.0, 0.4))
    supervisor.follow_goal(
        lambda: above(NEAR) if arm.now() < 0.3 else away if arm.now() < 3.0 else above(FAR)
    )
    drive(arm, supervisor, 2.9)
    assert holds(problem, arm.state().positions, above(NEAR)) and not arm.state().velocities.any()
    assert EventKind.NO_PLAN in kinds(supervisor) and EventKind.REACHED not in kinds(supervisor)
    drive(arm, supervisor)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    assert holds(problem, arm.state().positions, above(FAR))


def test_goals_are_checked_when_they_are_requested(problem: to.Problem) -> None:
    _, supervisor = supervised(problem)
    with pytest.raises(FrameNotFound, match="cup"):
        supervisor.follow_goal("cup")
    with pytest.raises(ProblemError, match="blend_radius must not be negative"):
        supervisor.go(problem, blend_radius=-0.1)
    with pytest.raises(ProblemError, match="tolerance must be positive"):
        supervisor.follow_goal(lambda: "ready", tolerance=0.0)
    track = to.Track.constant_velocity(to.placement((0.5, -0.2, 0.05)), (0.0, 0.1, 0.0))
    belt = problem.scene.add("belt", to.Box(0.1, 0.1, 0.1), motion=track)
    moving = replace(problem, scene=belt, goal=to.frame_placement(TOOL, ABOVE_CUP, reference="belt"))
    with pytest.raises(ProblemError, match="the goal moves with belt; use follow_goal"):
        supervisor.go(moving)
    assert not supervisor.busy


def test_replanned_motion_does_not_return_to_a_waypoint_that_it_passed(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    level = to.during(to.axis_alignment(TOOL, direction=(0, 0, -1), tolerance=0.4), until="near")
    supervisor.go(replace(problem, goal=above(FAR), waypoints={"near": above(NEAR)}, constraints=[level]))
    crate = problem.scene.add("crate", to.Box(0.1, 0.02, 0.3), to.placement((0.45, 0.1, 0.4)))

    way = [0.0]

    def crate_on_the_way_back(now: float) -> None:
        way.append(float(tool_at(problem, arm.state().commanded)[1]))
        if min(way) < NEAR[1] + 0.001 and way[-1] > -0.2 and supervisor.scene is not crate:
            supervisor.see(crate)

    driven = drive(arm, supervisor, each=crate_on_the_way_back)
    assert supervisor.events[-1].kind is EventKind.REACHED
    seen = first(supervisor, EventKind.WORLD_CHANGED).time
    assert min(tool_at(problem, row[1])[1] for row in driven if row[0] > seen) > -0.21
