"""Goals that move are met: a conveyor, a turning table, and what no motion can meet."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.verify.test_moving_things import sampled
from trajopt.timing.time_scaling import begun_later

DOWN = (np.pi, 0.0, 0.0)
STEP = 1e-4
"""Of the differences that velocities are checked with [s]."""


@pytest.fixture(scope="module")
def cell() -> to.Scene:
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    return to.Scene(panda).with_tool("grip", on="panda_hand", placement=to.placement((0.0, 0.0, 0.1034)))


def belt(cell: to.Scene, *, speed: float = 0.2, turning: float = 0.0, y: float = -0.8) -> to.Scene:
    begin = to.placement((0.5, y, 0.1))
    track = to.Track.constant_velocity(begin, (0.0, speed, 0.0), angular_velocity=(0.0, 0.0, turning))
    scene = cell.add("belt", to.Box(0.3, 0.2, 0.02), motion=track)
    return scene.add("part", to.Box(0.04, 0.04, 0.1), to.placement((0.1, 0.0, 0.06)), frame="belt")


def asked(scene: to.Scene, *, height: float = 0.12, dwell: float = 0.5) -> to.Problem:
    """Return the problem to be above the part, fingers open, or around it."""
    robot = scene.robot
    start = np.array(robot.positions("ready"))
    start[robot.index([name for name in robot.joint_names if "finger" in name])] = 0.04
    goal = to.frame_placement("grip", to.placement((0.0, 0.0, height), rpy=DOWN), reference="part")
    return to.Problem(scene=scene, group="panda_arm", start=start, goal=goal, dwell=dwell)


def seen_from_part(problem: to.Problem, motion: to.Trajectory, time: float) -> to.Placement:
    """Return where the grip is as seen from the part, by pinocchio and the track."""
    reduced, scene = problem.reduced, problem.scene
    data = reduced.model.createData()
    pin.forwardKinematics(reduced.model, data, reduced.configuration(motion(time)))
    joint, place = reduced.attachment("grip")
    grip = to.Placement(data.oMi[joint].rotation, data.oMi[joint].translation) * place
    known = scene.objects["belt"].timing.motion
    assert known is not None
    return (known.track.at(time) * scene.objects["part"].placement).inverse() * grip


def check_followed(problem: to.Problem, motion: to.Trajectory, height: float) -> None:
    """Check by differences that the grip is where it must be, and at rest as seen from the part."""
    wanted = Rotation.from_euler("xyz", DOWN).as_matrix()
    for time in np.linspace(motion.duration - problem.dwell, motion.duration - 2.0 * STEP, 30).tolist():
        here, next_ = (seen_from_part(problem, motion, moment) for moment in (time, time + STEP))
        assert here.translation == pytest.approx((0.0, 0.0, height), abs=1e-4)
        assert here.rotation == pytest.approx(wanted, abs=1e-3)
        assert np.linalg.norm(next_.translation - here.translation) / STEP < 1e-3
        assert np.abs(next_.rotation - here.rotation).max() / STEP < 1e-2


@pytest.mark.parametrize(("speed", "turning", "y"), [(0.2, 0.0, -0.8), (0.0, 0.5, 0.0), (0.1, 0.2, -0.3)])
@pytest.mark.parametrize("height", [0.12, 0.02])
def test_a_moving_goal_is_met_and_followed(
    cell: to.Scene, speed: float, turning: float, y: float, height: float
) -> None:
    problem = asked(belt(cell, speed=speed, turning=turning, y=y), height=height)
    result = to.plan(problem)
    motion = result.require().trajectory
    check_followed(problem, motion, height)
    assert sampled(problem.scene, problem.reduced, motion) > 0.0
    assert "meets 'belt' at" in result.remarks[0] and "stays with it for 0.5 s" in result.remarks[0]
    assert motion.duration < 3.0
    for wrong in (0.02, -0.02):
        moved = replace(problem, scene=belt(cell, speed=speed + wrong, turning=turning, y=y))
        assert not to.judge(moved, motion).verified, "the belt is not as fast"


def test_a_moving_goal_is_met_by_a_slow_tool(cell: to.Scene) -> None:
    problem = replace(asked(belt(cell)), tool_speed=to.tool_speed("grip", linear=0.3))
    check_followed(problem, to.plan(problem).require().trajectory, 0.12)


def test_a_waypoint_is_passed_before_the_goal_is_followed(cell: to.Scene) -> None:
    problem = replace(asked(belt(cell)), waypoints={"aside": {"panda_joint1": -0.6, "panda_joint4": -1.8}})
    plan = to.plan(problem).require()
    check_followed(problem, plan.trajectory, 0.12)
    assert plan.certificate.passing_time("aside") is not None


def test_without_dwell_it_ends_as_it_meets(cell: to.Scene) -> None:
    problem = asked(belt(cell), dwell=0.0)
    motion = to.plan(problem).require().trajectory
    assert np.abs(motion(motion.duration, 1)).max() > 1e-2, "it ends in motion"
    check_followed(replace(problem, dwell=2.5 * STEP), motion, 0.12)


def test_the_next_motion_continues_from_the_meeting(cell: to.Scene) -> None:
    problem = asked(belt(cell), dwell=0.2)
    motion = to.plan(problem).require().trajectory
    end, names = motion.duration, motion.joint_names
    lifted = replace(
        problem,
        scene=cell,
        start=problem.reduced.all_positions(motion.positions[-1]),
        start_velocity=dict(zip(names, motion(end, 1).tolist(), strict=True)),
        start_acceleration=dict(zip(names, motion(end, 2).tolist(), strict=True)),
        goal="ready",
        dwell=0.0,
    )
    onward = to.plan(lifted).require().trajectory
    assert motion.followed_by(onward).duration == pytest.approx(end + onward.duration)


def test_it_waits_for_a_late_goal(cell: to.Scene) -> None:
    problem = asked(belt(cell, speed=0.1, y=-1.5))
    motion = to.plan(problem).require().trajectory
    assert motion.duration > 5.0
    assert not np.abs(motion(np.linspace(0.0, 2.0, 20), 1)).any(), "it rests before"
    assert not to.judge(problem, begun_later(motion, 0.1)).verified


def test_the_goal_that_is_met_soonest_is_taken(cell: to.Scene) -> None:
    scene = belt(cell)
    far = scene.add("other", to.Box(0.04, 0.04, 0.1), to.placement((0.1, -0.7, 0.06)), frame="belt")
    above = {
        name: to.frame_placement("grip", to.placement((0.0, 0.0, 0.12), rpy=DOWN), reference=name)
        for name in ("other", "part")
    }
    result = to.plan(replace(asked(far), goal=to.any_of(above)))
    alone = to.plan(replace(asked(far), goal=above["part"]))
    assert result.goal_name == "part"
    assert result.require().trajectory.duration == pytest.approx(alone.require().trajectory.duration, abs=0.1)


def test_a_moving_goal_out_of_reach_is_reported(cell: to.Scene) -> None:
    track = to.Track.through([0.0, 4.0], [to.placement((2.0, y, 0.1)) for y in (-1.0, 1.0)])
    scene = cell.add("belt", to.Box(0.3, 0.2, 0.02), motion=to.Prediction(track, until=5.0))
    scene = scene.add("part", to.Box(0.04, 0.04, 0.1), to.placement((0.1, 0.0, 0.06)), frame="belt")
    result = to.plan(asked(scene))
    assert result.status is to.Status.NO_INVERSE_KINEMATICS
    assert "where the goal is at" in result.reason and "too short" in result.reason


def test_an_obstacle_at_the_meeting_is_reported(cell: to.Scene) -> None:
    scene = belt(cell, turning=0.3, speed=0.0, y=0.0)
    lid = scene.add("lid", to.Box(0.2, 0.2, 0.02), to.placement((0.1, 0.0, 0.2)), frame="belt")
    result = to.plan(asked(lid), budget=to.Budget(seconds=20.0))
    assert not result.verified and "lid" in result.reason


def test_a_deadline_is_kept_or_missed(cell: to.Scene) -> None:
    problem = asked(belt(cell))
    met = to.plan(problem).require().trajectory.duration - problem.dwell
    assert to.plan(replace(problem, finish_by=met + 0.1)).verified
    result = to.plan(replace(problem, finish_by=1.0))
    assert result.status is to.Status.TOO_LATE
    assert "no meeting by 1 s was found" in result.reason
