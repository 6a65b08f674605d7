"""Joints outside the group that start outside their limits: reported, held, watched, counted in proofs."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import EventKind, IdealExecutor, Servo, SimulatedExecutor, Supervisor, Twist, run
from trajopt.driving.motion_guard import guard_of
from trajopt.files.moveit import read_request, read_scene
from trajopt.values.errors import ShapeError

FINGER = "panda_finger_joint1"
OPEN = 0.065
"""Wider than the fingers of the Panda open, as MotionBenchMaker's requests ask for [m]."""


@pytest.fixture(scope="module")
def problem() -> to.Problem:
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    start = dict(zip(panda.joint_names, panda.positions("ready").tolist(), strict=True))
    names = panda.groups["panda_arm"].joints
    goal = to.joint_positions({name: start[name] + 0.2 for name in names})
    return to.Problem(
        scene=to.Scene(panda),
        group="panda_arm",
        start={**{name: start[name] for name in names}, FINGER: OPEN},
        goal=goal,
    )


def test_reaches_the_goal_with_fingers_held_beyond_their_limit(problem: to.Problem) -> None:
    done = run(problem)
    assert done.reached and done.contacts == ()
    first, *others = done.events
    assert first.kind is EventKind.OUTSIDE_LIMITS and first.time == 0.0
    assert f"{FINGER} is at 65 mm, outside its limits [0, 40] mm, and is held there" in first.words
    assert "panda_finger_joint2" in first.words
    assert EventKind.OUTSIDE_LIMITS not in [event.kind for event in others]


def test_simulated_fingers_stay_beyond_their_limit(problem: to.Problem) -> None:
    arm = SimulatedExecutor(problem.scene, problem.start_positions)
    arm.advance(0.2)
    arm.change(problem.scene.add("far", to.Box(0.1, 0.1, 0.1), to.placement((2.0, 0.0, 0.0))), begin=0.2)
    arm.advance(0.2)
    assert arm.truth().positions[arm.joint_names.index(FINGER)] == pytest.approx(OPEN, abs=1e-5)


def test_joints_within_their_limits_are_not_reported(problem: to.Problem) -> None:
    closed = {**dict.fromkeys(problem.scene.robot.joint_names, 0.0), "panda_joint4": -1.5}
    inside = to.Problem(scene=problem.scene, group="panda_arm", start=closed, goal="ready")
    arm = IdealExecutor(problem.scene.robot.joint_names, inside.start_positions)
    assert Supervisor(arm, inside).events == []


def test_servo_reports_joints_outside_their_limits(problem: to.Problem) -> None:
    arm = IdealExecutor(problem.scene.robot.joint_names, problem.start_positions)
    servo = Servo(arm, problem)
    servo.command(Twist(linear=np.array((0.0, 0.0, 0.1))))
    servo.tick()
    assert [event.kind for event in servo.events] == [EventKind.OUTSIDE_LIMITS]


def test_each_joint_is_watched_with_its_own_tolerance(problem: to.Problem) -> None:
    names = problem.scene.robot.joint_names
    arm = IdealExecutor(names, problem.start_positions)
    arm.tolerance[:] = 1e-3
    arm.tolerance[names.index(FINGER)] = 5e-3
    supervisor = Supervisor(arm, problem)
    assert f"{FINGER} is at 65 mm, outside its limits [0, 40] mm, and is held there within 5 mm" in str(
        supervisor.events[0]
    )
    off = np.zeros(len(names))
    off[names.index(FINGER)] = -4e-3
    arm.displace(off)
    supervisor.cycle()
    assert EventKind.OFF_TRACK not in [event.kind for event in supervisor.events]
    off[names.index(FINGER)] = -6e-3
    arm.displace(off)
    supervisor.cycle()
    assert supervisor.events[-1].kind is EventKind.OFF_TRACK
    assert "is at 59 mm, has to be at 65 mm within 5 mm" in supervisor.events[-1].words


def test_tolerance_of_joints_outside_the_group_increases_clearances(problem: to.Problem) -> None:
    names = problem.scene.robot.joint_names
    arm = IdealExecutor(names, problem.start_positions)
    arm.tolerance[:] = 1e-3
    narrow = guard_of(problem, arm).deviation
    arm.tolerance[names.index(FINGER)] = 5e-3
    assert guard_of(problem, arm).deviation == pytest.approx(narrow + 4e-3, abs=2e-3)


def test_simulated_tolerance_is_one_number_or_one_for_each_joint(problem: to.Problem) -> None:
    arm = SimulatedExecutor(
        problem.scene, problem.start_positions, tolerance=1e-3 * np.arange(8, dtype=np.float64)
    )
    assert arm.tolerance.tolist() == pytest.approx([each * 1e-3 for each in range(8)])
    with pytest.raises(ShapeError, match="tolerance"):
        SimulatedExecutor(problem.scene, problem.start_positions, tolerance=np.full(3, 1e-3))


@pytest.mark.parametrize("name", ["box", "cage", "bookshelf_tall", "table_pick"])
def test_motion_bench_maker_reaches(shared_data: Path, name: str, problem: to.Problem) -> None:
    folder = shared_data / "motionbenchmaker" / "panda" / name
    scene = read_scene(folder / "scene0002.yaml", problem.scene.robot)
    asked = read_request(folder / "request0002.yaml", scene).problem()
    done = run(asked)
    assert done.reached and done.contacts_at_fault == ()
