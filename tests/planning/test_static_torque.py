"""Loads that the joints can hold in some postures only: carried around the others, refused at the ends."""

from dataclasses import replace

import numpy as np
import pytest
from trajopt_problems.heavy_payload import heavy_payload_panda

import trajopt as to
from trajopt.geometry import Query
from trajopt.optimise.methods import METHODS
from trajopt.optimise.terms.gravity_torque import HoldingTorque
from trajopt.optimise.transcription import transcribe
from trajopt.planning.infeasibility.reasons import ObstructionKind
from trajopt.problem.motion import Motion
from trajopt.values.arrays import Floats
from trajopt.why import Certainty
from trajopt.why.explain import candidates

JOINTS = tuple(f"panda_joint{number}" for number in range(1, 8))
ABOVE = (0.0, -0.9, 0.0, -0.3, 0.0, 1.8, 0.0)
FOLDED = (0.0, -0.28, 0.0, -2.89, 0.0, 1.8, 0.0)
STRETCHED = (0.0, 1.2, 0.0, -0.3, 0.0, 1.8, 0.0)
"""The load is too far out for the shoulder."""


def carrying(mass: float = 4.0, *, shoulder: float = 87.0, scaling: float = 1.0) -> to.Scene:
    """A Panda with a load in the hand, an effort limit of its second joint [Nm], and a factor on all."""
    robot = to.load("panda")
    robot = robot.with_torque_scaling(shoulder / 87.0, joints=["panda_joint2"]).with_torque_scaling(scaling)
    scene = to.Scene(robot)
    where = to.placement((0.0, 0.0, 0.15))
    return scene.add("load", to.Sphere(0.02), where, frame="panda_hand", mass=mass)


def moving(
    start: tuple[float, ...],
    goal: to.Requirement | tuple[float, ...],
    scene: to.Scene | None = None,
    **more: object,
) -> to.Problem:
    asked = goal if isinstance(goal, to.Requirement) else at(goal)
    begin = dict(zip(JOINTS, start, strict=True))
    scene = scene or carrying()
    return to.Problem(scene=scene, group="panda_arm", start=begin, goal=asked, **more)  # pyright: ignore


def at(positions: tuple[float, ...], tolerance: float = 0.0) -> to.Requirement:
    return to.joint_positions(dict(zip(JOINTS, positions, strict=True)), tolerance=tolerance)


def line(start: tuple[float, ...], goal: tuple[float, ...]) -> Floats:
    return np.linspace(np.array(start), np.array(goal), 24)


def shares(problem: to.Problem, positions: Floats) -> Floats:
    """What holding still takes of each limit, (S, n), by the dynamics that retiming uses."""
    still = np.zeros_like(positions)
    torque = Query(problem.reduced).dynamics.torque(positions, still, still)
    return np.abs(torque) / problem.limits.effort


def rows_of(problem: to.Problem) -> list[HoldingTorque]:
    nlp = transcribe(problem, line(ABOVE, FOLDED))
    return [item.residual for item in nlp.constraints if isinstance(item.residual, HoldingTorque)]


@pytest.mark.parametrize("method", sorted(set(METHODS) - {"chomp", "stomp"}))
def test_the_path_bends_around_postures_that_cannot_be_held(method: str) -> None:
    problem = moving(ABOVE, FOLDED)
    assert shares(problem, line(ABOVE, FOLDED)).max() > 1.05, "the straight line drops the load"
    plan = to.plan(problem, method=method, budget=to.Budget(attempts=3)).require()
    times = np.linspace(0.0, plan.trajectory.duration, 400)
    assert shares(problem, plan.trajectory(times)).max() < 0.92
    assert plan.certificate.verified


@pytest.mark.parametrize("method", ["chomp", "stomp"])
def test_methods_without_second_order_hold_the_load_too(method: str) -> None:
    problem = moving(ABOVE, FOLDED)
    plan = to.plan(problem, method=method, budget=to.Budget(attempts=3)).require()
    times = np.linspace(0.0, plan.trajectory.duration, 400)
    assert shares(problem, plan.trajectory(times)).max() < 1.0


@pytest.mark.parametrize(
    ("which", "status"), [("start", "START_CANNOT_BE_HELD"), ("goal", "GOAL_CANNOT_BE_HELD")]
)
def test_refuses_a_goal_that_cannot_be_held_before_planning(which: str, status: str) -> None:
    """By joint and by how much, proven, before any seed is tried."""
    problem = moving(*((ABOVE, STRETCHED) if which == "goal" else (STRETCHED, ABOVE)))
    found = to.plan(problem)
    assert (found.status.name, found.certainty, found.attempts) == (status, Certainty.PROVEN, ())
    need = float(shares(problem, np.array([STRETCHED]))[0, 1]) * 87.0
    words = f"panda_joint2 needs {need:.4g} Nm only to hold still at the {which}, its effort limit is 87 Nm"
    assert words in found.reason


def test_the_explanation_lists_remedies_with_their_prices() -> None:
    told = to.plan(moving(ABOVE, STRETCHED)).explain(plan_again=True)
    assert told.certainty is Certainty.PROVEN
    assert [block.kind for block in told.blocks] == [ObstructionKind.EFFORT]
    assert told.nearest_free is not None and "The nearest that can be held" in str(told)
    assert told.remedies is not None
    assert [remedy.what for remedy in told.remedies] == [
        "goal",
        "mass of load",
        "effort limit of panda_joint2",
    ]
    assert all(remedy.result.verified and not remedy.half.verified for remedy in told.remedies)
    strong = told.remedies[2]
    assert strong.amount == pytest.approx(2.04, rel=0.2), "what is missing, and hardly more"


def test_a_goal_is_refused_as_proven_only_if_all_of_it_is() -> None:
    narrow = to.plan(moving(ABOVE, at(STRETCHED, 1e-3)))
    assert narrow.status is to.Status.GOAL_CANNOT_BE_HELD and narrow.certainty is Certainty.PROVEN
    wide = to.plan(moving(ABOVE, at(STRETCHED, 0.3)))
    assert wide.verified, "some of it can be held"
    between = to.plan(moving(ABOVE, at(STRETCHED, 0.02)))
    assert between.status is to.Status.GOAL_CANNOT_BE_HELD and between.certainty is Certainty.EVIDENCE


def reaching(positions: tuple[float, ...], turned: float = np.inf) -> to.Requirement:
    """The hand where it is at a configuration, turned as one likes."""
    problem = moving(ABOVE, FOLDED)
    where = problem.scene.placement_of("panda_hand", problem.reduced.all_positions(np.array(positions)))
    return to.frame_placement("panda_hand", where, rotation_tolerance=turned)


def test_branches_that_cannot_be_held_are_left_out() -> None:
    """A point that the arm reaches in many postures, most of them too heavy for the wrist."""
    problem = moving(ABOVE, reaching((0.0, 0.3, 0.0, -2.0, 0.0, 3.6, 0.0)), carrying(5.5))
    plan = to.plan(problem).require()
    assert shares(problem, plan.trajectory.positions[-1:]).max() < 1.0


def test_a_pose_of_which_no_branch_can_be_held_is_refused_as_such() -> None:
    found = to.plan(moving(ABOVE, reaching(STRETCHED, 0.01), carrying(shoulder=80.0)))
    assert (found.status, found.certainty) == (to.Status.GOAL_CANNOT_BE_HELD, Certainty.EVIDENCE)
    assert "can be held; in the one that needs least, panda_joint2 needs" in found.message
    told = found.explain(plan_again=True)
    assert any(block.kind is ObstructionKind.EFFORT for block in told.blocks)
    assert told.remedies


def test_waypoints_are_passed_where_they_can_be_held() -> None:
    stretched = moving(ABOVE, FOLDED, waypoints=[at(STRETCHED)])
    found = to.plan(stretched)
    assert found.status is to.Status.NO_WAYPOINT and "more torque only to hold still" in found.message
    heavy = moving(ABOVE, FOLDED, waypoints=[reaching((0.5, 0.2, 0.0, -1.2, 0.0, 1.6, 0.0))])
    plan = to.plan(heavy).require()
    assert shares(heavy, plan.trajectory.positions).max() < 1.0


def test_only_joints_that_may_be_too_weak_get_rows() -> None:
    (rows,) = rows_of(moving(ABOVE, FOLDED))
    assert np.isfinite(rows.listed).tolist() == [False, True, False, False, True, True, False]
    assert not rows_of(moving(ABOVE, FOLDED, carrying(0.5)))
    assert not rows_of(replace(moving(ABOVE, FOLDED), constraints=[to.gravity_torque(0.8)]))


@pytest.mark.parametrize(
    ("robot", "group"), [("panda", "panda_arm"), ("ur5", "manipulator"), ("xarm7", "xarm7")]
)
def test_unladen_arms_need_no_rows(robot: str, group: str) -> None:
    arm = to.load(robot)
    goal = to.joint_positions({arm.group(group).joints[0]: 0.5})
    problem = to.Problem(scene=to.Scene(arm), group=group, start={}, goal=goal)
    nlp = transcribe(problem, np.tile(problem.reduced.start_positions, (24, 1)))
    assert not any(isinstance(item.residual, HoldingTorque) for item in nlp.constraints)


def test_twice_the_torque_holds_the_load_anywhere() -> None:
    assert not rows_of(moving(ABOVE, FOLDED, carrying(scaling=2.0)))
    assert to.plan(moving(ABOVE, STRETCHED, carrying(scaling=2.0))).verified


def test_without_effort_limits_the_load_goes_straight() -> None:
    scene = carrying()
    off = scene.robot.with_torque_scaling(np.inf)
    problem = moving(ABOVE, STRETCHED, replace(scene, robot=off))
    assert not rows_of(problem)
    plan = to.plan(problem).require()
    assert shares(moving(ABOVE, FOLDED), plan.trajectory.positions).max() > 1.0


@pytest.mark.parametrize("share", [0.95, 0.999, 0.99999])
def test_where_little_torque_is_left_the_motion_is_slow(share: float) -> None:
    """From or to an end that takes nearly all of a limit: retiming takes its time, and does not fail."""
    end = (0.0, 0.9, 0.0, -0.6, 0.0, 1.8, 0.0)
    need = float(shares(moving(ABOVE, end), np.array([end]))[0, 1])
    scene = carrying(shoulder=87.0 * need / share)
    free = to.plan(moving(ABOVE, end, carrying(scaling=2.0))).require().trajectory.duration
    for start, goal in ((ABOVE, end), (end, ABOVE)):
        found = to.plan(moving(start, goal, scene))
        assert found.verified and len(found.attempts) == 1
        assert found.require().trajectory.duration > free


def test_an_end_without_torque_left_is_refused_before_the_search() -> None:
    end = (0.0, 0.9, 0.0, -0.6, 0.0, 1.8, 0.0)
    need = float(shares(moving(ABOVE, end), np.array([end]))[0, 1])
    found = to.plan(moving(ABOVE, end, carrying(shoulder=87.0 * need / (1.0 - 1e-8))))
    assert (found.status, found.certainty) == (to.Status.GOAL_CANNOT_BE_HELD, Certainty.EVIDENCE)


def test_a_way_that_no_path_can_hold_names_the_joint() -> None:
    """The wrist turns the load over, past the horizontal, where it is too heavy."""
    down, up = ((0.0, -0.6, 0.0, -1.0, 0.0, turned, 0.0) for turned in (0.5, 3.1))
    wrist = "panda_joint6"
    fixed = {name: value for name, value in zip(JOINTS, up, strict=True) if name != wrist}
    problem = moving(up, down, carrying(6.0), constraints=[to.joint_positions(fixed, tolerance=1e-3)])
    found = to.plan(problem, budget=to.Budget(attempts=2))
    assert found.status is to.Status.STUCK
    assert f"{wrist} needs" in found.message and "only to hold still, its effort limit is 12" in found.message
    told = found.explain()
    assert told.blocks[0].kind is ObstructionKind.EFFORT and told.blocks[0].place is not None
    assert {"mass of load", f"effort limit of {wrist}"} <= {change.what for change in candidates(told)}


def test_the_price_of_gravity_torque_is_reported() -> None:
    told = to.plan(moving(ABOVE, FOLDED)).explain(plan_again=True)
    (price,) = (item for item in told.prices if item.what == "effort limit of panda_joint6, to hold still")
    assert price.unit == "%" and price.objective is not None and price.objective > 0.0


def test_a_required_share_replaces_the_default() -> None:
    """The rows are the requirement's; what planning counts is as without rows of its own."""
    problem = heavy_payload_panda()
    seed = np.tile(problem.reduced.start_positions, (problem.knots, 1))
    held = [
        item for item in transcribe(problem, seed).constraints if isinstance(item.residual, HoldingTorque)
    ]
    assert not held


def test_rows_are_those_near_the_limit() -> None:
    problem = moving(ABOVE, FOLDED)
    (rows,) = rows_of(problem)
    positions = line(ABOVE, FOLDED)
    found = rows.linearise(Motion.each(positions, Query(problem.reduced)))
    share = shares(problem, positions)
    listed = np.nonzero(share >= rows.listed)
    assert found.place.tolist() == listed[0].tolist() and found.component.tolist() == listed[1].tolist()
    assert np.abs(found.value) == pytest.approx(share[listed], abs=1e-9)
