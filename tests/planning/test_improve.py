"""A shorter motion than the fastest along its path: both durations are told."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.methods import method_named
from trajopt.timing.time_scaling import travel_time
from trajopt.values.errors import ProblemError


def test_both_durations_are_reported() -> None:
    asked = to.named_problem("past_pillar_xarm7")
    along, found = to.plan(asked), to.plan(asked, improve=True)
    assert along.along_path is None and along.trajectory is not None
    plan = found.require()
    assert found.along_path == plan.along_path == pytest.approx(along.trajectory.duration)
    assert plan.trajectory.duration < 0.99 * along.trajectory.duration
    said = f"from {along.trajectory.duration:.3f} s along the path, by "
    assert said in str(found) and said in str(plan)
    assert found.method == "free-duration" and "was asked for" in found.because
    told = found.as_dict()
    assert told["along_path"] == found.along_path and told["duration"] == plan.trajectory.duration
    assert told["method"] == {"name": found.method, "because": found.because}


def test_where_the_line_is_best_nothing_shorter_is_found() -> None:
    asked = to.named_problem("planar_fold")
    start = dict(zip(asked.reduced.joint_names, asked.reduced.start_positions.tolist(), strict=True))
    first = asked.reduced.joint_names[0]
    near = to.joint_positions({**start, first: start[first] + 0.2})
    found = to.plan(replace(asked, goal=near, constraints=()), improve=True)
    assert found.verified and found.trajectory is not None and found.along_path is not None
    assert found.trajectory.duration == pytest.approx(found.along_path, rel=0.01)
    if found.trajectory.duration >= found.along_path:
        assert "nothing shorter than" in str(found)


def test_waypoints_are_passed_at_speed() -> None:
    """In a slight zigzag, and proven: sooner than along the path, and than with a rest at each."""
    scene = to.Scene(to.load("panda"))
    ready = scene.robot.state("ready", group="panda_arm")
    spots = [
        {**ready, "panda_joint1": 0.05 * number, "panda_joint4": ready["panda_joint4"] + 0.01 * (number % 2)}
        for number in range(1, 25)
    ]
    asked = to.Problem(scene=scene, group="panda_arm", start="ready", goal="ready", waypoints=spots)
    plan = to.plan(asked, improve=True).require()
    rows = np.array([asked.reduced.start_positions, *(list(each.values()) for each in spots)])
    resting = travel_time(rows, np.roll(rows, -1, axis=0), asked.limits, rests=True).sum()
    assert plan.along_path is not None
    assert plan.trajectory.duration < min(0.9 * plan.along_path, 0.7 * resting)
    passed = [plan.certificate.passing_time(str(number)) or 0.0 for number in range(1, 25)]
    for spot, time in zip(rows[1:], passed, strict=True):
        assert plan.trajectory(time) == pytest.approx(spot, abs=1e-4)


def test_improve_continues_from_any_path_over_knots() -> None:
    asked = to.named_problem("past_pillar_ur5")
    found = to.plan(asked, method="chomp", improve=True)
    assert found.verified and found.along_path is not None
    with pytest.raises(ProblemError, match="bspline"):
        to.plan(asked, method="bspline", improve=True)
    with pytest.raises(ProblemError, match="improve"):
        to.plan(asked, improve="yes")  # pyright: ignore[reportArgumentType]
    named = to.plan(asked, method=method_named("free-duration"), improve=True)
    assert named.along_path is not None and named.because == ""


def test_unsupported_constraints_are_refused_by_name() -> None:
    asked = replace(to.named_problem("past_pillar_ur5"), tool_speed=to.tool_speed("tool0", linear=0.2))
    found = to.plan(asked, improve=True)
    assert found.status is to.Status.METHOD_CANNOT
    assert "shorter motion" in found.message and "tool speeds" in found.message


def test_an_improving_budget_also_continues_from_splines() -> None:
    """Their paths have other numbers of knots than the problem."""
    asked = to.named_problem("past_pillar_xarm7")
    once, found = (
        to.plan(asked, improve=True, budget=to.Budget(attempts=attempts, improve=True)) for attempts in (1, 9)
    )
    assert found.require().trajectory.duration <= once.require().trajectory.duration
    assert len(found.attempts) == 9
