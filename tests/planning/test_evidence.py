"""Refusals that rest on a search: it is thorough, and what it did not find is not called impossible."""

import numpy as np
import pytest
from trajopt_problems.arms import panda

import trajopt as to
from trajopt.why import Certainty


def hard_to_find(number: int) -> to.Problem:
    """A pose near joint limits, and joints coupled all the way: a configuration that holds both is known."""
    rng, arm = np.random.default_rng(number), panda()
    scene = to.Scene(arm.robot)
    reduced = to.Problem(
        scene=scene, group=arm.group, start=arm.ready, goal=arm.tip_at(np.zeros(3), 1.0)
    ).reduced
    lower, upper, start = reduced.limits.lower, reduced.limits.upper, reduced.start_positions
    inner = rng.uniform(lower, upper)
    pressed = rng.random(7) < 0.35
    known = np.where(pressed, np.where(rng.random(7) < 0.5, lower + 1e-3, upper - 1e-3), inner)
    chosen = rng.choice(7, int(rng.integers(2, 5)), replace=False)
    away, weights = (known - start)[chosen], rng.normal(size=len(chosen))
    weights -= away * (weights @ away) / (away @ away)
    weights /= np.abs(weights).max()
    coupled = to.coupled_joints(
        {reduced.joint_names[joint]: float(weight) for joint, weight in zip(chosen, weights, strict=True)},
        float(weights @ start[chosen]),
        tolerance=float(rng.choice([1e-4, 1e-3, 0.02])),
    )
    goal = to.frame_placement(arm.tip, scene.placement_of(arm.tip, reduced.all_positions(known)))
    return to.Problem(scene=scene, group=arm.group, start=arm.ready, goal=goal, constraints=[coupled])


@pytest.mark.parametrize("number", [76, 208, 209, 271])
def test_compatible_requirements_are_not_a_conflict(number: int) -> None:
    found = to.plan(hard_to_find(number), budget=to.Budget(attempts=1))
    assert found.status not in {to.Status.CONFLICTING_CONSTRAINTS, to.Status.NO_INVERSE_KINEMATICS}


def test_a_conflict_without_a_proof_reports_the_evidence() -> None:
    robot = to.load("planar2")
    names = robot.joint_names
    where = to.Scene(robot).placement_of("tool", robot.positions(dict(zip(names, (0.6, 0.8), strict=True))))
    goal = to.frame_placement("tool", where, rotation_tolerance=np.inf)
    coupled = to.coupled_joints(dict.fromkeys(names, 1.0), 0.0, tolerance=0.05)
    start = dict.fromkeys(names, 0.0)
    result = to.plan(to.Problem(scene=to.Scene(robot), start=start, goal=goal, constraints=[coupled]))
    assert result.status is to.Status.CONFLICTING_CONSTRAINTS and result.certainty is Certainty.EVIDENCE
    assert "no configuration was found that holds" in result.message
    told = result.explain()
    assert told.certainty is Certainty.EVIDENCE and len(told.conflict) == 2
    assert "exclude" not in str(told)


def test_all_that_reach_a_pose_and_collide_are_all_that_were_found() -> None:
    robot = to.load("planar2")
    start = dict.fromkeys(robot.joint_names, 0.0)
    known = robot.positions(dict(zip(robot.joint_names, (1.2, 0.8), strict=True)))
    where = to.Scene(robot).placement_of("tool", known)
    scene = to.Scene(robot).add("post", to.Cylinder(0.1, 1.0), where)
    goal = to.frame_placement("tool", where, rotation_tolerance=np.inf)
    result = to.plan(to.Problem(scene=scene, start=start, goal=goal))
    assert result.status is to.Status.GOAL_IN_COLLISION and result.certainty is Certainty.EVIDENCE
    assert "configurations found that reach the goal collide" in result.message
