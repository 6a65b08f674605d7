"""Proofs among things that move: nothing escapes, or the goal is never free; what is proven is so."""

from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from trajopt.geometry import WorkCounts
from trajopt.geometry.geometry import collision_geometry
from trajopt.planning.infeasibility.inevitable import InTime, Occupied, Sweep
from trajopt.planning.infeasibility.joint_bounds import by_then, farthest
from trajopt.values.arrays import Floats

GOAL = to.joint_positions({"shoulder": 1.5, "elbow": 0.0})
PLANE = 0.1
"""Height at which the planar arm moves [m]."""


def problem(
    scene: to.Scene, *, goal: to.Requirement = GOAL, start: float = 0.0, speed: float = 0.0
) -> to.Problem:
    return to.Problem(
        scene=scene,
        group="arm",
        start={"shoulder": start, "elbow": 0.0},
        goal=goal,
        start_velocity={"shoulder": speed, "elbow": 0.0},
    )


def in_time(asked: to.Problem) -> InTime:
    timed = asked.reduced.timed
    assert timed is not None
    return InTime(asked, timed, WorkCounts())


def flying(speed: float, *, radius: float = 0.2, hits: float = 0.75, from_: float = -1.0) -> to.Track:
    """Return the track of what flies along y, from 1 m beside the arm to 1 m on the other side."""
    places = [to.placement((hits, y, PLANE)) for y in (from_, -from_)]
    return to.Track.through([0.0, 2.0 / speed], places)


def inevitable(scene: to.Scene, **asked: object) -> Sweep | None:
    return in_time(problem(scene, **asked)).inevitable(proven=True)


# How far joints get


@pytest.mark.parametrize("seed", range(40))
def test_reachable_boxes_contain_all_motions_within_the_limits(seed: int) -> None:
    rng = np.random.default_rng(seed)
    fastest, hardest, jerk = rng.uniform(0.5, 3.0), rng.uniform(0.5, 8.0), rng.uniform(5.0, 80.0)
    speed, gain = rng.uniform(-1.0, 1.0) * fastest, rng.uniform(-1.0, 1.0) * hardest
    if seed % 3 == 0:
        jerk, gain = np.inf, 0.0
    step, ways = 1e-3, []
    for style in range(3):  # as hard as possible, at random, and in long random pushes
        place, velocity, acceleration, push = 0.0, speed, gain, 1.0
        for number in range(1000):
            if style == 1 or (style == 2 and number % 120 == 0):
                push = float(rng.uniform(-1.0, 1.0))
            wanted = hardest if style == 0 else push * hardest
            most, before = jerk * step, acceleration
            acceleration += float(np.clip(wanted - acceleration, -most, most))
            if jerk == np.inf:
                before = acceleration
            place += velocity * step
            if velocity + (before + acceleration) * step / 2.0 <= fastest:
                place += (before / 3.0 + acceleration / 6.0) * step**2
                velocity += (before + acceleration) * step / 2.0
            ways.append(((number + 1) * step, place))
    for time, place in ways:
        assert place <= farthest(time, speed, gain, fastest, hardest, jerk) + 1e-9


def test_the_bound_equals_the_travel_of_the_fastest_motion() -> None:
    # Jerk 10 to 2 m/s^2 in 0.2 s, on to 1 m/s after 0.6 s, then evenly.
    times = np.linspace(0.0, 1.0, 100_001)
    acceleration = np.minimum(10.0 * times, 2.0)
    velocity = np.minimum(np.cumsum(acceleration) * 1e-5, 1.0)
    assert farthest(1.0, 0.0, 0.0, 1.0, 2.0, 10.0) == pytest.approx(velocity.sum() * 1e-5, abs=1e-4)
    assert farthest(2.0, 0.5, 0.0, np.inf, 4.0, np.inf) == pytest.approx(0.5 * 2.0 + 4.0 * 2.0, rel=1e-5)
    assert farthest(2.0, 0.0, 0.0, 3.0, np.inf, np.inf) == pytest.approx(6.0)
    assert farthest(1.0, 0.0, 0.0, np.inf, np.inf, np.inf) == np.inf


def test_reachable_boxes_end_at_the_position_limits(planar_arm: to.Robot) -> None:
    asked = problem(to.Scene(planar_arm), start=2.9)
    lower, upper = by_then(asked, 5.0)
    assert upper.max() == pytest.approx(asked.limits.upper.max(), abs=2e-6)
    lower, upper = by_then(problem(to.Scene(planar_arm), speed=1.0), 0.05)
    assert upper[0] > -lower[0] and upper[1] == pytest.approx(-lower[1])


# Something sweeps the start


def test_an_obstacle_faster_than_the_escape_is_inevitable(planar_arm: to.Robot) -> None:
    found = inevitable(to.Scene(planar_arm).add("ball", to.Sphere(0.2), motion=flying(8.0)))
    assert found is not None and found.proven and found.thing == "ball"
    assert found.link in planar_arm.links and 0.05 < found.begin <= found.time < 0.3
    assert "ball sweeps" in found.words and f"{found.time:.3f} s" in found.words


def test_an_avoidable_obstacle_is_not_inevitable(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.05), motion=flying(0.3))
    assert inevitable(scene) is None
    assert in_time(problem(scene)).inevitable(proven=False) is None


def test_few_configurations_tell_whether_a_proof_is_worth_its_time(planar_arm: to.Robot) -> None:
    still = to.plan(problem(to.Scene(planar_arm))).require().trajectory
    fast = to.Scene(planar_arm).add("ball", to.Sphere(0.2), motion=flying(8.0))
    slow = to.Scene(planar_arm).add("ball", to.Sphere(0.05), motion=flying(1.0))
    assert in_time(problem(fast)).may_be_inevitable(still)
    assert not in_time(problem(slow)).may_be_inevitable(still), "it sweeps the start, which the arm has left"


def test_an_obstacle_after_the_arrival_proves_nothing(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.2), motion=flying(8.0))
    near = to.joint_positions({"shoulder": 0.01, "elbow": 0.0})
    assert inevitable(scene) is not None
    assert inevitable(scene, goal=near) is None


def test_a_wall_that_is_faster_than_the_arm_closes_the_room(planar_arm: to.Robot) -> None:
    swept = to.Track.through([0.0, 1.0], [to.placement((0.0, y, PLANE)) for y in (-3.0, 3.0)])
    wall = to.Scene(planar_arm).add("wall", to.Box(4.0, 1.0, 1.0), motion=swept)
    found = inevitable(wall, goal=to.joint_positions({"shoulder": 2.9, "elbow": 0.0}))
    assert found is not None and found.thing == "wall"


def test_nothing_that_is_reached_by_then_is_clear(planar_arm: to.Robot) -> None:
    """Of all configurations that joints may reach, many are tried by Coal; no proof is contradicted."""
    proofs = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        radius, error = float(rng.uniform(0.05, 0.25)), (float(rng.uniform(0.0, 0.02)), 0.05, 0.0)
        ball = flying(float(rng.uniform(3.0, 9.0)), hits=float(rng.uniform(0.4, 0.9)))
        scene = to.Scene(planar_arm).with_clearance(0.005)
        scene = scene.add("ball", to.Sphere(radius), motion=to.Prediction(ball, error))
        asked = problem(scene, speed=float(rng.uniform(-1.0, 1.0)))
        found = in_time(asked).inevitable(proven=True)
        if found is None:
            continue
        proofs += 1
        lower, upper = by_then(asked, found.time)
        kept = 0.005 + error[0] + error[1] * found.time
        for number, share in enumerate(rng.random((200, len(lower)))):
            reached = lower + (np.round(share) if number % 3 == 0 else share) * (upper - lower)
            assert clearance(asked, reached, to.Sphere(radius), ball.at(found.time)) <= kept
    assert proofs > 3


def clearance(asked: to.Problem, positions: Floats, shape: to.Sphere, place: to.Placement) -> float:
    """Return the least distance of the arm from a shape, by Coal [m]."""
    reduced = asked.reduced
    data = reduced.model.createData()
    pin.forwardKinematics(reduced.model, data, reduced.configuration(positions))
    least, other = np.inf, coal.Transform3s(place.rotation, place.translation)
    for body in reduced.bodies:
        if body.owner in reduced.scene.robot.links:
            at = data.oMi[body.joint] * pin.SE3(body.placement.rotation, body.placement.translation)
            mine = coal.Transform3s(at.rotation, at.translation)
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            geometry = collision_geometry(body.shape), collision_geometry(shape)
            least = min(least, coal.distance(geometry[0], mine, geometry[1], other, request, result))
    return least


# The goal is never free


def occupied(scene: to.Scene, *, proven: bool = True, goal: to.Requirement = GOAL) -> Occupied | None:
    asked = problem(scene, goal=goal)
    return in_time(asked).goal_occupied([np.array((1.5, 0.0))], proven=proven)


AT_GOAL = to.placement((0.0, 0.75, PLANE))
AWAY = to.placement((0.0, 3.0, PLANE))


def test_a_permanent_obstacle_at_the_goal_occupies_it(planar_arm: to.Robot) -> None:
    comes = to.Track.through([0.0, 0.3], [AWAY, AT_GOAL])
    found = occupied(to.Scene(planar_arm).add("ball", to.Sphere(0.1), motion=comes))
    assert found is not None and found.proven and found.until == np.inf
    assert (
        "the goal is occupied at all times: ball" in found.words
        and "nothing gets there before" in found.words
    )


def test_an_obstacle_that_appears_before_the_arrival_and_stays_occupies_the_goal(
    planar_arm: to.Robot,
) -> None:
    for appears, holds in ((0.2, True), (5.0, False)):
        found = occupied(to.Scene(planar_arm).add("ball", to.Sphere(0.1), AT_GOAL, appears=appears))
        assert (found is not None) is holds


def test_things_may_occupy_it_one_after_the_other(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("first", to.Sphere(0.1), AT_GOAL, expires=2.0)
    assert occupied(scene) is None
    for appears, holds in ((1.9, True), (2.1, False)):
        found = occupied(scene.add("second", to.Sphere(0.1), AT_GOAL, appears=appears))
        assert (found is not None) is holds
    whole = occupied(scene.add("second", to.Sphere(0.1), AT_GOAL, appears=1.9))
    assert whole is not None and [span.thing for span in whole.things] == ["first", "second"]
    assert whole.things[0].end == pytest.approx(2.0, abs=0.03) and whole.things[1].end == np.inf


def test_a_passing_obstacle_leaves_the_goal_free(planar_arm: to.Robot) -> None:
    passes = to.Track.through([0.0, 1.0, 2.0], [AWAY, AT_GOAL, AWAY])
    assert occupied(to.Scene(planar_arm).add("ball", to.Sphere(0.1), motion=passes)) is None


def test_a_goal_region_with_free_parts_is_not_proven_occupied(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.05), AT_GOAL, appears=0.1)
    wide = to.joint_positions({"shoulder": 1.5, "elbow": 0.0}, tolerance=0.5)
    assert occupied(scene) is not None
    assert occupied(scene, goal=wide) is None
    evidence = occupied(scene, goal=wide, proven=False)
    assert evidence is not None and not evidence.proven


def test_after_the_prediction_the_goal_counts_as_free(planar_arm: to.Robot) -> None:
    track = to.Track.through([0.0, 9.0], [AT_GOAL, AWAY])
    known = to.Prediction(track, until=0.8)
    found = occupied(to.Scene(planar_arm).add("ball", to.Sphere(0.4), motion=known))
    assert found is not None and found.proven and found.until == 0.8


def test_a_goal_that_is_free_for_less_than_the_dwell_is_occupied(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("first", to.Sphere(0.1), AT_GOAL, expires=2.0)
    scene = scene.add("second", to.Sphere(0.1), AT_GOAL, appears=2.5)
    for dwell, holds in ((0.0, False), (0.4, False), (0.6, True), (3.0, True)):
        asked = replace(problem(scene), dwell=dwell)
        found = in_time(asked).goal_occupied([np.array((1.5, 0.0))], proven=True)
        assert (found is not None) is holds
        if found is not None:
            assert 0.5 <= found.longest < 0.56 and f"never free for {dwell:g} s" in found.words


def test_by_a_deadline_the_goal_may_never_be_free(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("ball", to.Sphere(0.1), AT_GOAL, expires=2.0)
    for deadline, holds in ((1.9, True), (2.5, False)):
        asked = replace(problem(scene), finish_by=deadline)
        found = in_time(asked).goal_occupied([np.array((1.5, 0.0))], proven=True)
        assert (found is not None) is holds
        assert found is None or found.until == deadline
