"""The program over knots: fixed ends, samples, margins along the way, and the path back."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query
from trajopt.optimise.transcription import KnotsNlp, fixed_goal, transcribe
from trajopt.optimise.transcription.knots import (
    COARSE_SAMPLES,
    MOST_SAMPLES,
    SWEEP,
    shortest_duration,
    swept_samples,
)
from trajopt.optimise.transcription.margins import TaperedMargins
from trajopt.planning.seeds import straight_line
from trajopt.values.arrays import Floats

START = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
GOAL = {"pan": 1.0, "reach": 0.2, "elbow": 0.3, "wrist": 0.0}


@pytest.fixture
def scene(tmp_path: Path) -> to.Scene:
    return to.Scene(odd_arm(tmp_path)).add("pillar", to.Cylinder(0.08, 1.0), to.placement((0.72, 0, 0.3)))


def program(scene: to.Scene, **changes: object) -> tuple[to.Problem, KnotsNlp, Floats]:
    given: dict[str, object] = {"scene": scene, "start": START, "goal": to.joint_positions(GOAL)}
    problem = to.Problem(**{**given, **changes})  # pyright: ignore[reportArgumentType]
    goal = fixed_goal(problem)
    end = np.array(list(GOAL.values())) if goal is None else goal
    seed = straight_line(problem.reduced.start_positions, end, problem.knots)
    return problem, transcribe(problem, seed), seed


def test_joint_goal_fixes_both_ends(scene: to.Scene) -> None:
    _, nlp, seed = program(scene)
    assert (nlp.lower[0] == nlp.upper[0]).all() and (nlp.lower[-1] == nlp.upper[-1]).all()
    assert (nlp.lower[1:-1] < nlp.upper[1:-1]).all()
    at = nlp.linearise(seed, nlp.sampling(seed, fine=False))
    for block in at.constraints:
        free = (block.rows.knots > 0) & (block.rows.knots < len(seed) - 1)
        assert free.any(axis=1).all(), "a row on fixed knots only asks for nothing"


def test_pose_goal_leaves_the_last_knot_free(scene: to.Scene) -> None:
    where = scene.placement_of("tip", scene.robot.positions(GOAL))
    problem, nlp, seed = program(scene, goal=to.frame_placement("tip", where))
    assert fixed_goal(problem) is None
    assert (nlp.lower[-1] < nlp.upper[-1]).all()
    at = nlp.linearise(seed, nlp.sampling(seed, fine=False))
    (goal,) = (block for block in at.constraints if block.name == "placement of tip")
    assert len(goal.lower) == 6 and (goal.rows.place == len(seed) - 1).all()


def test_samples_are_as_dense_as_promised(scene: to.Scene) -> None:
    _, nlp, seed = program(scene)
    assert (nlp.sampling(seed, fine=False) == COARSE_SAMPLES).all()
    fine = nlp.sampling(seed, fine=True)
    for segment, count in enumerate(fine):
        steps = np.linspace(seed[segment], seed[segment + 1], count + 1)
        moved = nlp.query.displacement(steps[:-1], steps[1:])
        assert moved.max() <= SWEEP * 1.05


def test_violation_agrees_with_the_distance(scene: to.Scene) -> None:
    problem, nlp, seed = program(scene)
    at = nlp.linearise(seed, nlp.sampling(seed, fine=True))
    (clearance,) = (block for block in at.constraints if block.name == "clearance")
    row = int(np.argmax(clearance.violation))
    place = clearance.rows.place[row]
    q = seed[int(place)] + (place % 1.0) * (seed[min(int(place) + 1, len(seed) - 1)] - seed[int(place)])
    contacts = nlp.query.close_pairs(q[None], np.full(len(problem.reduced.pairs.margin), 0.05))
    expected = contacts.distance[list(contacts.pair).index(clearance.rows.component[row])]
    assert clearance.rows.value[row] == pytest.approx(expected - 0.01, abs=1e-9)


def test_decode_is_the_path_through_the_knots(scene: to.Scene) -> None:
    problem, nlp, seed = program(scene)
    path = nlp.decode(seed)
    assert path.joint_names == problem.reduced.joint_names
    assert np.array_equal(path.knots, seed)


def margins(**changes: object) -> TaperedMargins:
    scene_pairs = type("Pairs", (), {"margin": np.array([0.01]), "required": np.zeros(1)})()
    given: dict[str, object] = {
        "pairs": scene_pairs,
        "last": 10.0,
        "at_start": np.array([0.002]),
        "at_end": np.array([0.01]),
        "contact_until": np.array([-1.0]),
        "contact_from": np.array([np.inf]),
        "depth": np.array([0.0]),
    }
    return TaperedMargins(**{**given, **changes})  # pyright: ignore[reportArgumentType]


def test_margins_grow_from_the_clearance_of_the_start() -> None:
    places = np.array([0.0, 1.5, 3.0, 8.0, 10.0])
    pair = np.zeros(5, dtype=np.int64)
    assert margins()(pair, places) == pytest.approx([0.002, 0.006, 0.01, 0.01, 0.01])


def test_meant_contact_counts_for_its_time_only() -> None:
    rule = margins(contact_until=np.array([2.0]), depth=np.array([0.001]), at_start=np.array([-0.0005]))
    found = rule(np.zeros(4, dtype=np.int64), np.array([0.0, 2.0, 2.1, 9.0]))
    assert found[:2] == pytest.approx(-0.001)
    assert -0.0005 <= found[2] < 0.001 and found[3] == pytest.approx(0.01)


def test_shortest_duration_is_the_trapezoid(scene: to.Scene) -> None:
    limits = scene.robot.limits.take(scene.robot.index(["pan"]))
    v, a = limits.velocity[0], limits.acceleration[0]
    long, short = 4 * v * v / a, 0.25 * v * v / a
    assert shortest_duration(limits, np.zeros(1), np.array([long])) == pytest.approx(long / v + v / a)
    assert shortest_duration(limits, np.zeros(1), np.array([short])) == pytest.approx(2 * np.sqrt(short / a))


def test_a_whole_turn_in_one_segment_is_not_rest() -> None:
    """Its ends are one place: what is swept between them is measured along the way."""
    robot = to.load("planar2")
    reduced = to.Problem(
        scene=to.Scene(robot), start={}, goal=to.joint_positions({robot.joint_names[0]: 1.0})
    ).reduced
    query = Query(reduced)
    turn = np.array(((-np.pi, 0.0), (np.pi, 0.0), (np.pi, 0.1)))
    samples = swept_samples(query, turn)
    steps = np.linspace(turn[0], turn[1], samples[0] + 1)
    assert query.displacement(steps[:-1], steps[1:]).max() <= SWEEP * 1.05
    assert samples[1] < samples[0] / 10


def test_a_huge_step_is_measured_in_no_more_parts_than_samples(scene: to.Scene) -> None:
    problem, _, seed = program(scene)
    query = Query(problem.reduced)
    far = np.array((seed[0], seed[0] + 1e6))
    assert swept_samples(query, far).tolist() == [MOST_SAMPLES]
    assert query.counts.forward_kinematics <= 2 * MOST_SAMPLES


def test_a_requested_margin_grows_over_a_quarter_of_the_motion() -> None:
    wide = type("Pairs", (), {"margin": np.array([0.08]), "required": np.zeros(1)})()
    rule = margins(pairs=wide, last=40.0, at_start=np.zeros(1), at_end=np.array([0.04]))
    places = np.array([0.0, 5.0, 10.0, 20.0, 30.0, 35.0, 40.0])
    found = rule(np.zeros(7, dtype=np.int64), places)
    assert found == pytest.approx([0.0, 0.04, 0.08, 0.08, 0.08, 0.06, 0.04])


def test_a_requested_margin_begins_at_the_clearance_of_the_seeds_end(scene: to.Scene) -> None:
    where = scene.placement_of("tip", scene.robot.positions({**GOAL, "pan": 0.3}))
    goal = to.frame_placement("tip", where)
    for asked, there in ((scene, 0.01), (scene.with_margin(0.3), 0.3)):
        problem, nlp, seed = program(asked, goal=goal)
        near = np.full(len(problem.reduced.pairs.margin), 10.0)
        found = Query(problem.reduced).close_pairs(seed[-1:], near)
        at_end = nlp.margins.at_end
        for pair, distance in zip(found.pair.tolist(), found.distance.tolist(), strict=True):
            assert at_end[pair] == pytest.approx(there if asked is scene else min(there, distance))
