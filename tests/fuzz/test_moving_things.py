"""Random problems among random things that move, and nonsense tracks: no crash, no false success."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.fuzz.scenarios import Kind, scenario
from tests.oracles.moving_world import Oracle
from tests.oracles.random_worlds import into, random_things
from trajopt.planning.status import Certainty
from trajopt.scene.reducing import reduce_model
from trajopt.values.errors import PlanningFailed

HERE = to.placement((0.5, 0.0, 0.5))
QUICK, ALL, CHUNK = 9, 300, 30


def outcome(number: int) -> str:
    """Plan a random problem among random things, check what comes out, and return how it ended."""
    drawn = scenario(number)
    if drawn.kind is Kind.NONSENSE:
        return "nonsense"
    rng, problem = np.random.default_rng((20261122, number)), drawn.make()
    bare = reduce_model(to.Scene(problem.scene.robot), problem.group, problem.start_positions)
    goal = bare.start_positions + rng.uniform(-0.5, 0.5, len(bare.joint_names))
    points = np.stack((bare.start_positions, goal))
    things = random_things(bare, to.Trajectory(bare.joint_names, np.array((0.0, 1.5)), points), rng)
    among = replace(problem, scene=into(problem.scene, things))
    if rng.random() < 0.3:
        among = replace(among, dwell=float(rng.uniform(0.1, 1.0)))
    if rng.random() < 0.3:
        among = replace(among, finish_by=float(rng.uniform(0.2, 4.0)))
    result = to.plan(among, budget=to.Budget(attempts=2))
    if not result.verified:
        assert result.message.strip(), f"{result.status.name} without a reason"
        assert str(result.explain()).strip()
        with pytest.raises(PlanningFailed):
            result.require()
        return f"{result.status.name} {'proven' if result.certainty is Certainty.PROVEN else ''}".strip()
    motion = result.require().trajectory
    assert among.finish_by is None or motion.duration <= among.finish_by + 1e-6
    assert Oracle(bare, motion, things).first_below(-1e-5) is None, f"number {number} touches"
    assert result.require().certificate.at_fault >= result.require().certificate.clearance > 0.0
    return "SOLVED"


def test_some_random_problems_with_dynamic_obstacles() -> None:
    seen = Counter(outcome(number) for number in range(QUICK))
    assert seen["SOLVED"] > 0


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("first", range(0, ALL, CHUNK))
def test_many_random_problems_with_dynamic_obstacles(first: int) -> None:
    assert Counter(outcome(number) for number in range(first, first + CHUNK))["SOLVED"] > 0


# Nonsense


def track(**changes: object) -> to.Track:
    """Return a track of two pieces, with some fields changed."""
    good = to.Track.through([0.0, 1.0, 2.0], [HERE, to.placement((0.6, 0.0, 0.5), rpy=(0.0, 0.0, 1.0)), HERE])
    return replace(good, **changes)


def good() -> to.Track:
    return track()


BAD: dict[str, Callable[[], object]] = {
    "times that repeat": lambda: to.Track.through([0.0, 0.0], [HERE, HERE]),
    "times that decrease": lambda: to.Track.through([1.0, 0.0], [HERE, HERE]),
    "one time": lambda: to.Track.through([0.0], [HERE]),
    "no time": lambda: to.Track.through([], []),
    "a time that is not a number": lambda: to.Track.through([0.0, np.nan], [HERE, HERE]),
    "a time without end": lambda: to.Track.through([0.0, np.inf], [HERE, HERE]),
    "a time beyond all": lambda: to.Track.through([0.0, 1e12], [HERE, HERE]),
    "fewer placements": lambda: to.Track.through([0.0, 1.0, 2.0], [HERE, HERE]),
    "a placement that is a word": lambda: to.Track.through([0.0, 1.0], [HERE, "there"]),
    "times that are words": lambda: to.Track.through(["now", "then"], [HERE, HERE]),
    "a jump": lambda: track(coefficients=track().coefficients + np.array((0.0, 1.0))[None, :, None]),
    "a rotation that jumps": lambda: track(rotations=np.stack((np.eye(3), np.diag((1.0, -1.0, -1.0))))),
    "an axis of no length": lambda: track(axes=np.zeros((2, 3))),
    "a rate that is not a number": lambda: track(rates=np.array((np.nan, 0.0))),
    "coefficients of another shape": lambda: track(coefficients=np.zeros((2, 3, 3))),
    "a velocity without end": lambda: to.Track.constant_velocity(HERE, (np.inf, 0.0, 0.0)),
    "a velocity in the plane": lambda: to.Track.constant_velocity(HERE, (1.0, 0.0)),
    "an end before the start": lambda: to.Track.constant_velocity(HERE, (1.0, 0.0, 0.0), start=2.0, end=1.0),
    "a negative error": lambda: to.Prediction(good(), (-0.01, 0.0, 0.0)),
    "an error of two numbers": lambda: to.Prediction(good(), (0.01, 0.0)),  # pyright: ignore[reportArgumentType]
    "an error that is not a number": lambda: to.Prediction(good(), (np.nan, 0.0, 0.0)),
    "a prediction that is over": lambda: to.Prediction(good(), until=0.0),
    "a prediction of a word": lambda: to.Prediction("left"),  # pyright: ignore[reportArgumentType]
}


@pytest.mark.parametrize("what", BAD)
def test_a_track_that_is_nonsense_is_refused(what: str) -> None:
    with pytest.raises(to.TrajoptError) as caught:
        BAD[what]()
    assert str(caught.value).strip(), "an error without words"


EDITS: dict[str, Callable[[to.Scene], object]] = {
    "a motion and a placement": lambda scene: scene.add("box", to.Sphere(0.1), HERE, motion=good()),
    "a motion in another frame": lambda scene: scene.add("a", to.Sphere(0.1), HERE).add(
        "box", to.Sphere(0.1), frame="a", motion=good()
    ),
    "a motion that is a word": lambda scene: scene.add("box", to.Sphere(0.1), motion="left"),
    "an end before it appears": lambda scene: scene.add(
        "box", to.Sphere(0.1), HERE, appears=2.0, expires=1.0
    ),
    "an appearance that is not a number": lambda scene: scene.add(
        "box", to.Sphere(0.1), HERE, appears=np.nan
    ),
    "a motion of nothing": lambda scene: scene.with_motion("ghost", good()),
    "a clock before the start": lambda scene: scene.at(-1.0),
    "a clock that is not a number": lambda scene: scene.at(np.nan),
    "a clock after what is known": lambda scene: scene.add(
        "box", to.Sphere(0.1), motion=to.Prediction(good(), until=1.0)
    ).at(2.0),
}


@pytest.mark.parametrize("what", EDITS)
def test_a_scene_that_is_nonsense_is_refused(planar_arm: to.Robot, what: str) -> None:
    with pytest.raises(to.TrajoptError) as caught:
        EDITS[what](to.Scene(planar_arm))
    assert str(caught.value).strip(), "an error without words"
