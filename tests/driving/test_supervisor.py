"""A supervised robot is always committed to a proven stop, for any change of the world or planner."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from benchmarks.execution import STAGES
from tests.robots_for_tests import odd_arm
from trajopt.driving import EventKind, IdealExecutor, Supervisor
from trajopt.driving.active_motion import Pause
from trajopt.driving.commit_loop import Commitment
from trajopt.driving.intended_motion import FULL_SPEED, GuardedGoal, IntendedMotion
from trajopt.driving.motion_guard import MotionGuard, guard_of
from trajopt.driving.replanning import retime_on_path
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.optimise.methods.timing import stopping_motion
from trajopt.planning import on_the_way
from trajopt.timing.time_scaling import StopsAlong
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.verify import Judge, examine

CYCLE = 0.02


@pytest.fixture(scope="module")
def problem() -> to.Problem:
    try:
        return to.named_problem("cup_past_pillar")
    except to.MissingExtra as error:
        pytest.skip(str(error))


def supervised(problem: to.Problem) -> tuple[IdealExecutor, Supervisor]:
    arm = IdealExecutor(problem.scene.robot.joint_names, problem.start_positions)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    return arm, supervisor


def run(arm: IdealExecutor, supervisor: Supervisor, until: float) -> None:
    while supervisor.busy and arm.now() < until - 1e-9:
        supervisor.cycle()
        arm.advance(CYCLE)


class Slow(IdealExecutor):
    """So much time passes each time that a motion for it is looked for."""

    late: tuple[float, ...] = ()

    def splice(self, trajectory: to.Trajectory, at: float) -> str:
        if self.late:
            self.advance(self.late[0])
            self.late = self.late[1:]
        return super().splice(trajectory, at)


def slowly_supervised(problem: to.Problem) -> tuple[Slow, Supervisor]:
    arm = Slow(problem.scene.robot.joint_names, problem.start_positions)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    run(arm, supervisor, 0.2)
    assert arm.state().velocities.any()
    return arm, supervisor


@pytest.mark.parametrize("late", [(0.006,), (0.006, 0.02)])
def test_refused_stop_is_searched_again(problem: to.Problem, late: tuple[float, ...]) -> None:
    arm, supervisor = slowly_supervised(problem)
    arm.late = late
    taken = supervisor.stop()
    assert taken.proven and EventKind.UNPROVEN_STOP not in kinds(supervisor)
    assert kinds(supervisor).count(EventKind.REJECTED) == len(late)
    assert kinds(supervisor).count(EventKind.STOPPING) == 1
    arm.advance(taken.duration + 0.1)
    assert not arm.state().velocities.any() and not arm.fault()


def test_motors_brake_if_no_stop_is_accepted(problem: to.Problem) -> None:
    arm, supervisor = slowly_supervised(problem)
    arm.late = (0.006, 0.02, 0.05)
    taken = supervisor.stop()
    assert not taken.proven
    assert kinds(supervisor)[-2:] == [EventKind.STOPPING, EventKind.UNPROVEN_STOP]
    assert arm.fault() and not arm.state().velocities.any()


def kinds(supervisor: Supervisor) -> list[EventKind]:
    return [event.kind for event in supervisor.events]


def in_the_way(problem: to.Problem) -> to.Scene:
    """A box appears on the second half of the way."""
    return problem.scene.add("surprise", to.Box(0.1, 0.1, 0.1), to.placement((0.44, 0.15, 0.25)))


def test_reaches_the_goal_in_the_time_of_the_plan(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 10.0)
    assert kinds(supervisor) == [EventKind.STARTED, EventKind.REACHED]
    goal = to.judge(replace(problem, start=arm.state().positions), standing(problem, arm))
    assert goal.verified


def standing(problem: to.Problem, arm: IdealExecutor) -> to.Trajectory:
    names = problem.reduced.joint_names
    here = arm.state().positions[problem.scene.robot.index(names)]
    still = np.zeros((2, len(names)))
    return to.Trajectory(names, np.array((0.0, 0.1)), np.tile(here, (2, 1)), still, still)


@pytest.mark.parametrize("last", [0.1, 0.2, 0.35, 0.5])
def test_stops_on_the_path_without_cycles(problem: to.Problem, last: float) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, last)
    arm.advance(5.0)
    assert not arm.state().velocities.any()
    done = replace(problem, start=problem.start)
    path = to.plan(done).require().trajectory(np.linspace(0.0, 10.0, 20_000))
    here = arm.state().positions[problem.scene.robot.index(problem.reduced.joint_names)]
    assert np.abs(path - here).max(axis=1).min() < 2e-3


def test_goal_is_not_reached_at_a_stop_before_it(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    arm.advance(5.0)  # the loop pauses beyond the end of the whole motion
    supervisor.cycle()
    assert kinds(supervisor)[-1] is EventKind.STOPPING and supervisor.busy
    run(arm, supervisor, 20.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    reached = arm.state().positions[problem.scene.robot.index(problem.reduced.joint_names)]
    assert all(check.holds for check in Judge(problem.reduced).check(reached, problem.goals))


def test_committed_motion_is_proven_and_ends_at_rest_in_each_cycle(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    names = problem.reduced.joint_names
    while supervisor.busy:
        supervisor.cycle()
        arm.advance(CYCLE)
        ahead = arm.committed.ahead(arm.now(), names)
        if ahead is None:
            continue
        assert np.abs(ahead(ahead.duration, 1)).max() < 1e-12
        asked = on_the_way(replace(problem, goal=to.joint_positions(end(ahead))), ahead, 0.0)
        assert to.judge(asked, ahead).verified


def end(motion: to.Trajectory) -> dict[str, float]:
    return dict(zip(motion.joint_names, motion(motion.duration).tolist(), strict=True))


def test_change_elsewhere_does_not_slow_the_robot(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    supervisor.see(problem.scene.add("far", to.Box(0.1, 0.1, 0.1), to.placement((0.0, -0.8, 0.3))))
    run(arm, supervisor, 10.0)
    assert kinds(supervisor) == [
        EventKind.STARTED,
        EventKind.WORLD_CHANGED,
        EventKind.STILL_CLEAR,
        EventKind.REACHED,
    ]
    assert set(supervisor.seconds) <= {*STAGES, "plan ahead"}, "stages of the published table"


def test_line_of_sight_is_proven_past_objects_that_begin_to_move(problem: to.Problem) -> None:
    sight = to.line_of_sight("panda_hand_tcp", (0.0, 0.0, 1.5), ignore=["cup", "table", "pillar"])
    arm, supervisor = supervised(replace(problem, constraints=[*problem.constraints, sight]))
    run(arm, supervisor, 0.2)
    track = to.Track.constant_velocity(to.placement((0.0, -2.0, 0.3)), (0.0, -0.1, 0.0))
    supervisor.see(problem.scene.add("bird", to.Sphere(0.05), motion=track))
    run(arm, supervisor, 10.0)
    assert kinds(supervisor) == [
        EventKind.STARTED,
        EventKind.WORLD_CHANGED,
        EventKind.STILL_CLEAR,
        EventKind.REACHED,
    ]


def test_stops_or_replans_for_an_appearing_obstacle(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    world = in_the_way(problem)
    supervisor.see(world)
    driven = [arm.state().positions]
    while supervisor.busy and arm.now() < 10.0:
        supervisor.cycle()
        for _ in range(4):
            arm.advance(CYCLE / 4)
            driven.append(arm.state().positions)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    assert EventKind.UNPROVEN_STOP not in kinds(supervisor)
    clear = replace(problem, scene=world).reduced
    columns = problem.scene.robot.index(problem.reduced.joint_names)
    for positions in driven:
        assert examine(clear, positions[columns]).clear


@pytest.mark.parametrize("begin", np.linspace(0.3, 0.8, 11))
def test_a_rest_is_found_on_a_motion_that_returns_beside_it(problem: to.Problem, begin: float) -> None:
    reduced = problem.reduced
    knots = np.tile(reduced.start_positions, (3, 1))
    knots[1, 0] += 0.3
    knots[2, 1] += 5e-5
    motion = to.Trajectory(reduced.joint_names, np.array((0.0, 1.0, 2.0)), knots, 0.0 * knots, 0.0 * knots)
    goal = GuardedGoal(problem, guard_of(problem, supervised(problem)[0]))
    stop = StopsAlong(motion, problem.limits).earliest(begin)
    intended = IntendedMotion(goal=goal, planned=motion, trajectory=motion, scaling=FULL_SPEED, begin=0.0)
    found = motion(Pause(intended, stop).rests_at)
    assert np.abs(found - stop.trajectory(stop.trajectory.duration)).max() < 1e-9


def test_a_motion_is_retimed_from_the_acceleration_with_which_it_begins(tmp_path: Path) -> None:
    arm = odd_arm(tmp_path)
    begin, goal = ({"pan": pan, "reach": 0.1, "elbow": 0.3, "wrist": 0.1} for pan in (0.0, 1.5))
    still = to.Problem(scene=to.Scene(arm), start=begin, goal=goal)
    found = to.plan(still).require()
    half = arm.positions(begin | {"pan": 0.75})
    over = still.scene.placement_of("fore", half).translation + np.array((0.0, 0.0, 0.9))
    falls = to.Track.constant_velocity(to.placement(over), (0.0, 0.0, -1.0))
    problem = replace(still, scene=still.scene.add("box", to.Box(0.1, 0.1, 0.3), motion=falls))
    executor = IdealExecutor(still.reduced.joint_names, still.reduced.start_positions)
    commitment = Commitment.at_rest(executor, problem)
    assert commitment.splice(found.trajectory, 0.1)
    intended = IntendedMotion.of(GuardedGoal(problem, commitment.guard), found, 0.1)
    here = commitment.continued(problem, 0.1, commitment.world)
    retimed = retime_on_path(commitment, intended, here, 0.1, patience=1.0)
    assert retimed is None or commitment.splice(retimed.trajectory, 0.1)


def test_requested_stop_is_the_soonest_proven_one(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.24)
    taken = supervisor.stop()
    assert taken.proven
    assert 0.0 < taken.duration < 0.4
    arm.advance(arm.latency + taken.duration)
    assert not arm.state().velocities.any()
    assert not supervisor.moving


def test_a_new_goal_in_motion_is_reached_without_a_stop(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    back = dict(zip(problem.reduced.joint_names, problem.reduced.start_positions.tolist(), strict=True))
    supervisor.go(replace(problem, goal=to.joint_positions(back)))
    run(arm, supervisor, 10.0)
    assert kinds(supervisor) == [
        EventKind.STARTED,
        EventKind.GOAL_CHANGED,
        EventKind.REPLANNED,
        EventKind.REACHED,
    ]


def test_a_goal_that_cannot_be_reached_leaves_the_robot_stopped(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.1)
    supervisor.see(problem.scene.add("block", to.Box(0.2, 0.2, 0.2), to.placement((0.44, 0.29, 0.25))))
    run(arm, supervisor, 3.0)
    assert EventKind.NO_PLAN in kinds(supervisor)
    assert not arm.state().velocities.any()
    assert EventKind.UNPROVEN_STOP not in kinds(supervisor)


def test_robot_off_its_track_is_stopped_and_the_error_reported(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    arm.displace(np.full(len(arm.joint_names), 0.01))
    supervisor.cycle()
    assert kinds(supervisor)[-1] is EventKind.OFF_TRACK
    assert "has to be at" in supervisor.events[-1].words
    assert arm.fault()


def test_ended_prediction_brings_the_robot_to_rest_and_is_named(
    problem: to.Problem,
) -> None:
    far = to.Track.constant_velocity(to.placement((0.0, -2.0, 0.3)), (0.0, -0.1, 0.0), end=9.0)
    known = problem.scene.add("cart", to.Box(0.1, 0.1, 0.1), motion=to.Prediction(far, until=0.9))
    arm, supervisor = supervised(problem)
    supervisor.see(known, 0.0)
    run(arm, supervisor, 0.3)
    assert np.abs(arm.state().velocities).max() > 0.1
    supervisor.see(
        problem.scene.add("cart", to.Box(0.1, 0.1, 0.1), motion=to.Prediction(far, until=0.35)), 0.0
    )
    run(arm, supervisor, 3.0)
    assert not arm.state().velocities.any()
    stale = [event for event in supervisor.events if event.kind is EventKind.STALE]
    assert len(stale) == 1 and "the motion of cart is predicted until 0.350 s" in stale[0].words
    supervisor.see(problem.scene)
    run(arm, supervisor, 9.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED


def test_plans_are_proven_within_the_tracking_tolerance() -> None:
    """Between plates there is just room: what keeps nearer than the robot may be off cannot be driven."""
    narrow = named("between_plates_xarm7")
    arm = IdealExecutor(narrow.scene.robot.joint_names, narrow.start_positions)
    arm.tolerance[:] = 1e-3
    supervisor = Supervisor(arm, narrow)
    supervisor.go(narrow)
    run(arm, supervisor, 5.0)
    assert kinds(supervisor) == [EventKind.STARTED, EventKind.REACHED]


def test_hopeless_goal_is_not_replanned_repeatedly() -> None:
    """A contact at the start that is not accepted is reported once."""
    touching = named("pick_and_place_panda")
    touching = replace(touching, scene=replace(touching.scene, allowances=()))
    arm = IdealExecutor(touching.scene.robot.joint_names, touching.start_positions)
    arm.tolerance[:] = 1e-3
    supervisor = Supervisor(arm, touching)
    supervisor.go(touching)
    run(arm, supervisor, 1.0)
    assert kinds(supervisor) == [EventKind.NO_PLAN]
    assert "START_IN_COLLISION" in supervisor.events[-1].words
    assert "table is 0.1 mm inside block" in supervisor.events[-1].words
    assert supervisor.blocked and not supervisor.moving


def test_heavy_load_is_braked_within_torque_limits() -> None:
    heavy = named("heavy_payload_panda")
    arm = IdealExecutor(heavy.scene.robot.joint_names, heavy.start_positions)
    supervisor = Supervisor(arm, heavy)
    supervisor.go(heavy)
    run(arm, supervisor, 0.3)
    left = supervisor.committed.end - arm.now()
    taken = supervisor.stop()
    assert taken.proven and taken.duration < left - 0.05


def named(name: str) -> to.Problem:
    try:
        return to.named_problem(name)
    except to.MissingExtra as error:
        pytest.skip(str(error))


def cup_at(problem: to.Problem, configuration: np.ndarray) -> np.ndarray:
    return problem.scene.placement_of("cup", problem.reduced.all_positions(configuration)).translation


def walled(problem: to.Problem, arm: IdealExecutor, supervisor: Supervisor) -> to.Scene | None:
    """A wall that only a stop off the path is clear of, in which the cup tilts too much; or None."""
    begin, names, plan = arm.now() + arm.latency, problem.reduced.joint_names, supervisor.intended
    ahead = supervisor.committed.ahead(begin, names)
    assert ahead is not None and plan is not None
    off = stopping_motion(on_the_way(problem, ahead, 0.0))
    guard, seen = guard_of(problem, arm), WorldSnapshot(problem.scene, 0.0)
    if guard.proven(off, seen, begin):
        return None
    on_path = [ahead, plan.stops.earliest(begin - plan.begin).trajectory]

    def clear(stop: to.Trajectory, scene: to.Scene) -> bool:
        return guard.proven(stop, WorldSnapshot(scene, 0.0), begin, requirements=False)

    begins, ends = cup_at(problem, off(0.0)), cup_at(problem, off(off.duration))
    towards = np.append((ends - begins)[:2], 0.0)
    towards /= np.linalg.norm(towards)
    turn = float(np.arctan2(towards[1], towards[0]))
    for away in np.arange(0.06, 0.3, 0.002):
        where = to.placement(ends + away * towards + (0.0, 0.0, 0.1), rpy=(0.0, 0.0, turn))
        scene = problem.scene.add("wall", to.Box(0.01, 0.3, 0.3), where)
        if clear(off, scene):
            return None if any(clear(stop, scene) for stop in on_path) else scene
    return None


def test_returns_to_the_path_after_a_stop_off_it(
    problem: to.Problem,
) -> None:
    """The cup tilts too much in the only stop that is clear: no motion that keeps it upright begins there."""
    arm, supervisor = supervised(problem)
    scene = None
    while scene is None and supervisor.busy:
        run(arm, supervisor, arm.now() + CYCLE)
        scene = walled(problem, arm, supervisor) if supervisor.moving else None
    assert scene is not None
    for _ in range(4):  # seen again and again it is no other stop
        supervisor.see(scene)
        run(arm, supervisor, arm.now() + CYCLE)
    assert kinds(supervisor).count(EventKind.STOPPING) == 1
    run(arm, supervisor, arm.now() + 0.4)
    supervisor.see(problem.scene)
    run(arm, supervisor, arm.now() + 5.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED and EventKind.UNPROVEN_STOP not in kinds(supervisor)
    back = kinds(supervisor).index(EventKind.RECOVERING)
    assert EventKind.STARTED in kinds(supervisor)[back:] and "cup" in supervisor.events[back].words


def test_stop_before_a_new_motion_follows_the_present_one(
    problem: to.Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.4)
    here = dict(zip(problem.reduced.joint_names, problem.reduced.start_positions.tolist(), strict=True))
    supervisor.go(replace(problem, goal=to.joint_positions(here)))
    supervisor.cycle()
    intended = supervisor.intended
    assert intended is not None and intended.begin > arm.now() + arm.latency
    ahead = supervisor.committed.ahead(arm.now() + arm.latency, problem.reduced.joint_names)
    assert ahead is not None
    path = ahead(np.linspace(0.0, ahead.duration, 4000))

    def only_soon_and_on_the_path(
        _: MotionGuard, motion: to.Trajectory, *others: object, **more: object
    ) -> bool:
        looks = motion(np.linspace(0.0, motion.duration, 50))
        away = np.abs(looks[:, None] - path).max(axis=2).min(axis=1)
        return bool(away.max() < 2e-4) and motion.duration < 0.8 * ahead.duration

    monkeypatch.setattr(MotionGuard, "proven", only_soon_and_on_the_path)
    taken = supervisor.stop()
    assert taken.proven and taken.along and taken.duration < 0.8 * ahead.duration


@pytest.mark.parametrize("wrong", [[float("nan"), 0.0], [float("inf"), 0.0], [-1.0, 0.0], [0.0]])
def test_invalid_tolerance_is_refused(problem: to.Problem, wrong: list[float]) -> None:
    joints = problem.scene.robot.joint_names
    arm = IdealExecutor(joints, problem.start_positions)
    arm.tolerance = np.resize(wrong, len(joints)) if len(wrong) > 1 else np.array(wrong)
    with pytest.raises((ShapeError, ProblemError), match=r"Executor\.tolerance"):
        Supervisor(arm, problem)
