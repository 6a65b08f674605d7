"""explain(): what it says of each way to end, and that what it says can be checked."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.why.conftest import GOAL, START, tip_at
from trajopt.planning.infeasibility.reasons import ObstructionKind
from trajopt.planning.result import Status
from trajopt.verify import Moment
from trajopt.why import Certainty, Explanation


def told(problem: to.Problem) -> Explanation:
    """Plan, explain, and check what every explanation must have."""
    result = to.plan(problem)
    found = result.explain()
    assert str(found).startswith(result.reason) and found.status is result.status
    assert json.loads(json.dumps(found.as_dict(), allow_nan=False))["reason"] == result.reason
    assert found.grounds
    if found.nearest_free is not None:
        assert to.examine(problem.reduced, found.nearest_free.positions, moment=Moment.BETWEEN).clear
    return found


def test_a_start_in_collision(pillar: to.Scene) -> None:
    start = {**START, "pan": 0.0}
    found = told(to.Problem(scene=pillar, start=start, goal=to.joint_positions(GOAL)))
    assert found.certainty is Certainty.PROVEN
    assert found.blocks[0].kind is ObstructionKind.CONTACT and "pillar" in found.blocks[0].subjects
    deepest = to.examine(found.problem.reduced, found.problem.reduced.start_positions).collisions[0]
    assert found.blocks[0].amount == pytest.approx(-deepest.distance)
    free = found.nearest_free
    assert free is not None and 0.0 < free.clearance and np.abs(free.moved).max() < 0.5
    assert "The nearest that is free" in str(found)


def test_the_nearest_free_configuration_is_near(arm: to.Robot) -> None:
    """One joint beyond its limit: nothing nearer than the limit is free, and nothing else has to move."""
    goal = {**GOAL, "elbow": 2.6}
    found = told(to.Problem(scene=to.Scene(arm), start=START, goal=to.joint_positions(goal)))
    assert found.status is Status.GOAL_OUT_OF_LIMITS
    assert found.nearest_free is not None
    assert found.nearest_free.moved == pytest.approx([0.0, 0.0, -0.1, 0.0], abs=2e-3)


def test_one_joint_of_the_goal_beyond_its_limit(arm: to.Robot) -> None:
    found = told(to.Problem(scene=to.Scene(arm), start=START, goal=to.joint_positions({"elbow": 2.6})))
    assert found.status is Status.GOAL_OUT_OF_LIMITS and found.certainty is Certainty.PROVEN
    assert found.blocks[0].subjects == ("elbow",) and found.blocks[0].amount == pytest.approx(0.1, abs=1e-3)


def test_out_of_reach(arm: to.Robot) -> None:
    goal = to.frame_placement("tip", to.placement((5.0, 0.0, 0.0)), rotation_tolerance=np.inf)
    found = told(to.Problem(scene=to.Scene(arm), start=START, goal=goal))
    assert found.status is Status.NO_INVERSE_KINEMATICS and found.certainty is Certainty.PROVEN
    assert "too short" in found.grounds
    assert any(block.subjects == ("reach",) for block in found.blocks), "stretched out to its limit"


def test_a_pose_that_no_posture_has_is_evidence_only(arm: to.Robot) -> None:
    where = to.Scene(arm).placement_of("tip", arm.positions(GOAL))
    turned = to.Placement(to.placement(rpy=(0.0, 0.0, np.pi)).rotation @ where.rotation, where.translation)
    found = told(to.Problem(scene=to.Scene(arm), start=START, goal=to.frame_placement("tip", turned)))
    assert found.status is Status.NO_INVERSE_KINEMATICS and found.certainty is Certainty.EVIDENCE


def test_requirements_that_exclude_each_other(arm: to.Robot) -> None:
    scene = to.Scene(arm)
    near = to.position_in_region(
        "tip", to.Sphere(0.1), to.placement(scene.placement_of("tip", arm.positions(START)).translation)
    )
    harmless = to.axis_alignment("tip", direction=(1, 0, 0), tolerance=3.0)
    goal = tip_at(scene, GOAL)
    found = told(to.Problem(scene=scene, start=START, goal=goal, constraints=[harmless, near]))
    assert found.status is Status.CONFLICTING_CONSTRAINTS and found.certainty is Certainty.PROVEN
    assert set(found.conflict) == {str(goal), str(near)}
    assert "No configuration meets all of these; any one fewer can be met:" in str(found)


def test_a_goal_that_only_one_obstacle_blocks(pillar: to.Scene) -> None:
    scene = pillar.add("far box", to.Box(0.1, 0.1, 0.1), to.placement((-2.0, 0.0, 0.0)))
    goal = tip_at(scene, {**GOAL, "pan": 0.0, "elbow": 0.2}, position_tolerance=1e-3)
    found = told(to.Problem(scene=scene, start=START, goal=goal))
    assert found.status is Status.GOAL_IN_COLLISION
    assert found.conflict == (str(goal), "clearance from pillar")
    assert found.nearest_free is not None and found.nearest_free.given > 1e-3


def test_obstructions_of_each_seed_are_counted(arm: to.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a proof that there is no way, many failures are evidence."""
    monkeypatch.setattr("trajopt.planning.search.closed_cut", lambda problem: None)
    sheet = to.Box(1.6, 0.02, 3.0)
    scene = to.Scene(arm).add("sheet", sheet, to.placement((0.95, 0.0, 0.0)))
    found = told(to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL)))
    assert found.status is Status.STUCK and found.certainty is Certainty.EVIDENCE
    assert len(found.attempts) > 20 and f"of {len(found.attempts)} seeds" in found.grounds
    optimised = [each for each in found.attempts if each.status is Status.STUCK]
    assert optimised and all(each.block is not None for each in optimised)
    assert found.configuration is not None and found.blocks[0].place is not None
    worst = to.examine(found.problem.reduced, found.configuration)
    assert worst.smallest is not None
    assert worst.smallest.distance < 0.01, "the margin is not held there"


def test_a_joint_too_weak_for_the_goal_is_proven(arm: to.Robot) -> None:
    elbow = np.array([0.02 if name == "elbow" else 1.0 for name in arm.joint_names])
    weak = replace(arm, limits=replace(arm.limits, effort=elbow * arm.limits.effort))
    found = told(to.Problem(scene=to.Scene(weak), start={"elbow": -1.6}, goal=to.joint_positions(GOAL)))
    assert found.status is Status.GOAL_CANNOT_BE_HELD and found.certainty is Certainty.PROVEN
    assert found.blocks[0].kind is ObstructionKind.EFFORT


def test_a_success_is_proven_and_has_prices(pillar: to.Scene) -> None:
    found = told(to.Problem(scene=pillar, start=START, goal=to.joint_positions(GOAL)))
    assert found.status is Status.SOLVED and found.certainty is Certainty.PROVEN
    assert any("pillar" in price.what and price.unit == "mm" for price in found.prices)


def test_a_goal_set_is_explained_by_its_first_goal(pillar: to.Scene) -> None:
    goals = to.any_of(
        {
            "inside": to.joint_positions({**GOAL, "pan": 0.0}),
            "beyond": to.joint_positions({**GOAL, "elbow": 2.6}),
        }
    )
    result = to.plan(to.Problem(scene=pillar, start=START, goal=goals))
    found = result.explain()
    assert str(found).startswith(result.reason)
    assert set(result.alternatives) == {"inside", "beyond"}
    assert "'inside'" in found.grounds and "pillar" in found.blocks[0].subjects


OVERLAPPING = (
    '<robot name="stump">'
    '<link name="base"><collision><geometry><box size="0.2 0.2 0.4"/></geometry></collision></link>'
    '<link name="arm"/>'
    '<link name="hand"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
    '<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>'
    '<limit lower="-3" upper="3" effort="9" velocity="2"/></joint>'
    '<joint name="nod" type="revolute"><parent link="arm"/><child link="hand"/><axis xyz="0 1 0"/>'
    '<limit lower="-3" upper="3" effort="9" velocity="2"/></joint></robot>'
)


def test_links_that_overlap_lead_to_the_assistant_of_srdf(tmp_path: Path) -> None:
    (tmp_path / "stump.urdf").write_text(OVERLAPPING)
    scene = to.Scene(to.load(tmp_path / "stump.urdf"))
    zero, one = ({"turn": angle, "nod": 0.0} for angle in (0.0, 1.0))
    (group,) = scene.robot.groups
    refused = to.plan(to.Problem(scene=scene, group=group, start=zero, goal=one))
    assert refused.status is to.Status.START_IN_COLLISION
    assert "`trajopt srdf` finds such pairs" in str(refused.explain())
