"""A supervisor drives a task: gripper, world model, replanning of stages, recovery of picks."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import (
    EventKind,
    GripperState,
    IdealExecutor,
    Logbook,
    SimulatedExecutor,
    Supervisor,
    Surprise,
    Surprises,
    read_recording,
    run,
    write_recording,
)
from trajopt.simulation import SimulationOptions
from trajopt.tasks import (
    AttachObject,
    DetachObject,
    Dwell,
    Fallback,
    FollowCurve,
    ForEach,
    MoveObject,
    MoveTo,
    PickObject,
    PlaceObject,
    StageLimits,
    Task,
    TaskStage,
    Within,
)
from trajopt.tasks.cartesian import Begin, FollowOptions, line
from trajopt.tasks.grasping import Grasp, Place, grasps_of, gripper_of
from trajopt.values.arrays import Floats
from trajopt.values.errors import NameNotFound, ObjectNotFound, ProblemError

CYCLE = 0.02
UP = to.placement((0.5, 0.25, 0.06))
ASIDE = to.placement((0.35, 0.4, 0.06))


@dataclass
class Hand:
    """A gripper that needs 0.3 s for a command; `empty` are the numbers of grasps that hold nothing."""

    arm: IdealExecutor
    empty: tuple[int, ...] = ()
    opening: float = 0.0
    done_at: float = 0.0
    holding: bool = False
    commands: list[str] = field(default_factory=list[str])

    def state(self) -> GripperState:
        return GripperState(self.opening, self.arm.now() < self.done_at, self.holding)

    def move(self, opening: float) -> None:
        self.commands.append(f"move to {1e3 * opening:.0f} mm")
        self.opening, self.holding, self.done_at = opening, False, self.arm.now() + 0.3

    def grasp(self, width: float, force: float) -> None:
        grasps = sum(each.startswith("grasp") for each in self.commands)
        self.commands.append(f"grasp {1e3 * width:.0f} mm with {force:.0f} N")
        self.holding = grasps not in self.empty
        self.opening, self.done_at = width if self.holding else 0.0, self.arm.now() + 0.3


@pytest.fixture(scope="module")
def scene() -> to.Scene:
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    cup = to.Cylinder(radius=0.03, length=0.12)
    return (
        to.Scene(panda)
        .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("cup", cup, to.placement((0.5, -0.2, 0.06)), mass=0.2)
        .add("mug", cup, to.placement((0.65, -0.2, 0.06)), mass=0.2)
    )


def grasps(scene: to.Scene, name: str) -> tuple[Grasp, ...]:
    return grasps_of(scene, name, gripper_of(scene.robot))


def handled(scene: to.Scene, name: str, place: to.Placement) -> list[TaskStage]:
    return [PickObject(name, grasps(scene, name)[:4]), PlaceObject(name, Place(placement=place))]


def task(scene: to.Scene, *stages: TaskStage) -> Task:
    return Task(scene=scene, group="panda_arm", start="ready", stages=stages)


def supervised(job: Task, empty: tuple[int, ...] = ()) -> tuple[IdealExecutor, Hand, Supervisor]:
    robot = job.scene.robot
    joints = robot.group("panda_arm").joints
    arm = IdealExecutor(joints, robot.positions("ready")[robot.index(joints)])
    hand = Hand(arm, empty)
    stands = to.Problem(scene=job.scene, group="panda_arm", start="ready", goal="ready")
    supervisor = Supervisor(arm, stands, gripper=hand)
    supervisor.go(job)
    return arm, hand, supervisor


def drive(
    arm: IdealExecutor,
    supervisor: Supervisor,
    each: Callable[[float], None] | None = None,
    until: float = 40.0,
) -> None:
    while supervisor.busy and not supervisor.blocked and arm.now() < until:
        if each is not None:
            each(arm.now())
        supervisor.cycle()
        arm.advance(CYCLE)


def kinds(supervisor: Supervisor) -> list[EventKind]:
    return [event.kind for event in supervisor.events]


def words(supervisor: Supervisor, kind: EventKind) -> list[str]:
    return [event.words for event in supervisor.events if event.kind is kind]


def where(supervisor: Supervisor, name: str) -> Floats:
    return supervisor.scene.holder(name).placement.translation


def test_task_is_driven_with_the_gripper_and_the_object_in_the_hand(scene: to.Scene) -> None:
    arm, hand, supervisor = supervised(task(scene, *handled(scene, "cup", UP), Dwell(0.5), MoveTo("ready")))
    held: list[str] = []

    def watch(now: float) -> None:
        del now
        held.append(supervisor.scene.holder("cup").link)

    drive(arm, supervisor, watch)
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert hand.commands == ["move to 80 mm", "grasp 60 mm with 30 N", "move to 80 mm"]
    assert where(supervisor, "cup") == pytest.approx(UP.translation, abs=1e-3)
    assert {"world", "panda_hand_tcp"} == set(held) and held[-1] == "world"
    stages = [event.stage for event in supervisor.events if event.kind is EventKind.REACHED]
    assert stages == [
        "pick cup: reach, pick cup: approach",
        "pick cup: lift, place cup: carry, place cup: lower",
        "place cup: retreat",
        "move to ready",
    ]


def test_pick_that_leaves_nothing_in_the_fingers_is_repeated_with_the_next_grasp(scene: to.Scene) -> None:
    arm, hand, supervisor = supervised(task(scene, *handled(scene, "cup", UP), MoveTo("ready")), empty=(0, 1))
    drive(arm, supervisor)
    missed = words(supervisor, EventKind.NOT_GRASPED)
    first, second = (grasp.name for grasp in grasps(scene, "cup")[:2])
    nothing = "the gripper holds nothing"
    assert missed == [f"part cup by {first}: {nothing}", f"part cup by {second}: {nothing}"]
    assert [each for each in hand.commands if each.startswith("grasp")] == ["grasp 60 mm with 30 N"] * 3
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert where(supervisor, "cup") == pytest.approx(UP.translation, abs=1e-3)


def test_part_that_no_grasp_holds_is_named_once(scene: to.Scene) -> None:
    stages = handled(scene, "cup", UP)
    arm, _, supervisor = supervised(task(scene, *stages), empty=(0, 1, 2, 3))
    drive(arm, supervisor)
    assert supervisor.blocked
    assert words(supervisor, EventKind.NO_PLAN) == ["stage 'pick cup', part cup: no grasp held it"]
    supervisor.see(scene.move("cup", to.placement((0.5, -0.3, 0.06))))
    supervisor.cycle()
    drive(arm, supervisor)
    assert kinds(supervisor)[-1] is EventKind.COMPLETED


def test_items_with_a_missing_part_or_one_that_is_not_held_are_skipped(scene: to.Scene) -> None:
    tray = scene.add("third", to.Cylinder(radius=0.03, length=0.12), to.placement((0.6, 0.0, 0.06)))
    items = [handled(tray, "mug", ASIDE), handled(tray, "third", ASIDE), handled(tray, "cup", UP)]
    arm, _, supervisor = supervised(task(tray, ForEach(items)), empty=(0, 1, 2, 3))
    supervisor.see(tray.remove("mug"))
    drive(arm, supervisor)
    assert words(supervisor, EventKind.SKIPPED) == [
        "part mug: it is not in the world",
        "part third: no grasp held it",
    ]
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert where(supervisor, "cup") == pytest.approx(UP.translation, abs=1e-3)
    assert where(supervisor, "third") == pytest.approx((0.6, 0.0, 0.06))


def test_stages_are_planned_again_when_their_object_is_elsewhere(scene: to.Scene) -> None:
    arm, hand, supervisor = supervised(task(scene, *handled(scene, "cup", UP)))
    there = (0.45, -0.35, 0.06)

    def cup_is_pushed(now: float) -> None:
        if now > 0.6 and where(supervisor, "cup") == pytest.approx((0.5, -0.2, 0.06)):
            supervisor.see(supervisor.scene.move("cup", to.placement(there)))

    drive(arm, supervisor, cup_is_pushed)
    assert kinds(supervisor).count(EventKind.PLANNED) == 2
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert hand.commands.count("grasp 60 mm with 30 N") == 1
    assert where(supervisor, "cup") == pytest.approx(UP.translation, abs=1e-3)


def test_interrupted_curve_is_followed_on_from_where_the_arm_stopped(scene: to.Scene) -> None:
    """The cup, which is picked afterwards, moves while the tool is on the curve."""
    begin, end = (to.placement((0.45, y, 0.35), rpy=(3.14159265, 0.0, 0.0)) for y in (-0.15, 0.25))
    seam = to.follows_curve("panda_hand_tcp", line(begin, end))
    slow = FollowOptions(begin=Begin.ANY_BRANCH, tool_speed=(to.tool_speed("panda_hand_tcp", linear=0.1),))
    stages = FollowCurve(seam, options=slow, off=0.03), PickObject("cup", grasps(scene, "cup")[:4])
    arm, _, supervisor = supervised(task(scene, *stages))
    elsewhere = scene.move("cup", to.placement((0.5, -0.3, 0.06)))
    tool: list[tuple[float, Floats]] = []
    reported: list[float] = []

    def watch(now: float) -> None:
        at = np.array(scene.robot.positions("ready"))
        at[scene.robot.index(arm.joint_names)] = arm.state().positions
        tool.append((now, scene.placement_of("panda_hand_tcp", at).translation))
        if abs(tool[-1][1][2] - 0.35) < 1e-3 and tool[-1][1][1] > 0.0 and not reported:
            reported.append(now)
            supervisor.see(elsewhere)

    drive(arm, supervisor, watch)
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert kinds(supervisor).count(EventKind.PLANNED) == 2
    on = np.array([where for _, where in tool if abs(where[2] - 0.35) < 1e-3])
    on = on[: int(on[:, 1].argmax()) + 1]
    assert on[:, 1].min() < -0.14 and on[:, 1].max() > 0.24
    stopped = next(k for k in range(1, len(on)) if on[k - 1, 1] > 0.0 and on[k, 1] < on[k - 1, 1] + 1e-9)
    assert on[stopped:, 1].min() > 0.0, "what is done is not done again"
    assert np.diff(on[:, 1]).min() > -0.01
    assert np.diff(on[:, 1]).max() < 0.02, "nothing is left out"


def test_obstacle_in_the_way_of_the_carried_cup_is_avoided(scene: to.Scene) -> None:
    arm, _, supervisor = supervised(task(scene, *handled(scene, "cup", UP)))

    def box_moves_in(now: float) -> None:
        del now
        if EventKind.GRASPED in kinds(supervisor) and "box" not in supervisor.scene.objects:
            supervisor.see(scene.add("box", to.Box(0.1, 0.02, 0.35), to.placement((0.5, 0.05, 0.175))))
            assert supervisor.scene.holder("cup").link == "panda_hand_tcp" or not arm.state().velocities.any()

    drive(arm, supervisor, box_moves_in)
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert EventKind.UNPROVEN_STOP not in kinds(supervisor)
    assert where(supervisor, "cup") == pytest.approx(UP.translation, abs=1e-3)


def test_place_that_is_taken_leads_to_another_alternative(scene: to.Scene) -> None:
    pick, place = handled(scene, "cup", UP)
    other = PlaceObject("cup", Place(placement=ASIDE), name="aside")
    arm, _, supervisor = supervised(task(scene, pick, Fallback([place, other])))

    def place_is_taken(now: float) -> None:
        del now
        if EventKind.GRASPED in kinds(supervisor) and "box" not in supervisor.scene.objects:
            supervisor.see(scene.add("box", to.Box(0.1, 0.1, 0.1), to.placement((0.5, 0.25, 0.05))))

    drive(arm, supervisor, place_is_taken)
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert where(supervisor, "cup") == pytest.approx(ASIDE.translation, abs=1e-3)


def test_part_that_is_lost_on_the_way_ends_the_motion_and_is_named(scene: to.Scene) -> None:
    arm, hand, supervisor = supervised(task(scene, *handled(scene, "cup", UP)))
    lost_at: list[float] = []

    def loses(now: float) -> None:
        if hand.holding and not lost_at and arm.state().velocities.any():
            lost_at.append(now)
            hand.holding = False

    drive(arm, supervisor, loses)
    assert words(supervisor, EventKind.LOST) == ["part cup: the gripper no longer holds it"]
    assert words(supervisor, EventKind.LOST) == ["part cup: the gripper no longer holds it"]
    assert words(supervisor, EventKind.NO_PLAN) == ["stage 'pick cup', part cup: it is not in the world"]
    assert arm.committed.end < lost_at[0] + 1.0


def test_suction_cup_switches_with_attach_and_detach(scene: to.Scene) -> None:
    above = to.placement((0.5, -0.2, 0.13), rpy=(3.1416, 0.0, 0.0))
    there = to.placement((0.5, 0.1, 0.13), rpy=(3.1416, 0.0, 0.0))
    stages = [
        MoveTo(above),
        AttachObject("cup", "panda_hand_tcp", touch_links=("panda_leftfinger", "panda_rightfinger")),
        MoveTo(there),
        DetachObject("cup"),
        MoveTo("ready"),
    ]
    arm, hand, supervisor = supervised(task(scene, *stages))
    drive(arm, supervisor)
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert [each.split()[0] for each in hand.commands] == ["grasp", "move"]
    assert where(supervisor, "cup")[:2] == pytest.approx((0.5, 0.1), abs=1e-3)


def test_cause_of_a_stage_without_a_plan_is_given_with_stage_and_part_once(scene: to.Scene) -> None:
    pick, _ = handled(scene, "cup", UP)
    far = PlaceObject("cup", Place(placement=to.placement((0.2, 1.2, 0.06))), name="shelf")
    arm, _, supervisor = supervised(task(scene, pick, far))
    drive(arm, supervisor)
    (cause,) = words(supervisor, EventKind.NO_PLAN)
    assert cause.startswith("stage 'shelf', part cup: lower: ") and cause.count("cup") < 4
    assert supervisor.blocked


def test_limits_that_no_way_keeps_are_given_as_the_cause(scene: to.Scene) -> None:
    slow = Within(
        [MoveTo(to.placement((0.45, 0.1, 0.3), rpy=(np.pi, 0.0, 0.0)))],
        StageLimits(duration=0.01),
        name="quick",
    )
    arm, _, supervisor = supervised(task(scene, slow))
    drive(arm, supervisor)
    (cause,) = words(supervisor, EventKind.NO_PLAN)
    assert cause.startswith("stage 'quick': takes ") and "longer than 0.01 s" in cause


def test_stop_and_other_goals_drop_the_task(scene: to.Scene) -> None:
    job = task(scene, *handled(scene, "cup", UP))
    arm, _, supervisor = supervised(job)
    with pytest.raises(ProblemError, match="a task is driven: add the goal to its stages"):
        supervisor.then(supervisor.problem)
    drive(arm, supervisor, until=0.6)
    assert arm.state().velocities.any()
    assert supervisor.stop().proven
    arm.advance(1.0)
    assert not supervisor.busy
    supervisor.go(job)
    drive(arm, supervisor)
    assert kinds(supervisor)[-1] is EventKind.COMPLETED


def test_fingers_need_a_driver_of_their_own(scene: to.Scene) -> None:
    job = task(scene, *handled(scene, "cup", UP))
    arm, hand, supervisor = supervised(job)
    with pytest.raises(ProblemError, match="stage 'pick cup' moves fingers: pass their driver"):
        Supervisor(arm, supervisor.problem).go(job)
    robot = scene.robot
    whole = IdealExecutor(robot.joint_names, robot.positions("ready"))
    with pytest.raises(ProblemError, match="the executor drives panda_finger_joint1"):
        Supervisor(whole, supervisor.problem, gripper=hand).go(job)
    with pytest.raises(ProblemError, match="one group of one robot"):
        supervisor.go(replace(job, group="hand", stages=[MoveTo("open")], start="ready"))
    with pytest.raises(ProblemError, match="blend_radius is of a goal"):
        supervisor.go(job, blend_radius=0.1)


def simulated(
    job: Task, world: to.Scene | None = None, tolerance: float = 1e-3
) -> tuple[SimulatedExecutor, Supervisor]:
    scene = job.scene
    positions = scene.robot.positions("ready")
    arm = SimulatedExecutor(
        world or scene,
        positions,
        gripper=gripper_of(scene.robot),
        loose=("cup",),
        options=SimulationOptions(dt=1e-3),
        tolerance=tolerance,
    )
    stands = to.Problem(scene=scene, group="panda_arm", start="ready", goal="ready")
    supervisor = Supervisor(arm, stands, gripper=arm.gripper)
    supervisor.go(job)
    return arm, supervisor


def test_friction_carries_the_cup_around_an_obstacle_that_moves_in(scene: to.Scene) -> None:
    alone = scene.remove("mug")
    way = to.Track.through(
        (0.0, 2.0, 4.0, 60.0),
        [to.placement(at) for at in ((1.0, 0.02, 0.2), (1.0, 0.02, 0.2), (0.5, 0.02, 0.2), (0.5, 0.02, 0.2))],
    )
    box = alone.add("box", to.Box(0.08, 0.08, 0.3), to.placement((1.0, 0.02, 0.2))).with_motion("box", way)
    arm, supervisor = simulated(task(alone, *handled(alone, "cup", UP), MoveTo("ready")), box)
    while supervisor.busy and not supervisor.blocked and arm.now() < 30.0:
        if EventKind.GRASPED in kinds(supervisor) and "box" not in supervisor.scene.objects:
            supervisor.see(box, 0.0)
        supervisor.cycle()
        arm.advance(CYCLE)
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert EventKind.UNPROVEN_STOP not in kinds(supervisor)
    assert not arm.contacts_at_fault
    assert arm.placement_of("cup").translation == pytest.approx(UP.translation, abs=3e-3)


def test_simulated_fingers_that_close_above_the_cup_hold_nothing_and_the_next_grasp_does(
    scene: to.Scene,
) -> None:
    alone = scene.remove("mug")
    good = grasps(alone, "cup")[0]
    raised = to.placement((0.0, 0.0, 0.05)) * good.placement
    too_high = replace(good, placement=raised, name="too high")
    arm, supervisor = simulated(task(alone, PickObject("cup", [too_high, good]), MoveTo("ready")))
    while supervisor.busy and not supervisor.blocked and arm.now() < 20.0:
        supervisor.cycle()
        arm.advance(CYCLE)
    assert words(supervisor, EventKind.NOT_GRASPED) == ["part cup by too high: the gripper holds nothing"]
    assert kinds(supervisor)[-1] is EventKind.COMPLETED
    assert arm.placement_of("cup").translation[2] > 0.3
    assert supervisor.scene.holder("cup").link == "panda_hand_tcp"


def test_objects_that_are_not_loose_are_refused(scene: to.Scene) -> None:
    positions = scene.robot.positions("ready")
    with pytest.raises(ObjectNotFound, match="'cap'"):
        SimulatedExecutor(scene, positions, loose=("cap",))
    arm = SimulatedExecutor(scene, positions, loose=("cup",))
    with pytest.raises(NameNotFound, match="'mug'"):
        arm.placement_of("mug")


def test_rehearsed_task_is_measured_recorded_and_read_back(scene: to.Scene, tmp_path: Path) -> None:
    """A machine moves its door while the fingers hold the cup, and a box appears beside the mug."""
    cell = scene.add("door", to.Box(0.1, 0.02, 0.3), to.placement((0.5, 0.12, 0.4)))
    pick, put = handled(cell, "cup", UP)
    door = MoveObject("door", to.placement((0.5, 0.12, 0.9)), seconds=0.5)
    book = Logbook()
    box = Surprise(
        name="box", at=4.0, placement=to.placement((0.7, 0.3, 0.05)), shape=to.Box(0.05, 0.05, 0.1)
    )
    job = task(cell, pick, door, put, MoveTo("ready"))
    report = run(job, surprises=Surprises(objects=[box]), watch=book.look)
    assert report.succeeded and report.contacts == (), str(report)
    assert report.placements["cup"].translation == pytest.approx(UP.translation, abs=3e-3)
    assert report.errors["cup"].position < 3e-3
    assert list(report.errors) == ["cup"], "the mug is not picked"
    assert EventKind.GRASPED in {event.kind for event in report.events}
    assert "completed the task after" in str(report)
    assert json.loads(json.dumps(report.as_dict()))["completed"] is True
    write_recording(tmp_path / "run.json", book.recording)
    again = read_recording(tmp_path / "run.json", scene.robot)
    held = [each.world.scene.holder("cup").link for each in again.sightings]
    assert held[0] == held[-1] == "world" and "panda_hand_tcp" in held
    assert "box" in again.sightings[-1].world.scene.objects
    stages = [event.stage for event in again.events]
    assert "pick cup: close" in stages


@pytest.mark.parametrize(
    ("stages", "words"),
    [
        ([AttachObject("cup", "panda_hand")], "stage 'attach cup': the simulated robot has no suction cup"),
        ([MoveObject("cup", UP)], "object 'cup' is handled by the task"),
    ],
)
def test_task_that_cannot_be_simulated_is_refused(
    scene: to.Scene, stages: list[TaskStage], words: str
) -> None:
    moved = Surprises(objects=[Surprise(name="cup", at=1.0, placement=ASIDE)])
    with pytest.raises(ProblemError, match=words):
        run(task(scene, *stages), surprises=moved)
    held = scene.attach("cup", "panda_hand", at=scene.robot.positions("ready"))
    with pytest.raises(ProblemError, match="object 'cup' is in the hand at the start"):
        run(task(held, PlaceObject("cup", Place(placement=UP)), *handled(held, "cup", ASIDE)))
