"""What the judge proves of a cloud is what it proves of its balls; and what planning makes of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.scene.clouds.scenes_for_tests import ball_parts, some_points
from trajopt.problem.requirements import JointPositions
from trajopt.values.arrays import one_of
from trajopt.verify import Certificate, Check, CheckKind

RESOLUTION = 1.1e-3


def clearance(certificate: Certificate) -> Check:
    return next(check for check in certificate.checks if check.kind is CheckKind.CLEARANCE)


def beside(
    cloud: to.Points | to.Voxels, *, parts: bool, goal: float = 1.2, margin: float | None = None
) -> to.Problem:
    robot = to.load("planar2")
    scene = to.Scene(robot).add("cloud", ball_parts(cloud) if parts else cloud)
    if margin is not None:
        scene = scene.with_clearance(margin)
    start = dict(zip(robot.joint_names, (-1.2, 0.3), strict=True))
    end = dict(zip(robot.joint_names, (goal, -0.4), strict=True))
    return to.Problem(scene=scene, start=start, goal=to.joint_positions(end))


def straight(problem: to.Problem) -> to.Trajectory:
    reduced, stated = problem.reduced, one_of("goal", problem.goals[0], JointPositions).positions
    ends = np.stack((reduced.start_positions, [stated[name] for name in reduced.joint_names]))
    return to.Trajectory(reduced.joint_names, np.array((0.0, 3.0)), ends, np.zeros((2, 2)), np.zeros((2, 2)))


def around_arm(seed: int, count: int) -> to.Points:
    """Return balls where the arm sweeps, a little above and below it too."""
    random = np.random.default_rng(seed)
    angle, reach = random.uniform(-2.0, 2.0, count), random.uniform(0.3, 1.2, count)
    height = 0.14 + random.choice((-1.0, 1.0), count) * random.uniform(0.03, 0.2, count)
    points = np.stack((reach * np.cos(angle), reach * np.sin(angle), height), axis=1)
    return to.Points(points, float(random.uniform(0.004, 0.03)))


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 100_000), count=st.integers(3, 120))
def test_the_same_verdict_as_of_single_balls(seed: int, count: int) -> None:
    cloud = around_arm(seed, count)
    found = list[Check]()
    for parts in (False, True):
        problem = beside(cloud, parts=parts)
        found.append(clearance(to.judge(problem, straight(problem))))
    mine, single = found
    assert mine.holds == single.holds
    if mine.holds:
        assert mine.slack == pytest.approx(single.slack, abs=RESOLUTION)


@pytest.mark.parametrize("off", (-RESOLUTION, 5e-5))
def test_a_near_miss_is_distinguished_from_contact(off: float) -> None:
    """A ball among others that grows until the motion just misses it, or just touches."""
    ball = to.Points(np.array([(0.6, 0.0, 0.8), (0.9, 0.2, 0.7), (-0.6, 0.0, 0.6)]), 0.05)
    problem = beside(ball, parts=False)
    apart = clearance(to.judge(problem, straight(problem))).slack
    assert apart is not None
    assert apart > 0.05
    grown = to.Points(ball.points, 0.05 + apart - off)
    certificate = to.judge(beside(grown, parts=False), straight(problem))
    if off > RESOLUTION:
        assert clearance(certificate).holds
    assert (
        clearance(certificate).holds
        == clearance(to.judge(beside(grown, parts=True), straight(problem))).holds
    )


def test_planned_past_a_cloud_and_judged_beside_its_balls() -> None:
    grid = np.stack(np.meshgrid(0.75, np.arange(-0.1, 0.1, 0.01), np.arange(0.0, 0.3, 0.01)), axis=-1)
    cloud = to.Points(grid.reshape(-1, 3), 0.008)
    result = to.plan(beside(cloud, parts=False))
    single = beside(cloud, parts=True)
    assert not clearance(to.judge(single, straight(single))).holds
    assert result.status is to.Status.SOLVED
    assert clearance(to.judge(single, result.require().trajectory)).holds


def test_a_mutated_motion_is_refused() -> None:
    """A motion that is moved into the cloud anywhere is not verified."""
    cloud = to.Points(np.array([(0.0, 0.0, 2.0), (1.0, 0.0, 0.9)]), 0.05)
    problem = beside(cloud, parts=False)
    certificate = to.judge(problem, straight(problem))
    where = straight(problem)(np.linspace(0.0, 3.0, 31))
    tips = [problem.scene.placement_of("tool", problem.reduced.all_positions(q)).translation for q in where]
    assert certificate is not None
    for tip in tips[1:-1:6]:
        struck = to.Points(
            np.concatenate((some_points(4, 500).points + np.array((0.0, 5.0, 0.0)), [tip])), 0.003
        )
        assert not clearance(to.judge(beside(struck, parts=False), straight(problem))).holds


def test_required_clearance_of_a_cloud() -> None:
    cloud = around_arm(5, 30)
    for margin in (0.0, 0.01, 0.05):
        verdicts = list[bool]()
        for parts in (False, True):
            problem = beside(cloud, parts=parts, margin=margin)
            verdicts.append(clearance(to.judge(problem, straight(problem))).holds)
        assert verdicts[0] == verdicts[1]


def test_points_inside_the_robot_are_named() -> None:
    robot = to.load("planar2")
    at = to.Scene(robot).placement_of("link2", np.array((-1.2, 0.3))).translation
    problem = beside(to.Points(at + some_points(2, 50).points * 0.05, 0.01), parts=False)
    result = to.plan(problem)
    assert result.status is to.Status.START_IN_COLLISION
    assert "cloud" in result.message


def test_a_carried_cloud_and_a_track(tmp_path: object) -> None:
    """A cloud on a link keeps from the world, and one that moves by itself from the robot, as balls do."""
    del tmp_path
    statuses = list[bool]()
    cloud = to.Points(some_points(6, 30).points * 0.1, 0.01)
    for parts in (False, True):
        problem = beside(to.Points(np.array([(0.0, 3.0, 0.0)]), 0.1), parts=False)
        scene = problem.scene.add(
            "held", ball_parts(cloud) if parts else cloud, frame="tool", touch_links=problem.scene.robot.links
        )
        track = to.Track.constant_velocity(to.placement((0.9, 0.0, 0.9)), (0.05, 0.0, 0.0))
        scene = scene.add("seen", ball_parts(cloud) if parts else cloud, motion=track)
        asked = to.Problem(scene=scene, start=problem.start_positions, goal=problem.goal)
        statuses.append(clearance(to.judge(asked, straight(problem))).holds)
    assert statuses[0] == statuses[1]
