"""The program over control points: derivatives, hull and the way back to a path."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.nlp import Linearisation, Nlp
from trajopt.optimise.transcription import transcribe
from trajopt.optimise.transcription.bspline import (
    BsplineNlp,
    KnotPlaces,
    SplineBasis,
    fitted,
    over_control_points,
)
from trajopt.optimise.transcription.free_breaks import FreeBreaksNlp
from trajopt.optimise.transcription.free_duration import RESTING, FreeDurationNlp, least_duration
from trajopt.planning.seeds import straight_line
from trajopt.robot.joints import JointLimits
from trajopt.values.arrays import Floats

START = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
GOAL = {"pan": 1.0, "reach": 0.2, "elbow": 0.3, "wrist": 0.4}
ENDS = np.array((0.0, 1.0))


def problem(folder: Path) -> to.Problem:
    scene = to.Scene(odd_arm(folder)).add("pillar", to.Cylinder(0.08, 1.0), to.placement((0.72, 0, 0.3)))
    tilt = to.axis_alignment("tip", axis=(1, 0, 0), direction=(0, 1, 0), tolerance=2.5)
    return to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL), constraints=[tilt])


def spline(folder: Path, degree: int = 3, pieces: int = 8, resting: int = 1) -> tuple[BsplineNlp, Floats]:
    asked = problem(folder)
    seed = straight_line(asked.reduced.start_positions, np.array(list(GOAL.values())), asked.knots)
    basis = SplineBasis(degree, np.linspace(0.0, 1.0, pieces + 1))
    places = KnotPlaces(ENDS, (asked.knots - 1) * ENDS, np.empty(0))
    nlp = over_control_points(transcribe(asked, seed), basis, places, resting=resting)
    return nlp, fitted(basis, np.linspace(0.0, 1.0, asked.knots), seed, resting=resting)


def free(folder: Path) -> tuple[FreeDurationNlp, Floats]:
    nlp, control = spline(folder, pieces=10, resting=RESTING)
    model = nlp.problem.reduced
    timed = FreeDurationNlp(nlp, nlp.problem.limits, 2.0, DynamicsQuery(model), *np.zeros((2, 4)))
    return timed, np.hstack((control, np.full((len(control), 1), 0.9)))


def passing(folder: Path) -> tuple[FreeBreaksNlp, Floats]:
    """Two waypoints on the way, one of which leaves the joints a choice."""
    spot = to.joint_positions({"pan": -0.3, "reach": 0.15, "elbow": 0.1, "wrist": 0.3})
    asked = replace(problem(folder), waypoints=(spot, to.joint_positions({"pan": 0.4}, tolerance=0.02)))
    seed = straight_line(asked.reduced.start_positions, np.array(list(GOAL.values())), asked.knots)
    base = transcribe(asked, seed, (8, 15))
    return FreeBreaksNlp.through(base, seed, DynamicsQuery(asked.reduced), least=10)


def blocks(at: Linearisation) -> dict[str, Floats]:
    return {block.name: block.rows.value for block in (*at.costs, *at.constraints)}


def check_derivatives(nlp: Nlp, x: Floats) -> None:
    """Compare directional derivatives of every block whose rows are the same at both sides."""
    rng = np.random.default_rng(5)
    sampling = nlp.sampling(x, fine=False)
    at = nlp.linearise(x, sampling)
    direction, step = rng.normal(size=x.shape), 1e-5
    high = blocks(nlp.linearise(x + step * direction, sampling))
    low = blocks(nlp.linearise(x - step * direction, sampling))
    compared = 0
    for block in (*at.costs, *at.constraints):
        if len(high[block.name]) == len(low[block.name]) == len(block.rows.value) and len(block.rows.value):
            numeric = (high[block.name] - low[block.name]) / (2.0 * step)
            predicted = np.einsum("mkn,mkn->m", block.rows.jacobian, direction[block.rows.knots])
            # Distances are exact to 1e-6 only.
            loose = 3e-3 if block.name == "clearance" else 2e-4
            assert predicted == pytest.approx(numeric, rel=loose, abs=loose), block.name
            compared += 1
    assert compared >= 4


@pytest.mark.parametrize("degree", [3, 5])
def test_derivatives_over_control_points(degree: int, tmp_path: Path) -> None:
    nlp, control = spline(tmp_path, degree)
    check_derivatives(nlp, control + 0.02 * np.random.default_rng(1).normal(size=control.shape))


def test_derivatives_with_free_duration(tmp_path: Path) -> None:
    nlp, x = free(tmp_path)
    check_derivatives(nlp, x + 0.01 * np.random.default_rng(2).normal(size=x.shape))


def test_derivatives_with_free_breaks(tmp_path: Path) -> None:
    nlp, x = passing(tmp_path)
    check_derivatives(nlp, x + 0.01 * np.random.default_rng(2).normal(size=x.shape))


def test_bounds_of_control_points_bound_the_path(tmp_path: Path) -> None:
    nlp, _ = spline(tmp_path)
    rng = np.random.default_rng(3)
    lower, upper = np.maximum(nlp.lower, -5.0), np.minimum(nlp.upper, 5.0)
    path = nlp.decode(rng.uniform(lower, upper)).knots
    limits = nlp.problem.limits
    assert (path >= limits.lower - 1e-12).all() and (path <= limits.upper + 1e-12).all()
    assert path[0] == pytest.approx(np.array(list(START.values())))


def test_the_stated_duration_is_the_least_that_holds_the_limits(tmp_path: Path) -> None:
    nlp, x = free(tmp_path)
    x = x + 0.02 * np.random.default_rng(4).normal(size=x.shape)
    x[:RESTING, :-1], x[-RESTING:, :-1] = x[0, :-1], x[-1, :-1]
    motion = nlp.decode(x)
    limits = nlp.limits
    times = np.linspace(0.0, motion.duration, 4001)
    shares = [
        np.abs(motion(times, order)).max(axis=0) / limit
        for order, limit in ((1, limits.velocity), (2, limits.acceleration), (3, limits.jerk))
    ]
    torque = np.abs(DynamicsQuery(nlp.spline.problem.reduced).torque(*(motion(times, r) for r in range(3))))
    shares.append(torque.max(axis=0) / limits.effort)
    assert max(float(share.max()) for share in shares) == pytest.approx(1.0, abs=5e-3)
    for order in (1, 2):
        assert motion(ENDS * motion.duration, order) == pytest.approx(np.zeros((2, 4)), abs=1e-9)
    inner = motion.positions[1:-1]
    assert nlp.spline.basis.at(nlp.spline.basis.breaks[1:-1])(x[:, :-1]) == pytest.approx(inner)


def test_least_duration_of_one_joint_matches_its_polynomial() -> None:
    """q = 3 s^2 - 2 s^3: fastest in the middle, 1.5 / T; |q''| = 6 / T^2 at the ends, |q'''| = 12 / T^3."""

    def limits(velocity: float, acceleration: float, jerk: float) -> JointLimits:
        one = np.ones(1)
        return JointLimits(
            ("j",), -9 * one, 9 * one, velocity * one, acceleration * one, jerk * one, np.inf * one
        )

    breaks, speed, bend = np.array((0.0, 1.0)), np.zeros((2, 1)), np.array(((6.0,), (-6.0,)))
    far = 1e9
    assert least_duration(breaks, speed, bend, limits(0.5, far, far)) == pytest.approx(3.0)
    assert least_duration(breaks, speed, bend, limits(far, 1.5, far)) == pytest.approx(2.0)
    assert least_duration(breaks, speed, bend, limits(far, far, 12.0 / 64.0)) == pytest.approx(4.0)
