"""What a constraint is missed by is said in millimetres and degrees, wherever its unit is one."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.problem.requirements.kind import kinds
from tests.robots_for_tests import odd_arm
from trajopt.optimise.solvers import SolveResult, SolverStatus
from trajopt.optimise.transcription import transcribe
from trajopt.planning.infeasibility.reasons import blocks_on_the_way, stuck
from trajopt.problem.residual import units_of

NO_LENGTH_OR_ANGLE = {"JointSum", "GravityShare", "HoldingTorque", "SmallestSingularValue"}
"""Residuals of weighted sums, shares and products."""


def test_residuals_of_every_kind_declare_their_units() -> None:
    classes = [kind for each in kinds() for kind in each.residuals]
    assert len(classes) >= 10
    for residual in classes:
        units = getattr(residual, "units", None)
        assert units is not None or residual.__name__ in NO_LENGTH_OR_ANGLE, f"{residual.__name__}: units"
        assert set(units or ()) <= {"m", "rad"}, residual.__name__


@pytest.fixture
def scene(tmp_path: Path) -> to.Scene:
    return to.Scene(odd_arm(tmp_path))


def words(scene: to.Scene, goal: to.Requirement) -> str:
    """What is said of the first knots of a program, which hold nothing of the goal."""
    problem = to.Problem(scene=scene, start={}, goal=goal, knots=4)
    line = np.zeros((4, 4)) + problem.reduced.start_positions
    nlp = transcribe(problem, line)
    at = nlp.linearise(line, nlp.sampling(line, fine=False))
    result = SolveResult(SolverStatus.MAX_ITERATIONS, line, at, ())
    assert blocks_on_the_way(problem, result)[0].words in stuck(problem, result)
    return " ".join(block.words for block in blocks_on_the_way(problem, result))


def test_a_placement_is_missed_by_millimetres_or_degrees(scene: to.Scene) -> None:
    here = scene.placement_of("tip", scene.robot.positions({}))
    moved, turned = here * to.placement((0.03, 0, 0)), here * to.placement(rpy=(20, 0, 0), degrees=True)
    assert "placement of tip by 29.9 mm" in words(scene, to.frame_placement("tip", moved))
    assert "placement of tip by 19.9" in words(scene, to.frame_placement("tip", turned))


def test_joints_are_missed_by_their_unit(scene: to.Scene) -> None:
    assert "joint positions by 28.64 deg" in words(scene, to.joint_positions({"elbow": 0.5}))
    assert "joint positions by 49.9 mm" in words(scene, to.joint_positions({"reach": 0.05}))


def test_a_residual_without_units_has_an_empty_tuple() -> None:
    assert units_of(type("Mine", (), {"name": "mine"})()) == ()  # type: ignore[arg-type]
