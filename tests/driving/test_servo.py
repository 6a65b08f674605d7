"""A servo follows commands as far as limits, obstacles and singularities allow, and can stop."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import (
    Axis,
    Command,
    EventKind,
    IdealExecutor,
    JointVelocities,
    Servo,
    ServoOptions,
    Twist,
)
from trajopt.driving.servo_program import ApproachQuery, Braking
from trajopt.driving.servo_task import Tool
from trajopt.geometry import Query
from trajopt.optimise.methods.timing import with_jerk
from trajopt.optimise.terms.singularity_distance import frame_jacobian, singular_values
from trajopt.problem.motion import Motion
from trajopt.problem.requirements.joints import LENGTH
from trajopt.robot.joints import EXCESS
from trajopt.scene.reducing import tool_frame
from trajopt.values.arrays import Floats
from trajopt.values.errors import FrameNotFound, JointNotFound, ProblemError
from trajopt.verify import Judge

PERIOD = 0.01
GROUPS = {"panda": "panda_arm", "ur5": "manipulator"}
BENT = {"panda": "ready", "ur5": {"shoulder_lift_joint": -1.2, "elbow_joint": 1.5, "wrist_2_joint": -1.2}}
SPEED = 0.2
TABLE = (to.Box(1.0, 1.0, 0.1), to.placement((0.6, 0.0, -0.06)))


def asked(name: str, *things: tuple[to.Box, to.Placement]) -> to.Problem:
    try:
        scene = to.Scene(to.load(name))
    except to.MissingExtra as error:
        pytest.skip(str(error))
    for number, (shape, where) in enumerate(things):
        scene = scene.add(f"thing {number}", shape, where)
    return to.Problem(scene=scene, group=GROUPS[name], start=BENT[name], goal=BENT[name])


def led(problem: to.Problem, options: ServoOptions | None = None) -> tuple[IdealExecutor, Servo]:
    arm = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    return arm, Servo(arm, problem, options or ServoOptions(period=PERIOD))


def tool(arm: IdealExecutor, servo: Servo) -> to.Placement:
    reduced = servo.problem.reduced
    return reduced.scene.placement_of(servo.frame, reduced.all_positions(arm.state().positions))


def lead(arm: IdealExecutor, servo: Servo, command: Command, seconds: float) -> Floats:
    """Give a command in each tick; return the velocity of the tool's origin in each, (k, 3)."""
    velocities: list[Floats] = []
    for _ in range(round(seconds / PERIOD)):
        servo.command(command)
        servo.tick()
        before = tool(arm, servo).translation
        arm.advance(PERIOD)
        velocities.append((tool(arm, servo).translation - before) / PERIOD)
    return np.array(velocities)


def kinds(servo: Servo) -> list[EventKind]:
    return [event.kind for event in servo.events]


def slope(function: Callable[[Floats], Floats], at: Floats, step: float = 1e-6) -> Floats:
    """Return central differences, shape (values, n)."""
    ways = step * np.eye(len(at))
    return np.stack([(function(at + way) - function(at - way)) / (2.0 * step) for way in ways], axis=1)


def test_clearance_rows_are_the_slopes_of_distances() -> None:
    problem = asked("panda", (to.Sphere(0.05), to.placement((0.45, 0.1, 0.5))))
    around = ApproachQuery(problem.reduced, Braking(with_jerk(problem.limits), PERIOD), 0.0)
    start = problem.reduced.start_positions
    state = np.stack((start, np.full(7, 0.2), np.zeros(7)))
    rows = around.limits(state, 0.0)
    assert len(rows.lower) > 3
    wide = np.full(len(problem.reduced.pairs.first), 10.0)

    def distances(positions: Floats) -> Floats:
        found = Query(problem.reduced).close_pairs(positions[None], wide)
        values = np.full(len(wide), np.nan)
        values[found.pair] = found.distance
        return values

    differences = slope(distances, start)
    for row in rows.jacobian:
        assert np.abs(differences - row).max(axis=1).min() < 1e-4


@pytest.mark.parametrize("time", [0.0, 0.4])
def test_clearance_rows_include_the_speed_of_obstacles(time: float) -> None:
    problem = asked("panda")
    begin, velocity = np.array((0.45, 0.1, 0.5)), np.array((-0.3, 0.0, 0.1))
    moving = to.Prediction(to.Track.constant_velocity(to.placement(begin), velocity), (0.0, 0.02, 0.0))
    limits, state = with_jerk(problem.limits), np.stack((problem.reduced.start_positions, *np.zeros((2, 7))))

    def rows(scene: to.Scene) -> tuple[Floats, Floats]:
        around = ApproachQuery(replace(problem, scene=scene).reduced, Braking(limits, PERIOD), 0.0)
        found = around.limits(state, time)
        return found.jacobian, found.lower

    still = problem.scene.add("ball", to.Sphere(0.05), to.placement(begin + time * velocity))
    moved = problem.scene.add("ball", to.Sphere(0.05), motion=moving)
    fixed, nearer = rows(still), rows(moved)
    query = Query(replace(problem, scene=still).reduced)
    found = query.close_pairs(state[:1], np.full(len(query.reduced.pairs.first), 10.0))
    ball = [number for number, pair in enumerate(found.pair) if "ball" in query.reduced.owners(int(pair))]
    compared = 0
    for number in ball:
        theirs = np.flatnonzero(np.abs(nearer[0] - found.jacobian[number]).max(axis=1) < 1e-5)
        mine = np.flatnonzero(np.abs(fixed[0] - found.jacobian[number]).max(axis=1) < 1e-5)
        if len(theirs) != 1 or len(mine) != 1 or not np.abs(found.jacobian[number]).max() > 1e-3:
            continue
        compared += 1
        owners = query.reduced.owners(int(found.pair[number]))
        side = 1.0 if owners[1] == "ball" else -1.0
        rate = side * float(found.normal[number] @ velocity) - 0.02
        # The error has grown, so the room is a little less, and with it what is allowed.
        assert nearer[1][theirs[0]] + rate >= fixed[1][mine[0]] - 1e-4
        if time == 0.0:
            assert nearer[1][theirs[0]] + rate == pytest.approx(fixed[1][mine[0]], abs=1e-4)
    assert compared


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_singularity_rows_are_slopes_of_singular_values(name: str) -> None:
    problem = asked(name)
    query, start = Query(problem.reduced), problem.reduced.start_positions + 0.05
    frame, joints = tool_frame(problem.reduced), len(start)

    def values(positions: Floats) -> Floats:
        motion = Motion.single(positions, query)
        at = frame_jacobian(problem.reduced, motion, frame, length=LENGTH, offset=np.zeros(3))
        return singular_values(at)[0][0]

    tool = Tool.at(query, start, frame, joints)
    _, found, _, slopes = tool.singular_values()
    assert found == pytest.approx(values(start), abs=1e-12)
    assert slopes == pytest.approx(slope(values, start), abs=1e-6)
    braking = Braking(with_jerk(problem.limits), PERIOD)
    rows = tool.approach(np.full(6, 0.1), braking, np.zeros(joints))
    assert (rows.lower <= 0.0).all()
    assert rows.jacobian == pytest.approx(slopes)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_a_twist_is_followed(name: str) -> None:
    arm, servo = led(asked(name))
    turned = tool(arm, servo).rotation
    velocities = lead(arm, servo, Twist((0.0, 0.1, -0.1)), 0.8)
    assert velocities[-1] == pytest.approx((0.0, 0.1, -0.1), abs=2e-3)
    assert tool(arm, servo).rotation == pytest.approx(turned, abs=1e-2)
    assert not kinds(servo)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_stops_clear_of_a_table_and_leaves_at_full_speed(name: str) -> None:
    arm, servo = led(asked(name, TABLE))
    down = lead(arm, servo, Twist((0.0, 0.0, -SPEED)), 3.5)
    assert np.abs(down[80]).max() < 1.1 * SPEED
    assert np.abs(down[-20:, 2]).max() < 0.1 * SPEED
    assert Judge(servo.problem.reduced).examine(arm.state().positions).clear
    up = lead(arm, servo, Twist((0.0, 0.0, SPEED)), 0.5)
    assert up[-1, 2] == pytest.approx(SPEED, rel=0.02)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_singularity_limits_only_the_approach(name: str) -> None:
    problem = asked(name)
    arm, servo = led(problem)
    most = problem.limits.velocity
    for _ in range(4):
        lead(arm, servo, Twist((SPEED, 0.0, 0.1)), 1.0)
        assert (np.abs(arm.state().velocities) <= most * (1.0 + EXCESS)).all()
    held = lead(arm, servo, Twist((SPEED, 0.0, 0.1)), 0.1)
    assert np.linalg.norm(held[-1]) < 0.5 * SPEED
    back = lead(arm, servo, Twist((-SPEED, 0.0, -0.1)), 1.0)
    assert back[30:, 0].max() < -0.5 * SPEED
    assert back[-1, 0] == pytest.approx(-SPEED, rel=0.05)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_stops_within_limits_without_commands(name: str) -> None:
    problem = asked(name)
    arm, servo = led(problem)
    lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.6)
    said = arm.now() - PERIOD
    while servo.moving and arm.now() < said + 2.0:
        servo.tick()
        arm.advance(PERIOD)
        _, velocities, accelerations = arm.committed(arm.now())
        assert (np.abs(velocities) <= problem.limits.velocity * (1.0 + EXCESS)).all()
        assert (np.abs(accelerations) <= problem.limits.acceleration * (1.0 + EXCESS)).all()
    assert not arm.state().velocities.any()
    assert 0.1 < arm.now() - said < 1.0
    assert kinds(servo) == [EventKind.STOPPING]
    assert "no command" in servo.events[0].words


def test_stops_without_ticks() -> None:
    arm, servo = led(asked("panda"))
    lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.6)
    assert servo.moving
    arm.advance(0.5)
    assert not arm.state().velocities.any()


def crowded(name: str, rng: np.random.Generator) -> to.Problem:
    """Twenty boxes around the arm, none of them nearer than 5 cm to it where it starts."""
    problem = asked(name)
    while len(problem.scene.objects) < 20:
        angle, away, height = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 0.8), rng.uniform(0.0, 0.9)
        where = to.placement((away * np.cos(angle), away * np.sin(angle), height))
        scene = problem.scene.add(f"box {len(problem.scene.objects)}", to.Box(0.1, 0.1, 0.1), where)
        tried = replace(problem, scene=scene)
        wide = replace(problem, scene=problem.scene.add("wide", to.Box(0.2, 0.2, 0.2), where))
        if Judge(wide.reduced).examine(wide.reduced.start_positions).clear:
            problem = tried
    return problem


@pytest.mark.parametrize("name", ["panda", "ur5"])
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.timeout(280)
def test_random_twists_among_obstacles_keep_all_limits(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = crowded(name, rng)
    arm, servo = led(problem)
    limits, judge, names = problem.limits, Judge(problem.reduced), problem.reduced.joint_names
    jerk = with_jerk(limits).jerk
    command, gone = Twist(), 0.0
    for number in range(160):
        if number % 20 == 0:
            command = Twist(rng.uniform(-0.4, 0.4, 3), rng.uniform(-1.0, 1.0, 3))
        servo.command(command)
        servo.tick()
        ahead = arm.committed.ahead(arm.now(), names)
        if ahead is not None:
            assert np.abs(ahead(ahead.duration, 1)).max() < 1e-9
            assert (np.abs(ahead(np.linspace(0.0, ahead.duration, 50), 3)) <= jerk * 1.001).all()
        arm.advance(PERIOD)
        positions, velocities, accelerations = arm.committed(arm.now())
        assert (positions >= limits.lower).all() and (positions <= limits.upper).all()
        assert (np.abs(velocities) <= limits.velocity * (1.0 + EXCESS)).all()
        assert (np.abs(accelerations) <= limits.acceleration * (1.0 + EXCESS)).all()
        assert judge.examine(positions).clear
        gone += float(np.abs(velocities).max()) * PERIOD
    assert gone > 0.3
    assert EventKind.UNPROVEN_STOP not in kinds(servo) and EventKind.REJECTED not in kinds(servo)


def test_commands_are_shaped_before_they_are_followed() -> None:
    options = ServoOptions(period=PERIOD, dead_zone=0.1, scaling=0.2, locked=(Axis.Z,))
    arm, servo = led(asked("panda"), options)
    assert not lead(arm, servo, Twist((0.09, 0.0, 1.0)), 0.2).any()
    velocities = lead(arm, servo, Twist((0.0, 0.6, 1.0)), 0.6)
    assert velocities[-1] == pytest.approx((0.0, 0.1, 0.0), abs=2e-3)
    servo.slow_to(0.5)
    assert lead(arm, servo, Twist((0.0, 0.6, 1.0)), 0.6)[-1, 1] == pytest.approx(0.05, abs=2e-3)
    smooth = led(asked("panda"), ServoOptions(period=PERIOD, smoothing=0.2))
    assert lead(*smooth, Twist((0.0, 0.2, 0.0)), 0.2)[-1, 1] == pytest.approx(0.126, abs=0.02)


def test_twist_in_the_tool_frame_follows_its_axes() -> None:
    arm, servo = led(asked("panda"))
    along = tool(arm, servo).rotation[:, 2]
    velocities = lead(arm, servo, Twist((0.0, 0.0, 0.1), frame=servo.frame), 0.5)
    assert velocities[-1] == pytest.approx(0.1 * along, abs=2e-3)


def test_stops_for_an_appearing_obstacle() -> None:
    problem = asked("panda")
    arm, servo = led(problem)
    lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.5)
    where = tool(arm, servo).translation + np.array((0.0, 0.2, 0.0))
    world = problem.scene.add("crate", to.Box(0.1, 0.1, 0.1), to.placement(where))
    servo.see(world)
    judge = Judge(replace(problem, scene=world).reduced)
    for _ in range(20):
        lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.05)
        assert judge.examine(arm.state().positions).clear
    assert kinds(servo)[0] is EventKind.WORLD_CHANGED
    assert EventKind.UNPROVEN_STOP not in kinds(servo)


class LateOnce(IdealExecutor):
    """An executor whose clock advances during the next splices, so that they are refused as late."""

    delays: tuple[float, ...] = ()

    def splice(self, trajectory: to.Trajectory, at: float) -> str:
        if self.delays:
            self.advance(self.delays[0])
            self.delays = self.delays[1:]
        return super().splice(trajectory, at)


def test_stop_after_a_refused_one_is_the_one_that_is_driven() -> None:
    problem = asked("panda")
    arm = LateOnce(problem.reduced.joint_names, problem.reduced.start_positions)
    servo = Servo(arm, problem, ServoOptions(period=PERIOD))
    lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.5)
    where = tool(arm, servo).translation + np.array((0.0, 0.09, 0.0))
    servo.see(problem.scene.add("crate", to.Box(0.1, 0.1, 0.1), to.placement(where)))
    servo.release("test")
    arm.delays = (0.006,)
    servo.tick()
    assert kinds(servo)[-3:-1] == [EventKind.REJECTED, EventKind.STOPPING]
    stated = float(servo.events[-2].words.split("at rest in ")[1].removesuffix(" ms")) / 1e3
    begin = servo.events[-2].time + arm.latency + 2.0 * 0.006  # later by twice the time of the first search
    assert servo.committed.end - begin == pytest.approx(stated, abs=2e-3)
    arm.advance(0.5)
    assert not arm.state().velocities.any() and not arm.fault()


def test_gives_way_to_an_obstacle_on_a_track() -> None:
    problem = asked("panda")
    ball = to.Track.constant_velocity(to.placement((0.9, 0.0, 0.45)), (-0.1, 0.0, 0.0), end=5.5)
    scene = problem.scene.add("ball", to.Sphere(0.05), motion=ball)
    arm, servo = led(replace(problem, scene=scene))
    apart = np.inf
    for _ in range(60):
        lead(arm, servo, Twist(), 0.05)
        here = problem.scene.add("ball", to.Sphere(0.05), ball.at(arm.now()))
        nearest = Judge(replace(problem, scene=here).reduced).examine(arm.state().positions).smallest
        assert nearest is not None
        apart = min(apart, nearest.distance)
    assert apart > 0.0


@pytest.mark.parametrize(("torque", "moves"), [(0.4, True), (0.33, True), (0.2, False)])
def test_motors_too_weak_for_the_accelerations_move_gently(torque: float, moves: bool) -> None:
    robot = asked("panda").scene.robot.with_torque_scaling(torque)
    scene = to.Scene(robot).add("table", *TABLE)
    arm, servo = led(to.Problem(scene=scene, group="panda_arm", start="ready", goal="ready"))
    speeds = np.linalg.norm(lead(arm, servo, Twist(linear=(0.0, SPEED, -SPEED / 2)), 0.6), axis=1)
    assert (speeds[-1] > SPEED) == moves
    said = [event.words for event in servo.events]
    assert not said if moves else "panda_joint4 needs" in said[0] and "its limit is 17.4 Nm" in said[0]
    servo.release("enough")
    while servo.moving:
        servo.tick()
        arm.advance(PERIOD)
    assert servo.events[-1].kind is EventKind.STOPPING


def test_misuse_is_named() -> None:
    problem = asked("panda")
    arm, servo = led(problem)
    with pytest.raises(JointNotFound, match="panda_joint1"):
        servo.command(JointVelocities({"panda_joint_1": 1.0}))
    with pytest.raises(FrameNotFound):
        servo.command(Twist(frame="hand_of_panda"))
    with pytest.raises(ProblemError, match="factor"):
        servo.slow_to(2.0)
    with pytest.raises(ProblemError, match="period"):
        ServoOptions(period=0.1)
    with pytest.raises(FrameNotFound):
        Servo(arm, problem, frame="nowhere")
    lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.5)
    with pytest.raises(ProblemError, match="moving"):
        Servo(arm, problem)
