"""Why there is no motion among things that move: what is in the way, when, and how that is known."""

import json

import numpy as np
import pytest
from trajopt.ros.commander.moveit_msgs.msg import MoveItErrorCodes

import trajopt as to
from trajopt.geometry import WorkCounts
from trajopt.planning.infeasibility.inevitable import InTime
from trajopt.planning.status import Certainty
from trajopt.server.move_group.outcome import code_of

FAST = to.Budget(attempts=1)
PLANE = 0.1
"""Height at which the planar arm moves [m]."""
AT_GOAL, AWAY = to.placement((0.0, 0.75, PLANE)), to.placement((0.0, 3.0, PLANE))


def problem(scene: to.Scene, *, goal: object = None, start: float = 0.0) -> to.Problem:
    wanted = to.joint_positions({"shoulder": 1.5, "elbow": 0.0}) if goal is None else goal
    return to.Problem(scene=scene, group="arm", start={"shoulder": start, "elbow": 0.0}, goal=wanted)


def along_y(speed: float, x: float = 0.75) -> to.Track:
    places = [to.placement((x, y, PLANE)) for y in (-1.0, 1.0)]
    return to.Track.through([0.0, 2.0 / speed], places)


def test_a_fast_obstacle_that_sweeps_the_start_is_inevitable(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.2), motion=along_y(8.0))
    result = to.plan(problem(scene), budget=FAST)
    assert result.status is to.Status.INEVITABLE and result.certainty is Certainty.PROVEN
    (block,) = result.blocks
    assert block.subjects[1] == "ball" and block.subjects[0] in planar_arm.links
    assert block.begin is not None and block.end is not None and 0.05 < block.begin <= block.end < 0.3
    assert f"at {block.end:.3f} s" in result.reason and "ball sweeps" in result.reason
    assert not result.attempts or len(result.attempts) < 3, "nothing else was tried"
    assert code_of(result).val == MoveItErrorCodes.START_STATE_IN_COLLISION


def test_the_infeasibility_proof_precedes_the_search(
    planar_arm: to.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    def tried(*_: object, **__: object) -> None:
        raise AssertionError("a motion was looked for")

    monkeypatch.setattr("trajopt.planning.moving.space_time_attempts.SpaceTimeAttempts.of", tried)
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.2), motion=along_y(8.0))
    result = to.plan(problem(scene), budget=FAST)
    assert result.status is to.Status.INEVITABLE and not result.verified
    # The motion without what changes is there to look at, with what is wrong with it.
    assert result.trajectory is not None and result.certificate is not None
    assert any("ball" in check.detail for check in result.certificate.failed)


def test_the_bound_is_stated(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("wall", to.Box(0.8, 0.4, 0.5), motion=along_y(20.0))
    result = to.plan(problem(scene), budget=FAST)
    assert result.status is to.Status.INEVITABLE and result.certainty is Certainty.PROVEN
    assert "within the limits no point of that gets farther than" in result.reason


def test_a_wall_faster_than_the_limits_closes_the_room(planar_arm: to.Robot) -> None:
    swept = to.Track.through([0.0, 1.0], [to.placement((0.0, y, PLANE)) for y in (-3.0, 3.0)])
    scene = to.Scene(planar_arm).add("wall", to.Box(4.0, 0.5, 1.0), motion=swept)
    result = to.plan(problem(scene, goal=to.joint_positions({"shoulder": 2.9, "elbow": 0.0})), budget=FAST)
    assert result.status is to.Status.INEVITABLE and result.certainty is Certainty.PROVEN
    assert "wall" in result.reason


def test_a_goal_occupied_at_all_times_names_the_occupier(planar_arm: to.Robot) -> None:
    comes = to.Track.through([0.0, 0.3], [AWAY, AT_GOAL])
    result = to.plan(problem(to.Scene(planar_arm).add("ball", to.Sphere(0.1), motion=comes)), budget=FAST)
    assert result.status is to.Status.GOAL_OCCUPIED and result.certainty is Certainty.PROVEN
    assert [block.subjects[1] for block in result.blocks] == ["ball"]
    assert result.blocks[0].end == np.inf and "ball" in result.reason
    assert code_of(result).val == MoveItErrorCodes.GOAL_IN_COLLISION
    data = json.loads(json.dumps(result.as_dict()))
    assert data["status"] == "GOAL_OCCUPIED" and data["blocks"][0]["end"] is None
    assert data["blocks"][0]["begin"] == result.blocks[0].begin and data["certainty"] == "PROVEN"


def test_a_goal_of_which_all_configurations_found_are_occupied_is_evidence(planar_arm: to.Robot) -> None:
    region = to.frame_placement("hand", to.placement((0.3, 0.6, PLANE)), rotation_tolerance=4.0)
    ball = to.Scene(planar_arm).add("ball", to.Sphere(0.15), to.placement((0.3, 0.6, PLANE)), appears=0.1)
    result = to.plan(problem(ball, goal=region), budget=FAST)
    assert result.status is to.Status.GOAL_OCCUPIED and result.certainty is Certainty.EVIDENCE
    assert "goal configurations found are occupied" in result.reason or "the goal is" in result.reason


def test_blocking_obstacles_are_named_with_their_interval(planar_arm: to.Robot) -> None:
    # The upper arm has to pass there, and the joint's limits leave no way round.
    lands = to.Track.through([0.0, 0.4], [to.placement((0.22, 0.2, z)) for z in (1.5, PLANE)])
    scene = to.Scene(planar_arm).add("post", to.Cylinder(0.05, 0.5), motion=lands)
    scene = scene.add("late", to.Sphere(0.1), to.placement((0.5, 0.5, PLANE)), appears=60.0)
    result = to.plan(problem(scene), budget=FAST)
    assert result.status is to.Status.BLOCKED_IN_TIME and result.certainty is Certainty.EVIDENCE
    (block,) = result.blocks
    assert block.subjects[1] == "post" and block.begin is not None and block.end is not None
    assert 0.2 < block.begin < block.end < 1.3 and block.amount > 0.0 and block.place is not None
    assert f"motion without what changes from {block.begin:.2f} to {block.end:.2f} s" in result.reason


def test_nothing_is_claimed_where_waiting_does(planar_arm: to.Robot) -> None:
    passes = to.Track.through([0.0, 0.6, 1.2], [AWAY, AT_GOAL, AWAY])
    result = to.plan(problem(to.Scene(planar_arm).add("ball", to.Sphere(0.1), motion=passes)))
    assert result.verified and not result.blocks


@pytest.fixture
def unexplained(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let planning try everything, whatever is proven."""
    monkeypatch.setattr("trajopt.planning.moving.dynamic_search.proof_of_failure", lambda *_: None)
    monkeypatch.setattr("trajopt.planning.moving.dynamic_search.explained", lambda refused, *_: refused)


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize("seed", range(12))
def test_no_motion_is_found_where_it_is_proven_that_there_is_none(planar_arm: to.Robot, seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = [to.placement((x, y, PLANE)) for x, y in rng.uniform(-1.0, 1.0, (2, 2)).tolist()]
    track = to.Track.through([0.0, float(rng.uniform(0.1, 1.0))], places)
    scene = to.Scene(planar_arm).add("ball", to.Sphere(float(rng.uniform(0.05, 0.3))), motion=track)
    asked = problem(scene)
    timed = asked.reduced.timed
    assert timed is not None
    why = InTime(asked, timed, WorkCounts())
    proven = why.inevitable(proven=True) or why.goal_occupied([np.array((1.5, 0.0))], proven=True)
    assert proven is None or not to.plan(asked, budget=to.Budget(attempts=2)).verified
