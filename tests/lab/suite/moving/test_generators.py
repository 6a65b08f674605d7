"""The problems of the moving world are frozen: what was drawn once is drawn again."""

import hashlib
from collections import Counter

import numpy as np
import pytest

import trajopt as to
from benchmarks.moving.__main__ import crossing_keys
from benchmarks.moving.crossings import AWAY, BOX, FILE, SIDES, SPEEDS, Arm, crossings, drawn
from benchmarks.moving.cubes import DENSITIES, LASTS, SPEED, WALL, Cube, room
from benchmarks.moving.fixed_links import not_askable

START = {
    "panda_joint1": -0.8, "panda_joint2": 0.3, "panda_joint3": 0.0, "panda_joint4": -2.0,
    "panda_joint5": 0.0, "panda_joint6": 2.3, "panda_joint7": 0.8,
}  # fmt: skip
GOAL = {**START, "panda_joint1": 0.8, "panda_joint2": 0.5, "panda_joint4": -1.8}


def loaded(name: str) -> to.Robot:
    try:
        return to.load(name)
    except to.MissingExtra as error:
        pytest.skip(str(error))


def digest(values: np.ndarray) -> str:
    return hashlib.sha256(np.round(values, 9).tobytes()).hexdigest()[:16]


def test_the_boxes_that_cross_are_those_that_were_published() -> None:
    assert hashlib.sha256(FILE.read_bytes()).hexdigest()[:16] == "b368dd29fc2b55f7"
    boxes = crossings()
    assert Counter(key.split("/")[0] for key in boxes) == {"panda": 347, "ur5": 350}
    for box in boxes.values():
        speed = np.linalg.norm(box.velocity)
        assert SPEEDS[0] - 1e-5 <= speed <= SPEEDS[1] + 1e-5
        assert min(box.sides) >= SIDES[0] and max(box.sides) <= SIDES[1]
        assert 0.0 <= box.moment <= box.still


def test_omitted_problems_are_published() -> None:
    left_out = not_askable()
    assert len(left_out) == 19 and set(left_out) < set(crossings())
    asked = [f"{family.partition('/')[2]}/{number}" for family, number in crossing_keys(("panda", "ur5"), 1)]
    assert set(asked) == set(crossings()) - set(left_out) and len(asked) == len(set(asked))


def test_a_box_is_drawn_as_the_rules_say() -> None:
    problem = to.Problem(
        scene=to.Scene(loaded("panda")), group="panda_arm", start=START, goal=to.joint_positions(GOAL)
    )
    names, ends = problem.reduced.joint_names, np.array((list(START.values()), list(GOAL.values())))
    still = to.Trajectory(names, np.array((0.0, 1.5)), ends)
    box = drawn("panda/box/7", problem, still)
    assert box is not None
    assert digest(np.array((*box.place, *box.velocity, box.moment))) == "04c5e482da3108b6"
    arm, track = Arm(problem.reduced), box.track
    at = arm.placements(still(box.moment))
    assert arm.distance(at, box.shape, track.at(box.moment)) <= 0.0
    assert arm.distance(arm.placements(still(0.0)), box.shape, track.at(0.0)) >= 0.01
    begin, middle = (track.at(float(time)).translation for time in (track.times[0], box.moment))
    assert np.linalg.norm(middle - begin) == pytest.approx(AWAY, abs=1e-6)
    among = box.add_to(problem)
    assert among.scene.changing == (BOX,) or set(among.scene.changing) == {BOX}
    assert not to.judge(among, still).verified


def test_a_cube_bounces_at_the_walls() -> None:
    cube = Cube(0.1, np.array((0.9, 0.0, -0.5)), np.array((0.2, -0.1, -0.15)))
    track, steps, place, velocity = cube.motion.track, 20_000, cube.middle.copy(), cube.velocity.copy()
    for step in range(steps):
        if step % 500 == 0:
            assert np.allclose(track.at(step * LASTS / steps).translation, place, atol=1e-3)
        out = np.abs(place + velocity * LASTS / steps) > WALL
        velocity[out] *= -1.0
        place += velocity * LASTS / steps


def test_the_rooms_are_those_that_were_published() -> None:
    loaded("xarm7")
    first = room(0)
    numbers = np.concatenate(
        (first.start, first.goal, *(np.array((c.side, *c.middle, *c.velocity)) for c in first.cubes))
    )
    assert digest(numbers) == "3dab5c5ca970a377"
    assert len(first.cubes) == max(DENSITIES)
    assert max(np.abs(cube.velocity).max() for cube in first.cubes) <= SPEED
    assert set(first.problem(10).scene.changing) == {f"cube{number}" for number in range(10)}
