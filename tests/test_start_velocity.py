"""A start in motion: who takes it, what the judge makes of it, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from trajopt.errors import JointNotFound, ProblemError
from trajopt.methods import method_named
from trajopt.methods.free_duration import FreeDuration
from trajopt.planning.judgement import judge

JOINT = "shoulder_pan_joint"


def moving(speed: float) -> to.Problem:
    return replace(to.named_problem("past_pillar_ur5"), start_velocity={JOINT: speed})


@pytest.mark.parametrize("speed", [0.4, -0.3])
def test_a_motion_starts_as_fast_as_asked(speed: float) -> None:
    problem = moving(speed)
    plan = to.plan(problem, method=FreeDuration()).require()
    velocities = plan.trajectory(0.0, 1)
    wanted = [speed if name == JOINT else 0.0 for name in problem.reduced.joint_names]
    assert velocities == pytest.approx(np.array(wanted), abs=1e-9)
    assert plan.trajectory(0.0, 2) == pytest.approx(np.zeros(len(wanted)), abs=1e-6)
    assert any(check.name == "start velocity" and check.holds for check in plan.certificate.checks)


def test_the_judge_refuses_another_start() -> None:
    rest = to.plan(to.named_problem("past_pillar_ur5")).require().trajectory
    failed = [check.name for check in judge(moving(0.4), rest).failed]
    assert failed == ["start velocity"]


@pytest.mark.parametrize("method", ["sqp", "bspline", "ipopt"])
def test_methods_that_start_from_rest_say_so(method: str) -> None:
    result = to.plan(moving(0.4), method=method_named(method))
    assert result.status is to.Status.METHOD_CANNOT and "rest" in result.message


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ProblemError, match=r"its velocity limit is [0-9.]+ rad/s"):
        moving(1e3)
    with pytest.raises(JointNotFound, match=JOINT):
        replace(moving(0.1), start_velocity={"shoulder_pan_join": 0.1})
    assert f"{JOINT} at 22.92 deg/s" in str(moving(0.4))


def test_standing_still_is_a_motion_too() -> None:
    problem = to.named_problem("past_pillar_ur5")
    here = dict(zip(problem.reduced.joint_names, problem.reduced.start_positions.tolist(), strict=True))
    assert to.plan(replace(problem, goal=to.joint_positions(here)), method=FreeDuration()).verified
