"""The program for CasADi: the same numbers as over knots, and derivatives that agree with differences."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.optimise.methods.casadi.nlpsol import CasadiProgram
from trajopt.optimise.methods.casadi.program import CasadiTranscription, by_stages, objection, plainly
from trajopt.optimise.terms import Cost, Jerk, Velocity, constraint, penalty, residual_from_function
from trajopt.optimise.terms.symbolic import SymbolicKinematics
from trajopt.optimise.transcription import KnotsNlp, transcribe
from trajopt.planning.seeds import straight_line
from trajopt.problem.residual import Residual
from trajopt.values.arrays import Floats

START = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
GOAL = {"pan": 1.0, "reach": 0.2, "elbow": 0.3, "wrist": 0.4}


def over_knots(folder: Path, *, costs: tuple[Cost, ...] | None = None) -> tuple[KnotsNlp, Floats]:
    scene = to.Scene(odd_arm(folder)).add("pillar", to.Cylinder(0.08, 1.0), to.placement((0.72, 0, 0.3)))
    asked = (
        to.axis_alignment("tip", axis=(1, 0, 0), direction=(0, 1, 0), tolerance=2.5),
        to.singularity_distance("tip", 1e-4),
        to.gravity_torque(0.9),
        constraint(
            residual_from_function("squares", lambda q: q**2, jacobian=lambda q: np.diag(2.0 * q)),
            lower=0.0,
            upper=9.0,
        ),
    )
    problem = to.Problem(
        scene=scene, start=START, goal=to.joint_positions(GOAL), constraints=asked, costs=costs, knots=9
    )
    seed = straight_line(problem.reduced.start_positions, np.array(list(GOAL.values())), problem.knots)
    seed[1:-1] += 0.05 * np.random.default_rng(1).normal(size=seed[1:-1].shape)
    return transcribe(problem, seed), seed


def evaluate(program: CasadiProgram, x: Floats) -> tuple[float, Floats]:
    cost, values = ca.Function("f", [program.x], [program.objective, program.functions]).call([x])
    return float(cost), values.full().ravel()


@pytest.mark.parametrize("write", [plainly, by_stages], ids=["plain", "staged"])
def test_the_numbers_are_those_of_the_program_over_knots(write, tmp_path: Path) -> None:
    nlp, knots = over_knots(tmp_path)
    at = nlp.linearise(knots, nlp.sampling(knots, fine=False))
    writing: CasadiTranscription = write(nlp, at.sampling)
    program = writing.program()
    x = writing.pack(program, knots)
    assert writing.unpack(x) == pytest.approx(knots)
    cost, values = evaluate(program, x)
    assert cost == pytest.approx(at.cost, abs=1e-12)
    outside = np.maximum(program.least - values, values - program.most)
    assert float(np.maximum(outside, 0.0).max()) == pytest.approx(
        max(block.worst for block in at.constraints), abs=1e-9
    )


@pytest.mark.parametrize("write", [plainly, by_stages], ids=["plain", "staged"])
def test_derivatives_agree_with_differences(write, tmp_path: Path) -> None:
    nlp, knots = over_knots(tmp_path)
    writing: CasadiTranscription = write(nlp, nlp.sampling(knots, fine=False))
    program = writing.program()
    x = writing.pack(program, knots)
    slopes = ca.Function("J", [program.x], [ca.jacobian(program.functions, program.x)])
    direction, step = np.random.default_rng(2).normal(size=len(x)), 1e-5
    direction[program.lower == program.upper] = 0.0
    (jacobian,) = slopes.call([x])
    numeric = (evaluate(program, x + step * direction)[1] - evaluate(program, x - step * direction)[1]) / (
        2.0 * step
    )
    predicted = jacobian.full() @ direction
    assert (np.abs(predicted - numeric) <= 3e-3 * (1.0 + np.abs(numeric))).all()


def test_measured_rows_depend_on_their_own_segment_only(tmp_path: Path) -> None:
    nlp, knots = over_knots(tmp_path)
    writing = by_stages(nlp, nlp.sampling(knots, fine=False))
    program = writing.program()
    pattern = ca.jacobian(program.functions, program.x).sparsity()
    width = 3 * 4
    stages = np.array(pattern.get_triplet()[1]) // width
    rows = np.array(pattern.row())
    for row in np.unique(rows):
        reached = np.unique(stages[rows == row])
        assert len(reached) <= 2 and np.ptp(reached) <= 1


def test_kinks_become_slacks_that_reach_the_same_cost(tmp_path: Path) -> None:
    wish = to.position_in_region("tip", [(to.Sphere(0.05), to.placement((0.3, 0.1, 0.5)))])
    nlp, knots = over_knots(tmp_path, costs=(Cost(Velocity()), Cost(Jerk()), penalty(wish, 0.5)))
    at = nlp.linearise(knots, nlp.sampling(knots, fine=False))
    writing = plainly(nlp, at.sampling)
    program = writing.program()
    x = writing.pack(program, knots)
    slacks = len(x) - writing.layout.x.shape[0]
    _, values = evaluate(program, x)
    rows = np.flatnonzero(~program.elastic & (program.least < program.most))
    assert slacks == len(rows)
    x[-slacks:] = np.maximum(values[rows], 0.0)
    assert evaluate(program, x)[0] == pytest.approx(at.cost, rel=1e-9)


def test_a_class_of_ones_own_is_objected_to(tmp_path: Path) -> None:
    class Mine:
        name = "mine"

    nlp, _ = over_knots(tmp_path)
    kinematics = SymbolicKinematics(nlp.query.reduced)
    residual: Residual = Mine()  # pyright: ignore[reportAssignmentType]
    assert "'mine'" in objection(residual, kinematics)
    assert not objection(Velocity(), kinematics)
