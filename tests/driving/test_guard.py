"""A guard drives the actions of a policy as given if they are proven, and otherwise something proven."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.oracles.query import PlainQuery
from trajopt.driving import ActionOutcome, Decision, EventKind, Guard, GuardOptions, IdealExecutor
from trajopt.driving.action_chunk import ActionChunk, along_actions
from trajopt.driving.guard import SAME
from trajopt.driving.motion_guard import guard_of
from trajopt.driving.servo_program import ApproachQuery
from trajopt.optimise.methods.timing import with_jerk
from trajopt.robot.joints import EXCESS
from trajopt.scene.reducing import reduce_model
from trajopt.timing.time_scaling import tracking
from trajopt.values.arrays import Floats
from trajopt.values.errors import ClockError, FrameNotFound, GroupNotFound, JointNotFound, ProblemError

RATE, CYCLE = 50.0, 0.02
GROUP = "panda_arm"
TIMES = np.arange(1, 51) / RATE
WALL = (to.Box(0.3, 0.02, 0.4), to.placement((0.31, -0.25, 0.6), rpy=(0.0, 0.0, -0.7)))
"""Stands upright in the way of the hand when joint 1 turns from "ready" by -0.7 rad."""


def guarded(scene: to.Scene, **given: object) -> tuple[IdealExecutor, Guard]:
    ready = scene.robot.positions("ready")[scene.robot.index(scene.robot.group(GROUP).joints)]
    arm = IdealExecutor(scene.robot.group(GROUP).joints, ready)
    return arm, Guard(scene, GROUP, arm, **given)  # type: ignore[arg-type]


def swing(begin: Floats, joint: int, size: float, rate: float = 1.0) -> Floats:
    """Return a second of smooth actions that move one joint there and not back."""
    share = np.clip(rate * TIMES, 0.0, 1.0)
    actions = np.tile(begin, (len(TIMES), 1))
    actions[:, joint] += size * (10.0 * share**3 - 15.0 * share**4 + 6.0 * share**5)
    return actions


def drive(arm: IdealExecutor, guard: Guard, seconds: float) -> Floats:
    """Tick in each cycle; return the driven states every 2 ms, shape (S, 3, n)."""
    rows = list[Floats]()
    for _ in range(round(seconds / CYCLE)):
        guard.tick()
        for _ in range(10):
            rows.append(guard.committed(arm.now()))
            arm.advance(CYCLE / 10.0)
    return np.array(rows)


def touching(scene: to.Scene, rows: Floats) -> bool:
    reduced = reduce_model(scene, GROUP, scene.robot.positions("ready"))
    found = PlainQuery(reduced).close_pairs(rows[:, 0], np.full(len(reduced.pairs.required), 1e-6))
    return bool((found.distance < 0.0).any())


@pytest.fixture(scope="module")
def free() -> to.Scene:
    return to.Scene(to.load("panda"))


@pytest.fixture(scope="module")
def walled(free: to.Scene) -> to.Scene:
    return free.add("wall", *WALL)


def test_safe_actions_pass_as_given(walled: to.Scene) -> None:
    arm, guard = guarded(walled)
    actions = swing(arm.state().positions, 0, 0.6)
    decision = guard.act(actions, rate=RATE)
    assert decision.outcome is ActionOutcome.AS_GIVEN and not decision.reason
    assert decision.unchanged == len(actions)
    np.testing.assert_allclose(decision.commanded, actions, atol=SAME)
    rows = drive(arm, guard, 1.2)
    np.testing.assert_allclose(rows[-1, 0], actions[-1], atol=SAME)
    assert not touching(walled, rows)


def test_overlapping_chunks_of_one_motion_pass_without_a_stop(free: to.Scene) -> None:
    arm, guard = guarded(free)
    whole = swing(arm.state().positions, 0, 0.8)
    for begin in (0, 15, 30):
        assert guard.act(whole[begin:], rate=RATE).outcome is ActionOutcome.AS_GIVEN
        rows = drive(arm, guard, 0.3)
        if begin < 30:
            assert np.abs(rows[-1, 1]).max() > 0.1


@pytest.mark.parametrize(("count", "rate"), [(1, 10.0), (1, 20.0), (1, 30.0), (2, 50.0), (3, 100.0)])
def test_short_chunks_of_a_slow_motion_are_followed(free: to.Scene, count: int, rate: float) -> None:
    """Each begins from the state in which the one before ends: errors must not grow from one to the next."""
    arm, guard = guarded(free)
    begin, worst = arm.state().positions, 0.0

    def wanted(time: float) -> Floats:
        return begin + 0.05 * np.sin(2.0 * time) * (1.0 - np.exp(-(time**3)))

    while arm.now() < 4.0:
        due = arm.now() + np.arange(1, count + 1) / rate
        guard.act(np.array([wanted(time) for time in due.tolist()]), rate=rate)
        for _ in range(5):
            arm.advance(0.2 / rate)
            worst = max(worst, float(np.abs(arm.state().commanded - wanted(arm.now())).max()))
    assert worst < 5e-3


@pytest.mark.parametrize(("count", "rate"), [(1, 20.0), (2, 30.0), (10, 30.0), (50, 50.0)])
def test_chunks_far_from_the_arm_are_reached(free: to.Scene, count: int, rate: float) -> None:
    arm, guard = guarded(free)
    goal, most = arm.state().positions + 0.3, 0.0
    while arm.now() < 2.5:
        guard.act(np.tile(goal, (count, 1)), rate=rate)
        for _ in range(5):
            arm.advance(max(1, count // 2) / rate / 5)
            guard.tick()
            most = max(most, float((arm.state().commanded - goal).max()))
    assert most < 0.05
    np.testing.assert_allclose(arm.state().commanded, goal, atol=SAME)


def test_the_reason_names_the_limits_that_a_motion_breaks(free: to.Scene) -> None:
    weak = replace(free, robot=free.robot.with_torque_scaling(0.3))
    upright = to.axis_alignment("panda_hand", direction=(0.0, 0.0, -1.0), tolerance=0.2)
    for scene, constraints, joint, words in (
        (weak, [], 1, "torque"),
        (free, [upright], 5, "path constraints"),
    ):
        arm, guard = guarded(scene, constraints=constraints)
        decision = guard.act(swing(arm.state().positions, joint, 0.6, 1.0), rate=RATE)
        assert decision.outcome is not ActionOutcome.AS_GIVEN
        assert words in decision.reason


def test_actions_that_come_to_rest_at_a_position_limit_pass_as_given(free: to.Scene) -> None:
    joints, robot = free.robot.group(GROUP).joints, free.robot
    place = robot.joint_names.index(joints[0])
    upper = np.array(robot.limits.upper)
    upper[place] = robot.positions("ready")[place] + 0.3
    narrow = replace(free, robot=replace(robot, limits=replace(robot.limits, upper=upper)))
    arm, guard = guarded(narrow)
    actions = swing(guard.committed(0.0)[0], 0, 0.3, 2.0)
    assert actions[-1, 0] == upper[place]
    for begin in (0, 20, 40):
        decision = guard.act(actions[begin:], rate=RATE)
        assert decision.outcome is ActionOutcome.AS_GIVEN
        assert decision.unchanged == len(actions) - begin
        drive(arm, guard, 20 / RATE)
    assert abs(guard.committed(arm.now())[0, 0] - upper[place]) <= SAME


def test_actions_before_one_beyond_a_position_limit_pass_as_given(free: to.Scene) -> None:
    """But for the last four, after which nothing could stop before the limit."""
    arm, guard = guarded(free)
    actions = swing(arm.state().positions, 3, -1.3, rate=0.8)
    lowest = free.robot.limits.lower[free.robot.joint_names.index("panda_joint4")]
    first = int((actions[:, 3] < lowest).argmax())
    assert first == 32
    guard.act(actions, rate=RATE)
    rows = drive(arm, guard, 1.2)
    driven = rows[10 * np.arange(1, first + 1), 0]
    assert (np.abs(driven - actions[:first]).max(axis=1) <= SAME).sum() >= first - 4
    assert rows[:, 0, 3].min() >= lowest


def test_actions_into_an_obstacle_end_before_it(walled: to.Scene) -> None:
    arm, guard = guarded(walled)
    decisions = list[Decision]()
    rows = list[Floats]()
    for _ in range(4):
        decisions.append(guard.act(swing(arm.state().positions, 0, -1.0), rate=RATE))
        rows.append(drive(arm, guard, 0.5))
    driven = np.concatenate(rows)
    assert touching(walled, swing(driven[0, 0], 0, -1.0)[:, None])
    assert not touching(walled, driven)
    assert {each.outcome for each in decisions} != {ActionOutcome.AS_GIVEN}
    assert any("and wall would be too near to each other at" in each.reason for each in decisions)


@pytest.mark.parametrize("moving", [False, True])
def test_motions_that_collide_at_a_point_are_not_proven(
    walled: to.Scene, moving: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So it costs no motion that they are left out."""
    standing = to.Track.through([0.0, 9.0], [WALL[1], WALL[1]])
    arm, guard = guarded(walled.with_motion("wall", standing) if moving else walled)
    guard.act(swing(arm.state().positions, 0, -1.0), rate=RATE)
    drive(arm, guard, 0.3)
    found, measured, proves = list[float](), ApproachQuery.contact, guard_of(guard.problem, arm)

    def contact(self: ApproachQuery, motion: to.Trajectory, time: float) -> float:
        found.append(measured(self, motion, time))
        assert found[-1] == np.inf or not proves.proven(motion, guard.world, arm.now())
        return found[-1]

    monkeypatch.setattr(ApproachQuery, "contact", contact)
    guard.act(swing(guard.committed(0.0)[0], 0, -1.0), rate=RATE, stamp=0.0)
    assert found[0] < np.inf and found[-1] == np.inf


def test_actions_of_an_arm_in_contact_are_not_driven(free: to.Scene) -> None:
    arm, guard = guarded(free)
    hand = free.placement_of("panda_hand", free.robot.positions("ready"))
    touching = free.add("ball", to.Sphere(0.05), to.placement(tuple(hand.translation)))
    guard.see(touching)
    for joint in range(7):
        decision = guard.act(swing(arm.state().positions, joint, 0.3), rate=RATE)
        assert decision.outcome is ActionOutcome.STOPPED
        assert (
            decision.reason == "panda_link7 and ball would be too near to each other at 0.00 s of the motion"
        )
        assert np.ptp(drive(arm, guard, 0.2)[:, 0], axis=0).max() == 0.0


@pytest.mark.parametrize("seed", range(3))
def test_a_random_network_touches_nothing_and_keeps_the_limits(walled: to.Scene, seed: int) -> None:
    drawn = np.random.default_rng(seed)
    arm, guard = guarded(walled)
    limits = with_jerk(guard.problem.limits)
    first, second = drawn.normal(size=(16, 7)), drawn.normal(size=(7, 16))
    rows = list[Floats]()
    for _ in range(6):
        here, actions = arm.state().positions, list[Floats]()
        for _ in TIMES:
            here = here + 0.04 * np.tanh(second @ np.tanh(first @ here))
            actions.append(here)
        guard.act(np.array(actions), rate=RATE)
        rows.append(drive(arm, guard, 0.4))
    driven = np.concatenate(rows)
    assert not touching(walled, driven)
    assert np.ptp(driven[:, 0], axis=0).max() > 0.1
    for state, most in ((driven[:, 1], limits.velocity), (driven[:, 2], limits.acceleration)):
        assert (np.abs(state) <= most * (1.0 + 2.0 * EXCESS)).all()
    assert (driven[:, 0] >= limits.lower).all() and (driven[:, 0] <= limits.upper).all()


def test_a_policy_that_changes_everything_touches_nothing_and_keeps_the_limits(walled: to.Scene) -> None:
    """Joint positions or poses, rate, number, age and size of its actions change from chunk to chunk."""
    drawn, rows = np.random.default_rng(5), list[Floats]()
    arm, guard = guarded(walled)
    limits = with_jerk(guard.problem.limits)
    for number in range(40):
        here, count = arm.state().positions, int(drawn.integers(1, 201))
        rate, age = float(np.exp(drawn.uniform(0.0, np.log(1000.0)))), float(drawn.choice((0.0, 0.1, 100.0)))
        steps = np.exp(drawn.uniform(-8.0, 0.0)) * drawn.normal(size=(count, 7))
        if number % 4:
            actions = (here + np.cumsum(steps, axis=0)).astype(np.float32)
            actions[drawn.integers(count)] *= drawn.choice((1.0, 1e5))
            guard.act(actions, rate=rate, stamp=arm.now() - age)
        else:
            tool = walled.placement_of(guard.frame, guard.problem.reduced.all_positions(here))
            poses = [to.Placement(tool.rotation, tool.translation + step[:3]) for step in steps[:10]]
            guard.act_poses(poses, rate=rate, stamp=arm.now() - age)
        rows.append(drive(arm, guard, float(drawn.choice((0.02, 0.1, 0.3)))))
    driven = np.concatenate(rows)
    assert not touching(walled, driven) and not arm.fault()
    assert np.ptp(driven[:, 0], axis=0).max() > 0.5
    for state, most in ((driven[:, 1], limits.velocity), (driven[:, 2], limits.acceleration)):
        assert (np.abs(state) <= most * (1.0 + 2.0 * EXCESS)).all()
    assert (driven[:, 0] >= limits.lower).all() and (driven[:, 0] <= limits.upper).all()


@pytest.mark.parametrize(
    "actions",
    [
        np.full((50, 7), np.nan),
        np.full((50, 7), np.inf),
        np.full((50, 7), 1e300),
        np.zeros((50, 6)),
        np.zeros(7),
        np.zeros((201, 7)),
        [],
        "left",
        None,
    ],
    ids=["nan", "infinite", "huge", "too narrow", "one row", "too many", "none", "text", "nothing"],
)
def test_invalid_actions_stop_the_robot(free: to.Scene, actions: object) -> None:
    arm, guard = guarded(free)
    guard.act(swing(arm.state().positions, 0, 0.8), rate=RATE)
    assert np.abs(drive(arm, guard, 0.4)[-1, 1]).max() > 0.1
    decision = guard.act(actions, rate=RATE)  # type: ignore[arg-type]
    assert decision.outcome is ActionOutcome.STOPPED and "actions" in decision.reason
    assert len(decision.commanded) == 0
    assert np.abs(drive(arm, guard, 0.4)[-1, 1]).max() == 0.0
    assert EventKind.UNPROVEN_STOP not in {event.kind for event in guard.events}


class Tensor:
    """As a tensor of PyTorch that an array cannot be made of."""

    def __array__(self, dtype: object = None, copy: object = None) -> Floats:
        raise RuntimeError(
            "Can't call numpy() on Tensor that requires grad. Use tensor.detach().numpy() instead."
        )


def test_a_tensor_that_is_not_an_array_stops_the_robot_with_its_own_remedy(free: to.Scene) -> None:
    arm, guard = guarded(free)
    guard.act(swing(arm.state().positions, 0, 0.8), rate=RATE)
    drive(arm, guard, 0.4)
    decision = guard.act(Tensor(), rate=RATE)
    assert decision.outcome is ActionOutcome.STOPPED and "Use tensor.detach().numpy()" in decision.reason
    assert np.abs(drive(arm, guard, 0.4)[-1, 1]).max() == 0.0


def test_a_robot_that_does_not_follow_is_described(free: to.Scene) -> None:
    arm, guard = guarded(free)
    arm.displace(np.full(7, 0.01))
    decision = guard.act(swing(arm.state().positions, 0, 0.1), rate=RATE)
    assert decision.outcome is ActionOutcome.STOPPED and "has to be at" in decision.reason
    assert "the driver stopped the robot" in guard.act(np.zeros((1, 7)), rate=RATE).reason


def test_an_arm_outside_its_limits_is_not_taken_over(free: to.Scene) -> None:
    joints, robot = free.robot.group(GROUP).joints, free.robot
    begin = robot.positions("ready")[robot.index(joints)]
    begin[0] = robot.limits.upper[robot.index(joints)[0]] + 1e-3
    with pytest.raises(ProblemError, match=r"panda_joint1 is at .*, outside its limits .*; move it inside"):
        Guard(free, GROUP, IdealExecutor(joints, begin))


def test_a_silent_policy_ends_at_rest(free: to.Scene) -> None:
    arm, guard = guarded(free)
    actions = swing(arm.state().positions, 0, 0.8)[:25]
    guard.act(actions, rate=RATE)
    rows = drive(arm, guard, 1.0)
    assert np.abs(rows[250, 1]).max() > 0.1 and np.abs(rows[-1, 1:]).max() == 0.0


def test_late_actions_are_dropped(free: to.Scene) -> None:
    arm, guard = guarded(free)
    actions = swing(arm.state().positions, 0, 0.4)
    arm.advance(5.0)
    half = guard.act(actions, rate=RATE, stamp=arm.now() - 0.5)
    assert half.outcome is not ActionOutcome.STOPPED and half.unchanged <= 25
    arm.advance(5.0)
    late = guard.act(actions, rate=RATE, stamp=arm.now() - 1.0)
    assert late.outcome is ActionOutcome.STOPPED and "no action is left" in late.reason
    np.testing.assert_allclose(late.commanded, np.tile(arm.state().positions, (len(actions), 1)), atol=1e-12)


def test_actions_that_are_too_fast_are_driven_slower(free: to.Scene) -> None:
    arm, guard = guarded(free)
    actions = swing(arm.state().positions, 0, 2.0, rate=2.5)
    decision = guard.act(actions, rate=RATE)
    assert decision.outcome is ActionOutcome.SLOWED and "limits" in decision.reason
    drive(arm, guard, 4.0)
    np.testing.assert_allclose(arm.state().positions, actions[-1], atol=0.02)


def test_noise_is_smoothed(free: to.Scene) -> None:
    arm, guard = guarded(free)
    exact = swing(arm.state().positions, 0, 0.5)
    noisy = exact + 2e-3 * np.random.default_rng(0).standard_normal(exact.shape)
    decision = guard.act(noisy, rate=RATE)
    assert decision.outcome is ActionOutcome.SMOOTHED
    assert np.abs(decision.commanded - exact).max() < 0.02


def test_a_jump_is_not_followed_faster_than_the_limits(free: to.Scene) -> None:
    arm, guard = guarded(free)
    actions = swing(arm.state().positions, 0, 0.3)
    actions[25:, 3] += 0.8
    guard.act(actions, rate=RATE)
    driven = drive(arm, guard, 1.5)
    assert (np.abs(driven[:, 1]) <= guard.problem.limits.velocity * (1.0 + 2.0 * EXCESS)).all()


def test_an_obstacle_that_appears_stops_the_robot_before_it(free: to.Scene, walled: to.Scene) -> None:
    arm, guard = guarded(free)
    assert guard.act(swing(arm.state().positions, 0, -1.0), rate=RATE).outcome is ActionOutcome.AS_GIVEN
    before = drive(arm, guard, 0.2)
    guard.see(walled)
    after = drive(arm, guard, 1.5)
    assert not touching(walled, np.concatenate((before, after)))
    assert np.abs(after[-1, 1:]).max() == 0.0
    assert EventKind.STOPPING in {event.kind for event in guard.events}


def test_poses_of_the_tool_are_reached(free: to.Scene) -> None:
    arm, guard = guarded(free)

    def tool() -> to.Placement:
        reduced = guard.problem.reduced
        return free.placement_of(guard.frame, reduced.all_positions(arm.state().positions))

    begin = tool()
    share = 10.0 * TIMES**3 - 15.0 * TIMES**4 + 6.0 * TIMES**5
    poses = [
        to.Placement(begin.rotation, begin.translation + part * np.array((0.0, 0.1, -0.05))) for part in share
    ]
    assert guard.act_poses(poses, rate=RATE).outcome is ActionOutcome.AS_GIVEN
    drive(arm, guard, 1.5)
    np.testing.assert_allclose(tool().translation, poses[-1].translation, atol=1e-3)
    np.testing.assert_allclose(tool().rotation, begin.rotation, atol=1e-3)


def test_the_pose_that_is_out_of_reach_is_named(free: to.Scene) -> None:
    arm, guard = guarded(free)
    begin = free.placement_of(guard.frame, guard.problem.reduced.all_positions(arm.state().positions))
    far = to.Placement(begin.rotation, begin.translation + np.array((2.0, 0.0, 0.0)))
    decision = guard.act_poses([begin] * 10 + [far], rate=RATE)
    assert "pose 10 is not reached" in decision.reason


@pytest.mark.parametrize("valid", [0, 10])
def test_poses_that_are_not_numbers_are_dropped(free: to.Scene, valid: int) -> None:
    arm, guard = guarded(free)
    here = free.placement_of(guard.frame, guard.problem.reduced.all_positions(arm.state().positions))
    bad = to.Placement(here.rotation, np.full(3, np.nan))
    decision = guard.act_poses([here] * valid + [bad] * 5, rate=RATE)
    assert f"pose {valid} is not finite" in decision.reason and len(decision.commanded) == valid
    assert decision.outcome is (ActionOutcome.SHORTENED if valid else ActionOutcome.STOPPED)


def test_poses_are_followed_beside_dynamic_obstacles(free: to.Scene) -> None:
    away = to.Track.through([0.0, 5.0], [to.placement((1.0, y, 1.0)) for y in (1.0, -1.0)])
    arm, guard = guarded(free.add("ball", to.Sphere(0.05), motion=away))
    here = free.placement_of(guard.frame, guard.problem.reduced.all_positions(arm.state().positions))
    lower = to.Placement(here.rotation, here.translation - np.array((0.0, 0.0, 0.005)))
    assert guard.act_poses([here] * 10 + [lower] * 20, rate=RATE).outcome is not ActionOutcome.STOPPED


def test_the_cloud_of_a_camera_stops_the_robot(free: to.Scene) -> None:
    arm, guard = guarded(free)
    assert guard.act(swing(arm.state().positions, 0, -1.0), rate=RATE).outcome is ActionOutcome.AS_GIVEN
    drive(arm, guard, 0.2)
    points = WALL[1].translation + np.random.default_rng(0).uniform(-0.05, 0.05, (200, 3))
    assert guard.see_cloud("camera", to.Points(points, radius=0.02))
    drive(arm, guard, 0.5)
    assert EventKind.STOPPING in {event.kind for event in guard.events}
    assert not guard.see_cloud("camera", None, stamp=0.1), "an older image counts"


def test_misuse_is_refused(free: to.Scene) -> None:
    arm, guard = guarded(free)
    actions = swing(arm.state().positions, 0, 0.1)
    for rate in (0.0, 1e-300, 1e4):
        with pytest.raises(ProblemError, match="rate must be from 1 to 1000 Hz"):
            guard.act(actions, rate=rate)
    with pytest.raises(ClockError, match="ahead of the executor's clock"):
        guard.act(actions, rate=RATE, stamp=10.0)
    with pytest.raises(GroupNotFound, match="panda_arm"):
        Guard(free, "panda_arms", arm)
    with pytest.raises(JointNotFound, match="no joint that is driven named 'panda_finger_joint1'"):
        Guard(free, "hand", arm)
    with pytest.raises(FrameNotFound, match="hand"):
        Guard(free, GROUP, arm, frame="hands")
    with pytest.raises(ProblemError, match="lead"):
        GuardOptions(lead=-1.0)


states = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6)


@settings(max_examples=50, deadline=None)
@given(begin=states, seed=st.integers(0, 1000), count=st.integers(1, 12), first=st.floats(0.005, 0.05))
def test_tracking_minimises_its_cost(
    free: to.Scene, begin: list[float], seed: int, count: int, first: float
) -> None:
    """Its states follow from its jerks, and its cost has no slope: by Taylor series, one after the other."""
    limits = with_jerk(to.Problem(scene=free, group=GROUP, start="ready", goal="ready").limits)
    state = np.zeros((3, 7))
    state[:, :2] = np.reshape(begin, (3, 2))
    drawn = np.random.default_rng(seed)
    times = first + np.arange(count) / RATE
    due = np.sort(drawn.permutation(count)[: int(drawn.integers(1, count + 1))])
    targets, counted = drawn.normal(size=(len(due), 7)), int(drawn.integers(1, len(due) + 1))
    weight = float(10.0 ** drawn.uniform(-6.0, -3.0))
    states, found_jerks, within = tracking(
        state, np.append(0.0, times), due + 1, targets, np.array((weight,)), limits, counted=counted
    )

    def integrated(jerks: Floats) -> Floats:
        q, v, a = state
        found, before = [state], 0.0
        for jerk, time in zip(jerks, times, strict=True):
            h, before = time - before, time
            q = q + h * v + h**2 * a / 2.0 + h**3 * jerk / 6.0
            v, a = v + h * a + h**2 * jerk / 2.0, a + h * jerk
            found.append(np.stack((q, v, a)))
        return np.stack(found, axis=1)

    np.testing.assert_allclose(integrated(found_jerks), states, atol=1e-6, rtol=1e-9)
    beyond = np.abs(found_jerks) > limits.jerk
    beyond |= np.abs(states[1, 1:]) > limits.velocity
    beyond |= np.abs(states[2, 1:]) > limits.acceleration
    beyond |= np.clip(states[0, 1:], limits.lower, limits.upper) != states[0, 1:]
    until = int(beyond.any(axis=1).argmax()) if beyond.any() else count
    assert within == min(int((due < until).sum()), counted)

    def cost(jerks: Floats) -> float:
        off = integrated(jerks)[0, due + 1] - targets
        return float((off**2).sum() + ((weight * jerks) ** 2).sum())

    least, size = cost(found_jerks), float(np.abs(found_jerks).max())
    for _ in range(5):
        other = found_jerks + size * 1e-2 * drawn.normal(size=found_jerks.shape)
        assert cost(other) >= least * (1.0 - 1e-9)


def test_the_first_deviation_counts_that_keeps_the_limits_at_most_actions(free: to.Scene) -> None:
    limits = with_jerk(to.Problem(scene=free, group=GROUP, start="ready", goal="ready").limits)
    state, times = np.zeros((3, 7)), np.arange(1, 21) / RATE
    state[0] = (limits.lower + limits.upper) / 2.0
    deviations = (1e-5, 1e-3, 3e-2, 0.3)
    for seed in range(20):
        steps = np.random.default_rng(seed).normal(size=(20, 7))
        chunk = ActionChunk.following(
            None, state[0] + 10.0 ** (-seed / 4.0) * np.cumsum(steps, axis=0), times
        )
        single = [along_actions(state, 0.0, chunk, (each,), limits) for each in deviations]
        wanted = max(single, key=lambda motion: motion.within)
        found = along_actions(state, 0.0, chunk, deviations, limits)
        assert found.within == wanted.within
        np.testing.assert_array_equal(found.states, wanted.states)


def test_the_rest_of_a_chunk_is_interpolated_between_actions() -> None:
    chunk = ActionChunk.following(None, np.array(((0.0,), (1.0,), (3.0,))), np.array((0.1, 0.2, 0.3)))
    for time, value, slope in ((0.0, 0.0, 10.0), (0.15, 0.5, 10.0), (0.25, 2.0, 20.0), (0.4, 3.0, 0.0)):
        found = chunk.target(time)
        assert found[0] == pytest.approx(value) and found[1] == pytest.approx(slope)
