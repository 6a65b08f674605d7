"""Lines of sight past objects: term and judge against closed forms, and the judge between samples."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.problem.requirements.kind import Kind
from tests.verify.arms import joint, link, quintic, reduced, robot
from trajopt.geometry import Query
from trajopt.optimise.terms.line_of_sight import SightClearance
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import LineOfSight
from trajopt.scene.reduced import ReducedModel
from trajopt.values.errors import ProblemError
from trajopt.verify import Check, Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import Motion as TimedMotion


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
    motion = TimedMotion(model, leg, kinematics=Kinematics(model), options=VerifyOptions())
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


def test_what_passes_between_samples_is_seen(model: ReducedModel) -> None:
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


def test_a_plan_looks_past_a_post() -> None:
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
