"""The problems of robots on wheels: base and arm together, around a column to a table out of reach."""

from collections.abc import Callable

import numpy as np
import pytest
from trajopt_problems.moving_bases import past_column_pr2, past_column_tiago

import trajopt as to
from trajopt.verify import CheckKind


@pytest.mark.slow
@pytest.mark.parametrize("make", [past_column_pr2, past_column_tiago])
@pytest.mark.parametrize("draw", [None, 0, 1, 2])
def test_base_and_arm_reach_the_table(make: Callable[..., to.Problem], draw: int | None) -> None:
    problem = make(None if draw is None else np.random.default_rng(draw))
    base = problem.scene.robot.base.joints
    assert problem.reduced.joint_names[:3] == base
    plan = to.plan(problem).require()
    assert plan.certificate.verified
    travelled = plan.trajectory.positions[-1, :2] - plan.trajectory.positions[0, :2]
    assert np.linalg.norm(travelled) > 1.0, "no arm reaches so far"
    rolling = [check for check in plan.certificate.checks if check.kind is CheckKind.ROLLING]
    assert len(rolling) == (1 if make is past_column_tiago else 0)
    run = to.simulate(plan)
    assert run.diverged is None and not run.collisions and run.tracking_error.maximum.max() < 0.02
