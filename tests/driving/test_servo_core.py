"""The native core of the servo beside its twin."""

import numpy as np
import pytest

import trajopt as to
from tests.oracles import servo as twin
from trajopt.driving.servo_program import (
    ApproachLimits,
    ApproachQuery,
    BodySpeeds,
    Braking,
    VelocityTask,
    settle,
)
from trajopt.driving.servo_task import Tool
from trajopt.geometry import Query
from trajopt.optimise.methods.timing import with_jerk
from trajopt.problem.problem import Problem
from trajopt.problem.requirements.joints import LENGTH
from trajopt.scene.reducing import tool_frame
from trajopt.values.arrays import Floats

PERIOD = 0.01


def around(name: str) -> Problem:
    scene = to.Scene(to.load(name)).add("box", to.Box(0.2, 0.2, 0.2), to.placement((0.6, 0.2, 0.3)))
    group = next(iter(scene.robot.groups))
    return Problem(scene=scene, group=group, start={}, goal={scene.robot.groups[group].joints[0]: 0.0})


def braking_of(problem: Problem) -> Braking:
    return Braking(with_jerk(problem.limits), PERIOD)


def state_of(braking: Braking, rng: np.random.Generator) -> Floats:
    """Return a state, up to and beyond the limits."""
    limits = braking.limits
    lower, upper = np.maximum(limits.lower, -4.0), np.minimum(limits.upper, 4.0)
    shares = rng.uniform(-1.1, 1.1, (3, len(lower)))
    middle, half = (lower + upper) / 2.0, (upper - lower) / 2.0
    return np.stack((middle + shares[0] * half, shares[1] * limits.velocity, shares[2] * limits.acceleration))


@pytest.mark.parametrize("name", ["panda", "ur5", "planar2"])
def test_bounds_and_the_state_after(name: str) -> None:
    braking, rng = braking_of(around(name)), np.random.default_rng(1)
    for _ in range(100):
        state = state_of(braking, rng)
        lower, upper = braking.bounds(state)
        assert np.array((lower, upper)) == pytest.approx(np.array(twin.bounds(braking, state)), abs=1e-12)
        inside = np.abs(state[2]) <= braking.limits.acceleration
        settled = rng.uniform(lower, upper)
        then = braking.after(state, settled)
        # The change of acceleration within the tick is one of constant jerk.
        half = (state[2] + then[2]) / 2.0
        assert then[1] == pytest.approx(state[1] + PERIOD * half, abs=1e-12)
        assert (np.abs(then[2]) <= braking.limits.acceleration).all()
        change = np.abs(then[2] - state[2])[inside]
        assert (change <= braking.limits.jerk[inside] * PERIOD * (1.0 + 1e-9)).all()
        rates = np.abs(state[1]) / braking.limits.acceleration
        assert braking.time(state[1]) == pytest.approx(rates.max() + braking.delay.max())


@pytest.mark.parametrize("name", ["panda", "ur5", "planar2"])
def test_speeds_of_bodies(name: str) -> None:
    problem, rng = around(name), np.random.default_rng(2)
    reduced = problem.reduced
    query, speeds, joints = Query(reduced), BodySpeeds(reduced), len(reduced.joint_names)
    for _ in range(20):
        placed = query.kinematics(rng.uniform(-2.0, 2.0, (1, joints)))
        lower, upper = np.sort(rng.uniform(-1.0, 1.0, (2, joints)), axis=0)
        found = speeds.nearer(placed, lower, upper)
        assert found == pytest.approx(twin.nearer(reduced, placed, lower, upper), abs=1e-12)


@pytest.mark.parametrize("name", ["panda", "ur5", "planar2"])
def test_slopes_of_singular_values(name: str) -> None:
    problem, rng = around(name), np.random.default_rng(3)
    reduced = problem.reduced
    query, frame, joints = Query(reduced), tool_frame(reduced), len(reduced.joint_names)
    for _ in range(20):
        tool = Tool.at(query, rng.uniform(-2.0, 2.0, joints), frame, joints)
        _, values, _, slopes = tool.singular_values()
        expected = twin.slopes(tool.linear, tool.angular, tool.mimic, LENGTH)
        assert values == pytest.approx(expected[0], abs=1e-12)
        if np.abs(np.diff(values)).min() > 1e-3:  # else the vectors are not unique
            assert slopes == pytest.approx(expected[1], abs=1e-9)


@pytest.mark.parametrize("name", ["panda", "ur5", "planar2"])
def test_no_other_velocities_follow_better(name: str) -> None:
    problem, rng = around(name), np.random.default_rng(4)
    braking, joints = braking_of(problem), len(problem.reduced.joint_names)
    near = ApproachQuery(problem.reduced, braking, 0.0)
    limits, compared = braking.limits, 0
    for _ in range(40):
        state = state_of(braking, rng) * 0.5
        lower, upper = braking.bounds(state)
        if (lower >= upper).any():
            continue
        task = VelocityTask(rng.normal(size=(min(joints, 6), joints)), rng.normal(size=min(joints, 6)))
        found = near.limits(state, 0.0, (lower, upper))
        rows = np.concatenate((found.jacobian, rng.normal(size=(2, joints))))
        approach = ApproachLimits(rows, np.concatenate((found.lower, (-0.2, -10.0 * limits.velocity.sum()))))
        settled = settle(task, approach, lower, upper, limits)
        assert settled is not None and (lower <= settled).all() and (settled <= upper).all()

        program = task.matrix, task.target, approach.jacobian, approach.lower, limits.velocity
        best = twin.value(*program, settled)
        for _ in range(30):
            other = rng.uniform(lower, upper)
            for share in (1.0, 1e-2, 1e-4):
                assert best <= twin.value(*program, settled + share * (other - settled)) + 1e-8
        compared += 1
    assert compared > 10
