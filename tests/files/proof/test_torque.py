"""The rule of torque encloses Pinocchio's inverse dynamics between the times of the grid, and is tight."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.files.proof.conftest import Checker, Document, Proof, planar_problem
from tests.files.proof.dense import curve, of_kind, torques
from tests.files.proof.test_bounds import arm
from trajopt.files.proof import save_proof

Numbers = np.ndarray


def heavy_arm(seed: int, degree: int) -> tuple[Document, Document]:
    """A tree of joints, one that slides and one that mimics, with random masses: statement and rule."""
    rng = np.random.default_rng(seed)
    stated = arm(rng, degree)
    loads: list[Any] = []
    for joint in (1, 2, 3, 4, 5, 5):
        root = rng.uniform(-0.2, 0.2, (3, 3))
        inertia = root @ root.T
        loads.append(
            [
                joint,
                rng.uniform(0.0, 5.0),
                rng.uniform(-0.3, 0.3, 3).tolist(),
                inertia[np.triu_indices(3)].tolist(),
            ]
        )
    rule = {
        "kind": "torque",
        "gravity": rng.uniform(-9.0, 9.0, 3).tolist(),
        "loads": loads,
        "rotors": rng.uniform(0.0, 0.5, 5).tolist(),
        "limits": [[0, 1.0], [1, 1.0], [2, 1.0], [3, 1.0]],
    }
    return stated, rule


def with_limits(rule: Document, limits: Numbers) -> Document:
    return {**rule, "limits": [[place, float(limit)] for place, limit in enumerate(limits)]}


def holds(checker: Checker, stated: Document, rule: Document, grid: Numbers) -> Numbers:
    statement = checker.modules["statement"].read_statement(stated)
    found = checker.modules["kinematics"].GridKinematics(statement, grid)
    return checker.modules["rule_torque"].read(rule, statement).holds(found)


@given(seed=st.integers(0, 10**6), degree=st.sampled_from([3, 5]), cells=st.integers(3, 60))
@settings(max_examples=25, deadline=None)
def test_cells_contain_the_torques_and_their_derivatives(
    checker: Checker, seed: int, degree: int, cells: int
) -> None:
    stated, rule = heavy_arm(seed, degree)
    grid = np.unique(np.concatenate((stated["motion"]["times"], np.linspace(0.0, 2.0, cells))))
    statement = checker.modules["statement"].read_statement(stated)
    found = checker.modules["kinematics"].GridKinematics(statement, grid)
    loads = [(*row[:2], *map(np.array, row[2:])) for row in rule["loads"]]
    masses = np.array(rule["gravity"]), loads, np.array(rule["rotors"])
    positions = checker.modules["series"].taylor(*found.motion.bounds)
    wide = checker.modules["rule_torque"].torques(statement.joints, positions, masses, 1.0)
    for share in np.linspace(0.05, 0.95, 7):
        step = 1e-4 * np.diff(grid)
        around = [
            torques(stated, rule, grid[:-1] + share * np.diff(grid) + side * step) for side in (-1, 0, 1)
        ]
        first = (around[2] - around[0]) / (2.0 * step[:, None])
        second = (around[2] - 2.0 * around[1] + around[0]) / step[:, None] ** 2
        noise = 1e-12 * (1.0 + np.abs(around[1]))
        orders = (
            (around[1], noise),
            (first, noise / step[:, None]),
            (second / 2.0, noise / step[:, None] ** 2),
        )
        for order, (value, slack) in enumerate(orders):
            allowed = 10.0 * slack + 1e-5 * np.abs(value)
            low, high = (
                np.stack([getattr(each.terms[order], side) for each in wide], 1) for side in ("low", "high")
            )
            assert (low - allowed <= value).all() and (value <= high + allowed).all()


@pytest.mark.parametrize(("seed", "degree"), [(1, 3), (2, 5)])
def test_limits_just_above_the_torques_hold_and_below_do_not(
    checker: Checker, seed: int, degree: int
) -> None:
    stated, rule = heavy_arm(seed, degree)
    stated["ends"]["velocities"] = [1.0] * 4
    grid = np.unique(np.concatenate((stated["motion"]["times"], np.linspace(0.0, 2.0, 701))))
    times = np.sort(np.concatenate([grid[:-1] + share * np.diff(grid) for share in (1e-9, 0.5, 1.0 - 1e-9)]))
    largest = np.abs(torques(stated, rule, times)).max(axis=0)
    assert holds(checker, stated, with_limits(rule, 1.01 * largest), grid).all()
    for place in range(4):
        limits = 1.01 * largest
        limits[place] = largest[place] * (1.0 - 1e-9)
        assert not holds(checker, stated, with_limits(rule, limits), grid).all()


def pendulum(axis: list[float], rows: list[Any], duration: float) -> tuple[Document, Document]:
    """One kilogram at one metre from an axis, horizontal at position 0, and a fall of 9 m/s^2."""
    stated, rule = heavy_arm(0, 5)
    place = {"joint": 0, "rotation": [1, 0, 0, 0], "translation": [0, 0, 0]}
    stated["joints"] = [{**stated["joints"][0], "axis": axis, "offset": 0.0, "place": place}]
    stated["motion"] = {"coordinates": ["a"], "times": [0.0, duration], "values": rows}
    stated["ends"].update(positions=[0.0], velocities=[1.0], accelerations=[0.0])
    load = [1, 1.0, [1.0, 0.0, 0.0], [0.0] * 6]
    return stated, {**rule, "loads": [load], "rotors": [0.0], "gravity": [0.0, 0.0, -9.0]}


def test_a_limit_that_is_passed_between_samples_is_not_shown(checker: Checker) -> None:
    """The torque is 0 at both ends, and not between them."""
    rows = [[[0.0], [0.0]], [[1.0], [-1.0]], [[0.0], [0.0]]]
    stated, rule = pendulum([0.0, 0.0, 1.0], rows, 1.0)
    assert np.abs(torques(stated, rule, np.array([0.0, 1.0]))).max() < 1e-12
    assert np.abs(torques(stated, rule, np.array([0.5]))).max() > 1.0
    assert not holds(checker, stated, with_limits(rule, np.array([0.1])), np.array([0.0, 1.0])).any()
    assert holds(checker, stated, with_limits(rule, np.array([1e3])), np.array([0.0, 1.0])).all()


def test_an_arm_must_hold_itself_where_it_rests(checker: Checker) -> None:
    """A free fall needs no torque; to stay at its ends needs 9 Nm."""
    rows = [[[0.0], [0.045]], [[0.0], [0.9]], [[9.0], [9.0]]]
    stated, rule = pendulum([0.0, 1.0, 0.0], rows, 0.1)
    rule = with_limits(rule, np.array([1.0]))
    grid = np.linspace(0.0, 0.1, 5)
    for velocity, rests in ((1.0, False), (1.0, True), (0.0, False)):
        stated["ends"].update(velocities=[velocity], rests=rests)
        assert holds(checker, stated, rule, grid).tolist() == [velocity != 0.0, True, True, not rests]


def test_the_planar_arm_has_the_torques_of_lagrange(checker: Checker, planar: Proof) -> None:
    """Two links of which the second carries the tool; gravity is along both axes."""
    (rule,) = of_kind(planar.statement, "torque")
    knots = planar.statement["motion"]["times"]
    times = np.unique(np.concatenate((knots, np.linspace(0.0, knots[-1], 1000))))
    (_, q2), (v1, v2), (a1, a2) = (curve(planar.statement)(times, order).T for order in range(3))
    length, inner = 0.4, 0.02045 + 1.5 * 0.2**2
    outer = [(1.0, 0.2, 0.0136333333), (0.1, 0.45, 4.64583333e-05)]
    m11 = inner + sum(i + m * (length**2 + c**2 + 2.0 * length * c * np.cos(q2)) for m, c, i in outer)
    m12 = sum(i + m * (c**2 + length * c * np.cos(q2)) for m, c, i in outer)
    m22 = sum(i + m * c**2 for m, c, i in outer)
    h = sum(m * length * c * np.sin(q2) for m, c, _ in outer)
    expected = m11 * a1 + m12 * a2 - h * (2.0 * v1 * v2 + v2**2), m12 * a1 + m22 * a2 + h * v1**2
    assert np.allclose(torques(planar.statement, rule, times), np.stack(expected, 1), atol=1e-9)
    largest = np.abs(expected).max(axis=1)
    assert holds(checker, planar.statement, with_limits(rule, 1.01 * largest), times).all()
    for place in range(2):
        limits = 1.01 * largest
        limits[place] = 0.999 * largest[place]
        assert not holds(checker, planar.statement, with_limits(rule, limits), times).all()


def test_torque_that_cannot_be_shown_is_judged_only(
    tmp_path: Path, checker: Checker, planar: Proof, planar_plan: to.Plan
) -> None:
    """The limits are the largest torques of the judge's samples, so that nothing is left between them."""
    problem = planar_problem()
    robot, motion = problem.scene.robot, planar_plan.trajectory
    (rule,) = of_kind(planar.statement, "torque")
    spans = zip(motion.times[:-1], motion.times[1:], strict=True)
    samples = np.concatenate([np.linspace(begin, end, 4) for begin, end in spans])
    effort = np.abs(torques(planar.statement, rule, samples)).max(axis=0)
    weak = replace(robot, limits=replace(robot.limits, effort=effort))
    tight = replace(problem, scene=replace(problem.scene, robot=weak))
    save_proof(tight, motion, tmp_path / "x.proof")
    assert checker.fault(tmp_path / "x.proof") == ""
    statement = Proof.read(tmp_path / "x.proof").statement
    assert of_kind(statement, "torque") == []
    assert [each for each in statement["judged"] if each.startswith("torque: sampled at ")] != []
