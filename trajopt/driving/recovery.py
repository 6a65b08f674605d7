"""Recovery: out of light contact and on to a safe place, slowly."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from trajopt.driving.guard import start_from
from trajopt.planning.plan import plan
from trajopt.problem.problem import Problem
from trajopt.problem.stated import GoalLike
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Judge

DEEPEST = 0.01
"""Contact deeper than this is no light contact: somebody has to look [m]."""
YIELD = 1e-3
"""How much deeper than it is a contact may get while the robot leaves it: what touches yields so much [m]."""
LEAVING = 60.0
"""Contact is accepted so long at most [s]; that it ends is looked at."""
ROUNDING = 1e-6
"""Differences of distances below this are none [m]."""
LOOK = 5e-3
"""Time between two looks at whether things separate [s]."""


@dataclass(frozen=True, eq=False)
class Recovery(Value):
    """A motion out of contact.

    Attributes:
        trajectory: The motion; None where there is none.
        words: What touches and how the robot leaves it, or why there is no motion.
    """

    trajectory: Trajectory | None
    words: str


def recovery(
    problem: Problem, scene: Scene, positions: Floats, goal: GoalLike, *, scaling: float
) -> Recovery:
    """Plan from where a robot stands, maybe in light contact, to a goal.

    What touches may touch until it is apart, and no deeper than by what it yields; from then on everything
    keeps apart as it must. Whatever separates separates all the time.

    Args:
        problem: The group, and the limits; its goal and constraints do not count.
        scene: What is around the robot.
        positions: Of all joints, shape (number of joints,) [rad | m].
        goal: Where to go.
        scaling: Factor on the limits of velocity and acceleration.

    Raises:
        ProblemError: If the scaling is no factor in (0, 1].
    """
    here = start_from(problem, positions, scene)
    slow = replace(
        here, goal=goal, constraints=(), waypoints=(), velocity_scaling=scaling, acceleration_scaling=scaling
    )
    touching = Judge(here.reduced).examine(here.reduced.start_positions).collisions
    deep = next((pair for pair in touching if pair.distance < -DEEPEST), None)
    if deep is not None:
        return Recovery(
            None, f"{deep.first} is {-1e3 * deep.distance:.1f} mm inside {deep.second}: not light contact"
        )
    eased = scene
    for pair in touching:
        name = f"leaving {pair.second}"
        depth = max(-pair.distance, 0.0) + YIELD
        eased = eased.allow_contact(name, pair.first, pair.second, depth=depth, first=LEAVING)
    result = plan(replace(slow, scene=eased))
    if not result.verified:
        return Recovery(None, result.reason)
    motion = result.require().trajectory
    words = ", ".join(f"{pair.first} leaves {pair.second}" for pair in touching)
    pressed = _pressed(here, motion)
    if pressed:
        return Recovery(None, f"the motion found presses on: {pressed}")
    return Recovery(motion, words or "nothing touches")


def _pressed(here: Problem, motion: Trajectory) -> str:
    """Say which pair, too near at the start, does not separate all the time; empty if all do."""
    judge, before = Judge(here.reduced), dict[tuple[str, str], float]()
    for number, configuration in enumerate(motion(np.arange(0.0, motion.duration, LOOK))):
        near = {(pair.first, pair.second): pair for pair in judge.examine(configuration).collisions}
        for pair, found in near.items():
            if number and found.distance < before.get(pair, inf) - ROUNDING:
                return found.words
        before = {pair: found.distance for pair, found in near.items()}
        if not before:
            return ""
    return ", ".join(" and ".join(pair) for pair in before)
