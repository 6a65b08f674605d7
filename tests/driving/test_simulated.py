"""A supervised robot under physics: with faults, and in a world that differs from the reported one."""

import gc
from weakref import ref

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import EventKind, Fault, FaultKind, Sensors, SimulatedExecutor, Supervisor
from trajopt.values.errors import JointNotFound, ModelError

CYCLE = 0.02


@pytest.fixture(scope="module")
def problem() -> to.Problem:
    try:
        return to.named_problem("cup_past_pillar")
    except to.MissingExtra as error:
        pytest.skip(str(error))


def driven(
    problem: to.Problem, *faults: Fault, world: to.Scene | None = None
) -> tuple[SimulatedExecutor, Supervisor]:
    arm = SimulatedExecutor(world or problem.scene, problem.start_positions, faults=faults)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    return arm, supervisor


def run(arm: SimulatedExecutor, supervisor: Supervisor, until: float) -> None:
    while supervisor.busy and arm.now() < until - 1e-9:
        supervisor.cycle()
        arm.advance(CYCLE)


def kinds(supervisor: Supervisor) -> list[EventKind]:
    return [event.kind for event in supervisor.events]


def test_reaches_the_goal_without_touching_anything(problem: to.Problem) -> None:
    arm, supervisor = driven(problem)
    run(arm, supervisor, 5.0)
    assert kinds(supervisor) == [EventKind.STARTED, EventKind.REACHED]
    assert arm.contacts == ()


def test_follows_a_fast_motion_to_within_a_millionth(problem: to.Problem) -> None:
    arm, supervisor = driven(problem)
    worst = 0.0
    while supervisor.busy:
        supervisor.cycle()
        for _ in range(10):
            arm.advance(arm.period)
            truth = arm.truth()
            worst = max(worst, float(np.abs(truth.positions - truth.commanded).max()))
    assert worst < 1e-6


@pytest.mark.parametrize(
    "fault",
    [
        Fault(kind=FaultKind.DRIFT, begin=0.25, end=9.0, joint="panda_joint4", size=0.05),
        Fault(kind=FaultKind.STUCK, begin=0.25, end=9.0, joint="panda_joint1"),
        Fault(kind=FaultKind.LOST_COMMANDS, begin=0.2, end=9.0),
    ],
    ids=lambda fault: fault.kind.value,
)
def test_robot_off_its_track_comes_to_rest_and_is_reported(problem: to.Problem, fault: Fault) -> None:
    arm, supervisor = driven(problem, fault)
    run(arm, supervisor, 3.0)
    assert EventKind.OFF_TRACK in kinds(supervisor)
    arm.advance(2.0)
    assert np.abs(arm.state().velocities).max() < 1e-2
    assert arm.fault()
    assert not supervisor.busy


def test_moving_robot_does_not_touch_an_appearing_object(problem: to.Problem) -> None:
    """It is there in the world when the supervisor is told: 0.25 s before the robot would be there."""
    place, when = to.placement((0.44, 0.15, 0.25)), 0.22
    world = problem.scene.add("surprise", to.Box(0.1, 0.1, 0.1), place, appears=when)
    arm, supervisor = driven(problem, world=world)
    run(arm, supervisor, when)
    supervisor.see(problem.scene.add("surprise", to.Box(0.1, 0.1, 0.1), place))
    run(arm, supervisor, 8.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    assert arm.contacts_at_fault == ()


def test_passes_a_moving_obstacle(problem: to.Problem) -> None:
    """A wall moves through the way; the planner knows its track, and how far it is off."""
    track = to.Track.constant_velocity(to.placement((0.44, 0.9, 0.25)), (0.0, -0.5, 0.0), end=2.5)
    moving = to.Prediction(track, error=(0.005, 0.0, 0.0))
    world = problem.scene.add("ball", to.Sphere(0.06), motion=moving)
    arm = SimulatedExecutor(world, problem.start_positions)
    supervisor = Supervisor(arm, problem)
    supervisor.see(world, 0.0)
    supervisor.go(problem)
    run(arm, supervisor, 8.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    assert arm.contacts_at_fault == ()


def test_former_worlds_are_released(problem: to.Problem) -> None:
    """Else hours among things that move would take more and more memory."""
    track = to.Track.constant_velocity(to.placement((0.44, 1.5, 0.25)), (0.0, -0.1, 0.0))
    world = problem.scene.add("ball", to.Sphere(0.06), motion=track)
    arm, supervisor = driven(problem, world=world)
    seen = list[ref[to.Scene]]()
    for _ in range(5):
        scene = world.at(arm.now())
        seen.append(ref(scene))
        supervisor.see(scene)
        run(arm, supervisor, arm.now() + 2.0 * CYCLE)
    supervisor.see(problem.scene)
    run(arm, supervisor, arm.now() + 4.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    gc.collect()
    assert [each() for each in seen[:3]] == [None] * 3  # judges of the last two worlds are kept


def run_into(problem: to.Problem) -> SimulatedExecutor:
    """A robot that stands, and a ball that comes to its hand at 0.2 m/s."""
    hand = problem.scene.placement_of("panda_hand", problem.start_positions).translation
    track = to.Track.constant_velocity(to.placement(hand - (0.0, 0.2, 0.0)), (0.0, 0.2, 0.0), end=5.0)
    world = problem.scene.add("ball", to.Sphere(0.05), motion=track)
    return SimulatedExecutor(world, problem.start_positions)


def test_robot_pushed_at_rest_is_not_at_fault(problem: to.Problem) -> None:
    arm = run_into(problem)
    rested = arm.truth().positions
    arm.advance(1.0)
    assert any("ball" in contact.pair for contact in arm.contacts)
    assert np.abs(arm.truth().positions - rested).max() > 1e-3
    assert arm.contacts_at_fault == ()


def test_robot_in_contact_is_at_fault_once_it_moves_by_itself(problem: to.Problem) -> None:
    arm = run_into(problem)
    while not arm.contacts:
        arm.advance(0.01)
    begun = arm.now() + 0.02
    assert arm.splice(to.plan(problem).require().trajectory, begun) == ""
    arm.advance(0.3)
    assert [contact.start >= begun for contact in arm.contacts_at_fault][:1] == [True]


def test_robot_driven_into_an_object_is_at_fault_from_the_first_touch(problem: to.Problem) -> None:
    motion = to.plan(problem).require().trajectory
    there = problem.scene.placement_of(
        "panda_hand", problem.reduced.all_positions(motion(0.5 * motion.duration))
    ).translation
    world = problem.scene.add("box", to.Box(0.05, 0.05, 0.05), to.placement(there))
    arm = SimulatedExecutor(world, problem.start_positions)
    assert arm.splice(motion, arm.latency) == ""
    arm.advance(motion.duration)
    (met, *_), (at_fault, *_) = arm.contacts, arm.contacts_at_fault
    assert met.pair == at_fault.pair and met.start == at_fault.start


def test_a_fault_names_its_joint(problem: to.Problem) -> None:
    with pytest.raises(JointNotFound, match="panda_joint9"):
        driven(problem, Fault(kind=FaultKind.STUCK, begin=0.0, end=1.0, joint="panda_joint9"))


def test_delayed_states_are_compared_with_the_motion_at_their_stamp(problem: to.Problem) -> None:
    late = Sensors(delay=0.1)
    arm = SimulatedExecutor(problem.scene, problem.start_positions, sensors=late)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    run(arm, supervisor, 5.0)
    assert kinds(supervisor) == [EventKind.STARTED, EventKind.REACHED]


class TestWithoutMasses:
    """A robot whose description has no inertias is placed on its motion at each time."""

    @pytest.fixture
    def problem(self, planar_arm: to.Robot) -> to.Problem:
        return to.Problem(scene=to.Scene(planar_arm), group="arm", start=(0.0, 0.0), goal=(0.4, 0.3))

    def test_is_at_each_time_where_its_motion_is(self, problem: to.Problem) -> None:
        arm, supervisor = driven(problem)
        worst = 0.0
        while supervisor.busy:
            supervisor.cycle()
            arm.advance(arm.period)
            truth = arm.truth()
            worst = max(worst, float(np.abs(truth.positions - truth.commanded).max()))
        assert not arm.dynamic and worst < 1e-9 and arm.saturated == ()
        assert kinds(supervisor) == [EventKind.STARTED, EventKind.REACHED]

    def test_contacts_and_stuck_joints_are_found(self, problem: to.Problem) -> None:
        elbow = problem.scene.placement_of("fore", to.plan(problem).require())
        arm, supervisor = driven(problem, world=problem.scene.add("ball", to.Sphere(0.1), elbow))
        run(arm, supervisor, 5.0)
        assert any("ball" in contact.pair for contact in arm.contacts_at_fault)
        stuck = Fault(kind=FaultKind.STUCK, begin=0.1, end=9.0, joint=problem.reduced.joint_names[0])
        arm, supervisor = driven(problem, stuck)
        run(arm, supervisor, 5.0)
        assert EventKind.OFF_TRACK in kinds(supervisor) and EventKind.REACHED not in kinds(supervisor)
        assert arm.truth().positions[0] < 0.2 and arm.truth().velocities[0] == 0.0

    def test_loose_objects_need_masses(self, problem: to.Problem) -> None:
        world = problem.scene.add("part", to.Box(0.1, 0.1, 0.1), to.placement((3.0, 0.0, 0.0)), mass=1.0)
        with pytest.raises(ModelError, match="moves no mass"):
            SimulatedExecutor(world, problem.start_positions, loose=("part",))
