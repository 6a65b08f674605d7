"""A motion that is only just clear of what was believed is refused where the truth is a little different."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.oracles.moving_world import Oracle, Thing, through
from tests.oracles.random_worlds import bare
from trajopt.timing.time_scaling import begun_later
from trajopt.verify import Judge

START = {
    "panda_joint1": -0.8, "panda_joint2": 0.3, "panda_joint3": 0.0, "panda_joint4": -2.0,
    "panda_joint5": 0.0, "panda_joint6": 2.3, "panda_joint7": 0.8,
}  # fmt: skip
GOAL = {**START, "panda_joint1": 0.8, "panda_joint2": 0.5, "panda_joint4": -1.8}
FINEST = 2e-5
"""To within this the last moment is found at which a motion is still clear of what is believed [s]."""


@dataclass(frozen=True)
class Crossing:
    """A tall cylinder crosses the arm's way, from beyond its reach and back, and stays away then."""

    times: tuple[float, ...] = (0.9, 1.4, 1.5, 2.0)
    radius: float = 0.1
    error: tuple[float, float, float] = (0.01, 0.01, 0.01)
    appears: float = -inf
    expires: float = inf

    @property
    def thing(self) -> Thing:
        points = np.array([(x, 0.0, 0.5) for x in (1.6, 0.5, 0.5, 1.6)])
        track, poses = through(np.array(self.times), points, Rotation.identity(4))
        parts = ((to.Cylinder(self.radius, 3.0), to.placement((0.0, 0.0, 0.0))),)
        return Thing("crossing", parts, poses, track, self.error, self.appears, self.expires)


@pytest.fixture(scope="module")
def still() -> to.Result:
    try:
        scene = bare(to.load("panda"))
    except to.MissingExtra as error:
        pytest.skip(str(error))
    return to.plan(to.Problem(scene=scene, group="panda_arm", start=START, goal=to.joint_positions(GOAL)))


class World:
    """The motion that is planned without the crossing, begun later, judged among it."""

    def __init__(self, still: to.Result, crossing: Crossing) -> None:
        self.still, self.thing = still, crossing.thing
        self.problem = to.Problem(
            scene=self.thing.into(still.problem.scene),
            group="panda_arm",
            start=START,
            goal=still.problem.goal,
        )
        self.judge = Judge(self.problem.reduced)

    def motion(self, wait: float) -> to.Trajectory:
        return begun_later(self.still.require().trajectory, wait)

    def verified(self, wait: float) -> bool:
        return to.judge(self.problem, self.motion(wait), workspace=self.judge).verified

    def touched(self, wait: float) -> bool:
        oracle = Oracle(self.still.problem.reduced, self.motion(wait), [self.thing])
        return oracle.first_below(0.0) is not None


def edge(holds: Callable[[float], bool], clear: float, blocked: float) -> float:
    """Return a time at which something holds, and at which it no longer does a moment nearer to another."""
    assert holds(clear) and not holds(blocked)
    while abs(clear - blocked) > FINEST:
        middle = (clear + blocked) / 2.0
        clear, blocked = (middle, blocked) if holds(middle) else (clear, middle)
    return clear


TRUTH = Crossing()
THERE = Crossing(times=(-1.0, -0.5, 1.5, 2.0))
"""In the way from the beginning."""
LONG, SHORT = 2.5, 0.05
"""Waits after which the arm passes behind the crossing, and before it [s]."""
MIDDLE = 0.9
"""A wait after which it does not pass [s]."""


def later(by: float) -> tuple[float, ...]:
    return tuple(time + by for time in TRUTH.times)


def faster(by: float) -> tuple[float, ...]:
    return tuple(time / by for time in TRUTH.times)


BELIEFS = {
    "track 50 ms late": (TRUTH, Crossing(times=later(0.05)), SHORT),
    "track 10 % faster": (TRUTH, Crossing(times=faster(1.1)), LONG),
    "radius 2 mm less": (TRUTH, Crossing(radius=TRUTH.radius - 2e-3), LONG),
    "rho ignored": (TRUTH, Crossing(error=(0.0, 0.0, 0.0)), LONG),
    "growth of rho ignored": (TRUTH, Crossing(error=(TRUTH.error[0], 0.0, 0.0)), LONG),
    "expires one piece early": (
        Crossing(expires=TRUTH.times[2]), Crossing(expires=TRUTH.times[1]), LONG,
    ),
    "appears late": (replace(THERE, appears=0.9), replace(THERE, appears=0.95), SHORT),
}  # fmt: skip


@pytest.mark.parametrize("belief", BELIEFS)
def test_a_motion_clear_of_a_wrong_prediction_only_is_refused(still: to.Result, belief: str) -> None:
    truth, believed, clear = BELIEFS[belief]
    true, wrong = World(still, truth), World(still, believed)
    wait = edge(wrong.verified, clear, MIDDLE)
    assert not wrong.touched(wait), "the oracle agrees that it is clear of what is believed"
    assert true.touched(wait), "and that it is not clear of what is so"
    assert not true.verified(wait)
    assert "crossing" in to.judge(true.problem, true.motion(wait)).verdict


@pytest.mark.parametrize("clear", [SHORT, LONG])
def test_a_motion_just_clear_of_the_true_track_is_proven(still: to.Result, clear: float) -> None:
    world = World(still, TRUTH)
    wait = edge(world.verified, clear, MIDDLE)
    assert not world.touched(wait)
    nearer = wait + (MIDDLE - wait) / abs(MIDDLE - wait) * 1e-3
    assert world.touched(nearer), "within a millisecond of the first contact"
