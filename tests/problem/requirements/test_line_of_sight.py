"""Lines of sight past objects: term and judge against closed forms, and the judge between samples."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.problem.requirements.kind import Kind
from tests.verify.arms import joint, link, quintic, reduced, robot
from trajopt.geometry import Query
from trajopt.optimise.terms.line_of_sight import SightClearance
from trajopt.problem.motion import Motion, MotionInTime
from trajopt.problem.requirements import LineOfSight
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Rows
from trajopt.values.errors import FrameNotFound, ProblemError
from trajopt.verify import Check, Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion


@pytest.fixture
def model(tmp_path: Path) -> ReducedModel:
    """A camera that slides along x, a ball and a box on the way to what it looks at."""
    slide = robot(
        tmp_path, link("base"), link("eye"), joint("x", "base", "eye", kind="prismatic", axis="1 0 0")
    )
    scene = to.Scene(slide).add("ball", to.Sphere(0.1), to.placement((0.5, 0.0, 1.0)))
    scene = scene.add("box", to.Box(0.2, 0.2, 0.2), to.placement((3.0, 0.0, 1.0)))
    return reduced(scene.add("floor", to.Plane(), to.placement((0.0, 0.0, -1.0))), [-1.0])


def judged(model: ReducedModel, begin: float, end: float, margin: float, *ignore: str) -> tuple[Check, ...]:
    leg = quintic(model, [[begin], [end]], 1.0)
    motion = JudgedMotion(model, leg, kinematics=Kinematics(model), options=VerifyOptions())
    wanted = to.line_of_sight("eye", (0.0, 0.0, 2.0), margin=margin, ignore=ignore)
    return check_requirement(wanted, motion, When.ALWAYS)


def test_the_distance_of_a_ball_by_hand(model: ReducedModel) -> None:
    query = Query(model)
    for at in np.linspace(-0.4, 1.4, 19):
        way = np.array((-at, 0.0, 2.0)) / np.hypot(at, 2.0)
        centre = np.array((0.5 - at, 0.0, 1.0))
        expected = float(np.linalg.norm(np.cross(centre, way))) - 0.1
        need = to.line_of_sight("eye", (0.0, 0.0, 2.0), ignore=["box", "floor"])
        rows = SightClearance(model, need).linearise(Motion.single(np.array((at,)), query))
        if expected < 0.1:
            assert rows.value == pytest.approx([expected], abs=1e-6)
        else:
            assert len(rows.value) == 0


def test_occlusions_between_samples_are_detected(model: ReducedModel) -> None:
    """The line sweeps over the ball half way, and is clear at both ends."""
    (found,) = judged(model, -1.0, 3.0, 0.01, "box")
    assert not found.holds
    assert found.subject == "eye past ball"
    clear = judged(model, -1.0, 0.6, 0.01)
    assert len(clear) == 1
    assert clear[0].holds
    assert clear[0].evidence is Evidence.PROVEN
    nearest = float(
        np.linalg.norm(np.cross((-0.1, 0.0, 1.0), np.array((-0.6, 0.0, 2.0)) / np.hypot(0.6, 2.0)))
    )
    assert clear[0].value == pytest.approx(nearest - 0.1, abs=1e-6)
    for factor, holds in ((0.99, True), (1.01, False)):
        assert all(check.holds == holds for check in judged(model, -1.0, 0.6, factor * (nearest - 0.1)))
    assert judged(model, -1.0, 3.0, 0.01, "box", "ball")[0].subject == "eye past floor"


def test_a_plan_keeps_the_line_of_sight_past_a_post() -> None:
    panda = to.load("panda")
    start = {"panda_joint2": -0.785, "panda_joint4": -2.356, "panda_joint6": 1.571, "panda_joint7": 0.785}
    scene = to.Scene(panda).add("ball", to.Sphere(0.03), to.placement((0.42, 0.2, 0.25)))
    first = scene.placement_of("panda_hand_tcp", panda.positions(start)).translation
    sight = to.line_of_sight("panda_hand_tcp", (0.42, 0.2, 0.0), margin=0.02)
    goal = {"panda_joint1": 0.9, **start}
    problem = to.Problem(
        scene=scene, group="panda_arm", start=start, goal=to.joint_positions(goal), constraints=[sight]
    )
    assert first[2] > 0.3
    plan = to.plan(problem).require()
    (check,) = [check for check in plan.certificate.checks if check.name == "path: line of sight"]
    assert check.holds
    assert check.evidence is Evidence.PROVEN


START = {"panda_joint2": -0.785, "panda_joint4": -2.356, "panda_joint6": 1.571, "panda_joint7": 0.785}
TARGET = np.array((0.42, 0.2, 0.0))
ERROR = (0.003, 0.01, 0.0)
RADIUS = 0.02


@pytest.fixture(scope="module")
def crossing() -> to.Problem:
    """A ball flies through the line of sight at the goal, when the motion without it ends there."""
    panda = to.load("panda")
    scene, goal = to.Scene(panda), {"panda_joint1": 0.9, **START}
    eye = scene.placement_of("panda_hand_tcp", panda.positions(goal)).translation
    middle, way = (eye + TARGET) / 2.0, np.cross(eye - TARGET, (0.0, 0.0, 1.0))
    aside = 0.18 * way / np.linalg.norm(way)
    track = to.Track.through(
        [0.0, 1.2], [to.placement(tuple(middle - aside)), to.placement(tuple(middle + aside))]
    )
    scene = scene.add("ball", to.Sphere(RADIUS), motion=to.Prediction(track, error=ERROR))
    sight = to.line_of_sight("panda_hand_tcp", TARGET, margin=0.01)
    return to.Problem(scene=scene, group="panda_arm", start=START, goal=goal, constraints=[sight])


def distances(problem: to.Problem, motion: to.Trajectory, times: np.ndarray) -> np.ndarray:
    """Distance of the ball from the line of sight at times, less its error, by hand [m]."""
    scene, prediction = problem.scene, problem.scene.object("ball").timing.motion
    assert prediction is not None
    found: list[float] = []
    for time in times.tolist():
        positions = problem.reduced.all_positions(motion(time))
        eye = scene.placement_of("panda_hand_tcp", positions).translation
        ball, way = prediction.track.at(time).translation, TARGET - eye
        nearest = eye + np.clip((ball - eye) @ way / (way @ way), 0.0, 1.0) * way
        found.append(float(np.linalg.norm(ball - nearest)) - RADIUS - prediction.error_at(time))
    return np.array(found)


def sight_check(problem: to.Problem, motion: to.Trajectory) -> Check:
    (check,) = [check for check in to.judge(problem, motion).checks if check.name == "path: line of sight"]
    return check


def test_a_ball_that_crosses_the_line_is_avoided_in_time(crossing: to.Problem) -> None:
    alone = replace(crossing, scene=crossing.scene.remove("ball"))
    hasty = to.plan(alone).require().trajectory
    assert distances(crossing, hasty, np.linspace(0.0, hasty.duration, 2001)).min() < 0.0
    assert not sight_check(crossing, hasty).holds
    plan = to.plan(crossing).require()
    check = sight_check(crossing, plan.trajectory)
    assert check.holds and check.evidence is Evidence.PROVEN
    times = np.linspace(0.0, plan.trajectory.duration, 5001)
    assert distances(crossing, plan.trajectory, times).min() >= 0.01


def test_the_judge_subtracts_errors_from_proven_distances(crossing: to.Problem) -> None:
    """At rest where it starts: the least distance, with the largest error, is the bound that is proven."""
    here = crossing.start_positions[:7]
    still = to.Trajectory(crossing.reduced.joint_names, np.array((0.0, 1.0)), np.stack((here, here)))
    least = distances(crossing, still, np.linspace(0.0, 1.0, 5001)).min()
    for margin, holds in ((least - 0.02, True), (least + 0.001, False)):
        sight = to.line_of_sight("panda_hand_tcp", TARGET, margin=margin)
        check = sight_check(replace(crossing, constraints=[sight]), still)
        assert check.holds is holds
        assert check.value is not None and check.value <= least + 1e-6


def test_rows_of_samples_with_times_have_their_derivatives(crossing: to.Problem) -> None:
    reduced, query, times = crossing.reduced, Query(crossing.reduced), np.linspace(0.4, 0.7, 4)
    (sight,) = crossing.requirements
    assert isinstance(sight, LineOfSight)
    term = SightClearance(reduced, sight)
    goal = crossing.start_positions[:7] + np.array((0.88, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))

    def rows(positions: np.ndarray) -> Rows:
        each = Motion.each(positions, query)
        fields = (each.knots, each.support, each.weight, each.place, each.positions, each.query)
        return term.linearise(MotionInTime(*fields, times))

    here = np.tile(goal, (4, 1))
    found = rows(here)
    assert len(found.value) == 4 and len(term.linearise(Motion.each(here, query)).value) == 0
    still = to.Trajectory(reduced.joint_names, np.array((0.0, 1.0)), np.stack((goal, goal)))
    clear = found.value > 0.0
    assert clear.any()
    assert found.value[clear] == pytest.approx(distances(crossing, still, times)[clear], abs=1e-6)
    for column in range(7):
        step = np.zeros((4, 7))
        step[:, column] = 1e-6
        slope = (rows(here + step).value - rows(here - step).value) / 2e-6
        assert found.jacobian[:, 0, column] == pytest.approx(slope, abs=1e-4)


def problem_with(sight: LineOfSight, scene: to.Scene) -> to.Problem:
    goal = {"panda_joint1": 0.3}
    return to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal, constraints=[sight])


def test_objects_that_move_or_appear_are_ignored_on_request(crossing: to.Problem) -> None:
    scene = crossing.scene.add("tray", to.Box(0.05, 0.05, 0.02), to.placement((0.42, 0.1, 0.2)), appears=0.1)
    sight = to.line_of_sight("panda_hand_tcp", TARGET, ignore=["ball", "tray"])
    scene = scene.add("post", to.Box(0.02, 0.02, 0.02), to.placement((0.4, 0.4, 0.1)))
    plan = to.plan(problem_with(sight, scene)).require()
    (check,) = [check for check in plan.certificate.checks if check.name == "path: line of sight"]
    assert check.holds and check.subject == "panda_hand_tcp past post"


def test_unknown_objects_to_ignore_are_refused(crossing: to.Problem) -> None:
    sight = to.line_of_sight("panda_hand_tcp", TARGET, ignore=["bal"])
    with pytest.raises(FrameNotFound, match=r"'bal'.*ball"):
        problem_with(sight, crossing.scene)


def test_bad_input_is_refused(model: ReducedModel) -> None:
    with pytest.raises(ProblemError, match="margin"):
        to.line_of_sight("eye", (0, 0, 0), margin=0.0)
    with pytest.raises(ProblemError, match="ignore"):
        to.line_of_sight("eye", (0, 0, 0), ignore="ball")


KIND = Kind(
    requirement=LineOfSight,
    printed=[
        (
            to.line_of_sight("eye", (0.5, 0, 0.2)),
            "eye sees (0.5, 0, 0.2) m, its line of sight clear by 10 mm",
        )
    ],
    relaxed=[to.line_of_sight("tip", (1.0, 0.5, 0.2), margin=0.05)],
    residuals={
        SightClearance: [
            lambda at: SightClearance(
                at.reduced, to.line_of_sight("tip", (0.66, 0.2, 0.4), origin=(0, 0, 0.2), ignore=["held"])
            )
        ]
    },
    calls={
        "line_of_sight": {
            "frame": "panda_hand_tcp",
            "target": (0.1, 0.0, 0.2),
            "origin": (0.1, 0.0, 0.2),
            "ignore": ["box"],
            "margin": 0.1,
        }
    },
    measured=frozenset({SightClearance}),
)
