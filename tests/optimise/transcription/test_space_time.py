"""The program in space and time: its derivatives, its limits, and what it keeps clear of when."""

from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.optimise.transcription.both_ways import GOAL, START, same
from tests.robots_for_tests import odd_arm
from trajopt.geometry import WorkCounts
from trajopt.optimise.methods.space_time import SpaceTime
from trajopt.optimise.nlp import Linearisation
from trajopt.optimise.solvers import Sqp
from trajopt.optimise.solvers.descent import DescentLimits
from trajopt.optimise.solvers.parts import PythonPart
from trajopt.optimise.solvers.sqp import native_descent
from trajopt.optimise.transcription.bspline import BsplineNlp
from trajopt.optimise.transcription.knots import SWEEP
from trajopt.optimise.transcription.space_time import ObstacleMargins, SpaceTimeNlp
from trajopt.optimise.transcription.spline_terms import ClearanceInTime
from trajopt.planning.seeds import straight_line
from trajopt.problem.motion import Motion
from trajopt.values.arrays import Floats, Rows
from trajopt.values.errors import ProblemError

SMALL = 1e-6


def crossed(folder: Path, **changes: object) -> to.Problem:
    """Return an arm's problem with a ball that crosses its way, turning, known to within an error."""
    robot = odd_arm(folder)
    effort = np.full(len(robot.joint_names), 60.0)
    robot = replace(robot, limits=replace(robot.limits, effort=effort))
    half_turn = to.placement((0.7, -0.5, 0.35), rpy=(0.0, 0.0, 1.5))
    track = to.Track.through([0.0, 1.5], [to.placement((0.55, 0.5, 0.3)), half_turn])
    scene = to.Scene(robot).add(
        "block", to.Box(0.2, 0.1, 0.3), motion=to.Prediction(track, error=(0.002, 0.004, 0.01))
    )
    scene = scene.add("flash", to.Sphere(0.1), to.placement((0.6, 0.0, 0.3)), appears=0.3, expires=0.8)
    return to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL), **changes)  # pyright: ignore[reportArgumentType]


def program(problem: to.Problem, duration: float) -> tuple[SpaceTimeNlp, Floats]:
    goal = np.array([GOAL[name] for name in problem.reduced.joint_names])
    seed = straight_line(problem.reduced.start_positions, goal, problem.knots)
    whole = SpaceTime().program(problem, seed)
    motion = to.Trajectory(problem.reduced.joint_names, np.linspace(0.0, duration, len(seed)), seed)
    family = whole.family(motion)
    control = motion(family.basis.averages * duration)
    shaken = control + 0.02 * np.random.default_rng(4).normal(size=control.shape)
    nlp = family.lasting(duration)
    return nlp, np.clip(shaken, nlp.lower, nlp.upper)


def every_row(at: Linearisation) -> list[tuple[str, Rows]]:
    return [(block.name, block.rows) for block in (*at.costs, *at.constraints)]


@pytest.mark.parametrize("moving", [False, True])
def test_derivatives_are_those_of_small_steps(tmp_path: Path, *, moving: bool) -> None:
    rates = {"start_velocity": {"pan": 0.5}, "start_acceleration": {"pan": -0.4}} if moving else {}
    nlp, x = program(crossed(tmp_path, **rates), 1.6)
    sampling = nlp.sampling(x, fine=True)
    rows = dict(every_row(nlp.linearise(x, sampling)))
    wanted = {"clearance in time", "velocity limit", "acceleration limit", "torque limit"}
    assert wanted <= {name for name, block in rows.items() if len(block.value)}
    rng = np.random.default_rng(1)
    for _ in range(3):
        step = np.where(nlp.lower < nlp.upper, rng.normal(size=x.shape), 0.0)
        after, before = (
            dict(every_row(nlp.linearise(x + side * SMALL * step, sampling))) for side in (1, -1)
        )
        for name, block in rows.items():
            slope = np.einsum("mkn,mkn->m", block.jacobian, step[block.knots])
            assert after[name].value.shape == before[name].value.shape == slope.shape, name
            measured = (after[name].value - before[name].value) / (2.0 * SMALL)
            np.testing.assert_allclose(measured, slope, atol=2e-4 * max(1.0, np.abs(slope).max(initial=0.0)))


def test_native_core_and_python_agree(tmp_path: Path) -> None:
    nlp, x = program(crossed(tmp_path), 1.6)
    sampling = nlp.sampling(x, fine=True)
    run = native_descent("auto", nlp, sampling, DescentLimits(5, 0.0, 0.0), None, Sqp().trust_region, 5.0)
    assert run is not None
    assert not any(isinstance(part, PythonPart) for part in run.program.constraints)
    before = replace(nlp.counts)
    run.begin(x, sampling)
    mine, core = run.linearised(), nlp.counts.since(before)
    theirs = nlp.linearise(x, sampling)
    assert core.distances > 0
    assert nlp.counts.since(before).forward_kinematics == 2 * core.forward_kinematics
    names = [name for name, _ in every_row(mine)]
    assert names == [name for name, _ in every_row(theirs)]
    assert {"clearance in time", "torque limit"} <= set(names)
    for (name, one), (_, other) in zip(every_row(mine), every_row(theirs), strict=True):
        assert len(one.value) == len(other.value), name
        first, second = (np.lexsort((rows.value, rows.component, rows.place)) for rows in (one, other))
        for field in ("value", "jacobian", "knots", "component", "place"):
            same({field: getattr(one, field)[first]}, {field: getattr(other, field)[second]})


def test_the_start_has_its_rates_for_any_duration(tmp_path: Path) -> None:
    problem = crossed(tmp_path, start_velocity={"pan": 0.5}, start_acceleration={"reach": -0.05})
    for duration in (0.9, 2.3):
        nlp, x = program(problem, duration)
        motion = nlp.trajectory(x)
        assert motion.duration == duration
        assert motion(0.0, 1) == pytest.approx(problem.start_velocities, abs=1e-9)
        assert motion(0.0, 2) == pytest.approx(problem.start_accelerations, abs=1e-8)
        assert motion(duration, 1) == pytest.approx(np.zeros(len(problem.start_velocities)), abs=1e-9)


def test_rows_within_their_bounds_hold_the_limits_at_all_times(tmp_path: Path) -> None:
    problem = crossed(tmp_path)
    nlp, x = program(problem, 4.0)
    at = nlp.linearise(x, nlp.sampling(x, fine=False))
    motion = nlp.trajectory(x)
    times = np.linspace(0.0, motion.duration, 3000)
    limits = (problem.limits.velocity, problem.limits.acceleration)
    for order, (name, limit) in enumerate(
        zip(("velocity limit", "acceleration limit"), limits, strict=True), 1
    ):
        (block,) = (item for item in at.constraints if item.name == name)
        most = np.abs(motion(times, order) / limit).max()
        assert most <= np.abs(block.rows.value).max() + 1e-9


def test_absent_obstacles_have_no_rows(tmp_path: Path) -> None:
    nlp, x = program(crossed(tmp_path), 1.6)
    motion = nlp.motion(x, nlp.sampling(x, fine=True))
    assert {0.3, 0.8} <= {round(time, 9) for time in motion.times.tolist()}
    (block,) = (
        item
        for item in nlp.linearise(x, nlp.sampling(x, fine=True)).constraints
        if item.kind is ClearanceInTime
    )
    assert nlp.obstacles is not None
    model = nlp.obstacles.rows.timed.reduced
    flashes = {pair for pair in block.rows.component.tolist() if "flash" in model.owners(pair)}
    assert flashes
    within = motion.where((motion.times >= 0.3) & (motion.times <= 0.8))
    assert len(within.times) < len(motion.times)
    places = block.rows.place[np.isin(block.rows.component, list(flashes))]
    assert within.place.min() - 1e-9 <= places.min() <= places.max() <= within.place.max() + 1e-9


def test_it_is_found_when_there_is_time_to_stay(tmp_path: Path) -> None:
    asked = crossed(tmp_path)
    scene = asked.scene.remove("block").remove("flash")
    hand = scene.robot.links[-1]
    place = scene.placement_of(hand, scene.robot.positions(GOAL)).translation
    for name, appears, expires in (("first", 0.0, 0.6), ("second", 0.9, 1.5)):
        scene = scene.add(name, to.Sphere(0.05), to.placement(place), appears=appears, expires=expires)
    margins = ObstacleMargins.of(replace(asked, scene=scene), WorkCounts())
    assert margins is not None
    goal = np.array([GOAL[name] for name in asked.reduced.joint_names])

    def first(begin: float, until: float, dwell: float) -> float:
        return margins.first_clear(goal, begin, until, dwell)

    assert first(0.1, inf, 0.0) == pytest.approx(0.61, abs=0.02)
    assert first(0.7, inf, 0.0) == 0.7
    assert first(0.1, inf, 0.5) == pytest.approx(1.51, abs=0.02), "between the two there is no time"
    assert first(0.1, 0.5, 0.0) == inf


def test_samples_are_dense_near_dynamic_obstacles(tmp_path: Path) -> None:
    nlp, x = program(crossed(tmp_path), 1.6)
    margins = nlp.obstacles
    assert margins is not None
    sampling = nlp.sampling(x, fine=True)
    corners = nlp.basis.at(nlp.basis.breaks)(x)
    times = nlp.basis.breaks * nlp.duration
    robot = nlp.query.displacement(corners[:-1], corners[1:])
    rest = np.repeat(corners[:1], len(times), axis=0)
    way = robot + margins.checks.moved(rest, times)
    alone = BsplineNlp.sampling(nlp, x, fine=True)
    dense = sampling >= way / (SWEEP / 2.0)
    assert (sampling >= alone).all()
    assert not dense.all() and (sampling[~dense] == alone[~dense]).all()
    # No pair is near its room anywhere in the other pieces: looked at a hundred times in each.
    for piece in np.flatnonzero(~dense).tolist():
        inside = np.linspace(nlp.basis.breaks[piece], nlp.basis.breaks[piece + 1], 100)
        spare = margins.spare(nlp.basis.at(inside)(x), inside * nlp.duration)
        assert (spare[margins.checks.pairs.changes] >= margins.margin[margins.checks.pairs.changes]).all()


def test_a_motion_without_times_is_refused(tmp_path: Path) -> None:
    nlp, x = program(crossed(tmp_path), 1.6)
    (item,) = (item for item in nlp.constraints if isinstance(item.residual, ClearanceInTime))
    with pytest.raises(ProblemError, match="no times"):
        item.residual.linearise(Motion.each(x, nlp.query))
