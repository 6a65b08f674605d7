"""The judge where a goal moves: a table that slides and turns meets a belt, by hand, and just does not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.problem.requirements import FramePlacement
from trajopt.scene.reducing import reduce_model
from trajopt.scene.track import Track
from trajopt.values.errors import ProblemError
from trajopt.verify import Judge, Specification
from trajopt.verify.certificate import Certificate, Check, Evidence

MEETING, DWELL = 1.0, 0.5
SPEED = 0.2
"""Of the belt along x [m/s]."""
TURNING = 0.4
"""Of what stands on it, about z [rad/s]."""
TABLE = """<robot name="table"><link name="base"/>
<link name="slide"><collision><geometry><box size="0.05 0.05 0.05"/></geometry></collision></link>
<link name="plate"><collision><geometry><box size="0.1 0.1 0.01"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="slide"/><axis xyz="1 0 0"/>
<limit lower="-2" upper="2" effort="100" velocity="2"/></joint>
<joint name="yaw" type="revolute"><parent link="slide"/><child link="plate"/><origin xyz="0 0 0.1"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="100" velocity="3"/></joint></robot>"""


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    path: Path = tmp_path_factory.mktemp("table") / "table.urdf"
    path.write_text(TABLE)
    return to.Robot.from_urdf(path)


def cell(table: to.Robot, *, speed: float = SPEED, turning: float = TURNING) -> to.Scene:
    """Return a scene in which a frame above the table slides past it and turns."""
    begin = to.placement((0.0, 0.0, 0.3))
    track = Track.constant_velocity(begin, (speed, 0.0, 0.0), angular_velocity=(0.0, 0.0, turning))
    # A mere frame, and a thing on it.
    scene = to.Scene(table).allow("slide", "plate").add("belt", [], motion=track)
    return scene.add("part", to.Box(0.02, 0.02, 0.02), to.placement((0.03, 0.0, 0.0)), frame="belt")


GOAL = to.frame_placement("plate", to.placement((-0.03, 0.0, -0.2)), reference="part")


def joined(
    table: to.Robot, *, speed: float = SPEED, turning: float = TURNING, late: float = 0.0, off: float = 0.0
) -> to.Trajectory:
    """Return the motion that begins at rest, meets the belt, and follows it."""
    ends = np.array((0.0, MEETING + late, MEETING + DWELL))
    x = np.array((0.0, speed * (MEETING + late) + off, speed * ends[2] + off))
    yaw = np.array((0.0, turning * (MEETING + late), turning * ends[2]))
    velocities = np.array(((0.0, 0.0), (speed, turning), (speed, turning)))
    reduced = reduce_model(to.Scene(table), "all", np.zeros(2))
    return to.Trajectory(reduced.joint_names, ends, np.stack((x, yaw), axis=1), velocities, np.zeros((3, 2)))


def judged(
    scene: to.Scene, motion: to.Trajectory, *, goal: FramePlacement = GOAL, dwell: float = DWELL
) -> Certificate:
    judge = Judge(reduce_model(scene, "all", np.zeros(2)))
    asked = Specification(goals=(goal,), dwell=dwell)
    certificate = judge.certify(motion, asked)
    assert judge.decide(motion, asked).verified == certificate.verified
    return certificate


def rest_checks(certificate: Certificate) -> list[Check]:
    return [check for check in certificate.checks if check.name == "goal: at rest relative to it"]


def test_a_motion_that_meets_the_belt_is_proven(table: to.Robot) -> None:
    certificate = judged(cell(table), joined(table))
    assert certificate.verified, certificate
    names = [check.name for check in certificate.checks]
    assert "end at rest" not in names and len(rest_checks(certificate)) == 4
    asked = [check for check in certificate.checks if check.name.startswith("goal")]
    assert all(check.evidence is Evidence.PROVEN for check in asked)


@pytest.mark.parametrize(
    ("world", "motion", "words"),
    [
        ({}, {"speed": SPEED + 2e-3, "off": -2e-3 * 1.25}, "goal: position"),
        ({}, {"off": 2e-4}, "goal: position"),
        ({}, {"late": 0.05}, "goal: at rest relative to it"),
        ({"speed": 1.1 * SPEED}, {}, "goal: position"),
        ({"turning": TURNING + 0.05}, {}, "goal: rotation"),
    ],
)
def test_a_motion_that_just_does_not_is_refused(
    table: to.Robot, world: dict[str, float], motion: dict[str, float], words: str
) -> None:
    certificate = judged(cell(table, **world), joined(table, **motion))
    assert not certificate.verified
    assert any(check.name == words for check in certificate.failed), certificate


@pytest.mark.parametrize(("slower", "holds"), [(0.9e-3, True), (1.1e-3, False)])
def test_the_velocity_at_the_meeting_is_bounded(table: to.Robot, slower: float, holds: bool) -> None:
    motion = joined(table, speed=SPEED - slower, off=slower * MEETING).between(0.0, MEETING)
    certificate = judged(cell(table), motion, dwell=0.0)
    assert certificate.verified is holds
    (check,) = (each for each in rest_checks(certificate) if each.unit == "m/s")
    assert check.value == pytest.approx(slower, rel=1e-6) and check.holds is holds


def test_the_rate_at_the_meeting_is_bounded_unless_it_is_free(table: to.Robot) -> None:
    motion = joined(table, turning=TURNING + 0.02).between(0.0, MEETING)
    scene = cell(table, turning=TURNING)
    turned = to.placement((-0.03, 0.0, -0.2), rpy=(0.0, 0.0, 0.02))
    strict = to.frame_placement("plate", turned, reference="part", position_tolerance=1e-3)
    certificate = judged(scene, motion, goal=strict, dwell=0.0)
    assert [check.unit for check in certificate.failed] == ["rad/s"]
    free = replace(strict, rotation_tolerance=np.array((1e-3, 1e-3, np.inf)))
    assert judged(scene, motion, goal=free, dwell=0.0).verified


def test_it_must_follow_for_the_requested_time(table: to.Robot) -> None:
    motion = joined(table)
    assert judged(cell(table), motion, dwell=0.4).verified
    assert not judged(cell(table), motion, dwell=0.7).verified
    (check,) = judged(cell(table), motion.between(1.0, 1.5), dwell=0.6).failed[-1:]
    assert check.detail == "the motion takes 0.500 s, but must follow its goal for 0.6 s"


def test_obstacles_while_following_are_checked(table: to.Robot) -> None:
    where = to.placement((SPEED * 1.3, 0.0, 0.1))
    for appears, holds in ((1.6, True), (1.3, False)):
        scene = cell(table).add("post", to.Box(0.05, 0.05, 0.2), where, appears=appears)
        assert judged(scene, joined(table)).verified is holds


def test_unsupported_moving_goals_are_refused_by_name(table: to.Robot) -> None:
    scene = cell(table)
    problem = to.Problem(scene=scene, start=np.zeros(2), goal=GOAL)
    with pytest.raises(ProblemError, match="by 'belt', which moves: a moving goal requires a start"):
        replace(problem, start_velocity={"x": 0.1})
    with pytest.raises(ProblemError, match="'belt' moves by itself: only goals may refer to frames"):
        to.Problem(
            scene=scene,
            start=np.zeros(2),
            goal={"x": 0.1},
            constraints=[to.frame_placement("plate", to.placement(), reference="belt")],
        )
    with pytest.raises(ProblemError, match="a goal on a dynamic obstacle must be a frame_placement"):
        upright = to.axis_alignment("plate", direction=(0, 0, 1), tolerance=0.1, reference="belt")
        to.Problem(scene=scene, start=np.zeros(2), goal=upright)
