"""An xArm7 among cubes that bounce in a room: SI-RRT's generator, frozen.

Rules, after `generate_mass_test.py` of Kerimov, Onegin and Yakovlev, Safe Interval Randomized Path Planning
For Manipulators (arXiv 2412.19567; MIT), published before anything was tuned to them:

* An xArm7 (theirs is an xArm6) stands in the middle of a room of 2 m x 2 m x 2 m, with no floor. Start and
  goal: each joint evenly within its limits, at least pi apart in the sum of all joints, both clear of the
  arm itself.
* Cubes of 5 to 10 cm, in line with the world's axes, their middles evenly in the room, the velocity along
  each axis evenly in -0.2 to 0.2 m/s. Where a middle reaches a wall this part of its velocity changes sign.
  They pass through each other and through the arm's base.
* The scene lasts 20 s; nothing is known of it later, so a motion must be over by then. A cube is drawn
  again while it touches the arm at the start at time 0 or the arm at the goal at 20 s.
* Test i has 49 cubes, drawn one after the other; of density d it has the first d. Random numbers:
  `default_rng((SEED, i))`, in the order of these points. Theirs has the same cubes for 50 pairs of start
  and goal.

What is left as it comes: a cube may sweep the start, or the first links, which cannot get away. Such a test
has no solution, whoever plans it.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

import trajopt as to
from benchmarks.moving.crossings import Arm
from trajopt.verify import Judge, Moment

SEED = 241219567
DENSITIES = (1, 10, 20, 30, 40, 49)
TESTS = 50
WALL, SIDES, SPEED, LASTS = 1.0, (0.05, 0.1), 0.2, 20.0
APART = np.pi


@dataclass(frozen=True)
class Cube:
    """A cube that bounces.

    Attributes:
        side: Of the cube [m].
        middle: Where its middle is at time 0, (3,) [m].
        velocity: At time 0, (3,) [m/s].
    """

    side: float
    middle: np.ndarray
    velocity: np.ndarray

    @property
    def shape(self) -> to.Box:
        """The cube."""
        return to.Box(self.side, self.side, self.side)

    @property
    def times(self) -> np.ndarray:
        """When it bounces, and both ends [s]."""
        found = [0.0, LASTS]
        for place, speed in zip(self.middle.tolist(), self.velocity.tolist(), strict=True):
            first = (WALL - np.sign(speed) * place) / abs(speed)
            found += np.arange(first, LASTS, 2.0 * WALL / abs(speed)).tolist()
        return np.unique(found)

    def middles(self, times: np.ndarray) -> np.ndarray:
        """Return its middle at times (s,), (s, 3) [m]: its straight way, folded at the walls."""
        straight = self.middle + np.multiply.outer(times, self.velocity)
        return WALL - np.abs(np.mod(straight + WALL, 4.0 * WALL) - 2.0 * WALL)

    @property
    def motion(self) -> to.Prediction:
        """Its way, known until the scene ends."""
        places = [to.placement(xyz) for xyz in self.middles(self.times)]
        return to.Prediction(to.Track.through(self.times, places), until=LASTS)


@dataclass(frozen=True)
class Room:
    """A test.

    Attributes:
        start: Positions of the joints, (7,) [rad].
        goal: The same.
        cubes: All of them.
    """

    start: np.ndarray
    goal: np.ndarray
    cubes: tuple[Cube, ...]

    def problem(self, density: int) -> to.Problem:
        """Return the problem with the first cubes only."""
        problem = _alone(self.start, self.goal)
        scene = problem.scene
        for number, cube in enumerate(self.cubes[:density]):
            scene = scene.add(f"cube{number}", cube.shape, motion=cube.motion)
        return to.Problem(scene=scene, group=problem.group, start=_state(self.start), goal=problem.goal)


@cache
def xarm7() -> to.Robot:
    """Return the arm."""
    return to.load("xarm7")


def room(number: int) -> Room:
    """Draw a test."""
    rng, limits = np.random.default_rng((SEED, number)), _alone(np.zeros(7), np.zeros(7)).limits
    while True:
        start, goal = rng.uniform(limits.lower, limits.upper), rng.uniform(limits.lower, limits.upper)
        if np.abs(goal - start).sum() > APART and _clear(start, goal):
            break
    arm = Arm(_alone(start, goal).reduced)
    ends = [(arm.placements(start), 0.0), (arm.placements(goal), LASTS)]
    cubes: list[Cube] = []
    while len(cubes) < max(DENSITIES):
        cube = Cube(float(rng.uniform(*SIDES)), rng.uniform(-WALL, WALL, 3), rng.uniform(-SPEED, SPEED, 3))
        there = [to.placement(cube.middles(np.array((time,)))[0]) for _, time in ends]
        apart = [
            arm.distance(bodies, cube.shape, where) for (bodies, _), where in zip(ends, there, strict=True)
        ]
        if min(apart) > 0.0:
            cubes.append(cube)
    return Room(start, goal, tuple(cubes))


def _clear(start: np.ndarray, goal: np.ndarray) -> bool:
    judge = Judge(_alone(start, goal).reduced)
    ends = ((start, Moment.START), (goal, Moment.END))
    return all(judge.examine(positions, moment=moment).clear for positions, moment in ends)


def _state(positions: np.ndarray) -> dict[str, float]:
    return dict(zip(xarm7().group("xarm7").joints, positions.tolist(), strict=True))


def _alone(start: np.ndarray, goal: np.ndarray) -> to.Problem:
    return to.Problem(
        scene=to.Scene(xarm7()),
        group="xarm7",
        start=_state(start),
        goal=to.joint_positions(_state(goal)),
    )
