"""The events of a run, drawn from a seed.

Within the errors that were stated, by the seed's last digit:

- 0 to 4, `appears`: a box appears on the way, by the rule of `random_surprise`.
- 5 to 7, `late`: the same, and sensors are 10 ms late, with noise of a tenth of the tolerance.
- 8 and 9, `moves`: a cube crosses the way, where the tip would be when it comes there, and leaves. It is
  known from the beginning to within an error of 5 mm that grows by 10 mm/s; where it really is, is off by up
  to as much, in a direction that is drawn. It is drawn again while it begins where the robot stands.

Beyond them (`beyond`), where nothing is promised but that the robot ends at rest and says so, by the seed
modulo 5: a joint sticks; a joint drifts by ten times the tolerance; commands are lost; the noise is three
times the tolerance, and nothing was said of it; the cube is off by 60 mm and 100 mm/s more than it may be.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

import trajopt as to
from trajopt.driving import Fault, FaultKind, Sensors, Surprise, Surprises, random_surprise
from trajopt.driving.surprises import DRAWS, has_room
from trajopt.scene.group_tools import ends_of
from trajopt.scene.scene import Scene
from trajopt.values.errors import ProblemError

TOLERANCE = 1e-3
"""How far a joint of the simulated robots may be from where it has to be [rad | m]."""
ERROR = (0.005, 0.01, 0.0)
"""Of the prediction: radius [m], velocity [m/s] and acceleration [m/s^2]."""
SPEED = 0.2
"""Largest velocity of the cube along each axis of the plane [m/s]: that of SI-RRT's generator."""
EDGES = (0.05, 0.1)
"""Least and largest edge of the cube [m]: those of SI-RRT's generator."""
BEYOND = (0.06, 0.1)
"""By how much more than it may be the cube is off [m], [m/s]."""


class Part(Enum):
    """Kinds of runs."""

    APPEARS = "appears"
    LATE = "late"
    MOVES = "moves"
    BEYOND = "beyond"


@dataclass(frozen=True, eq=False, kw_only=True)
class Drawn:
    """A run.

    Attributes:
        part: Of what kind it is.
        problem: With what is known of the world.
        surprises: What is not.
    """

    part: Part
    problem: to.Problem
    surprises: Surprises


@dataclass(frozen=True, eq=False, kw_only=True)
class _OffTrack(Surprises):
    """A cube is not at its reported place.

    Attributes:
        really: Where it is.
    """

    really: to.Track

    def world(self, scene: Scene) -> Scene:
        return scene.with_motion("cube", motion=self.really)


def part_of(seed: int) -> Part:
    """Return the surprises of a seed within the stated errors."""
    digit = seed % 10
    return Part.APPEARS if digit < 5 else Part.LATE if digit < 8 else Part.MOVES


def drawn(problem: to.Problem, undisturbed: Callable[[float], to.Trajectory], part: Part, seed: int) -> Drawn:
    """Draw a run.

    Args:
        problem: The problem.
        undisturbed: Its motion where nothing happens, for how far joints may be from where they have to be
            [rad | m].
        part: What kind of run.
        seed: The same run every time.

    Raises:
        ProblemError: If no box that is drawn leaves the robot a way to rest.
    """
    kind = seed % 5 if part is Part.BEYOND else None
    if part is Part.MOVES or kind == 4:
        return _crossing(
            part, problem, undisturbed(TOLERANCE), seed, beyond=(0.0, 0.0) if kind is None else BEYOND
        )
    late = {None: 0.1 * TOLERANCE if part is Part.LATE else 0.0, 3: 3.0 * TOLERANCE}.get(kind, 0.0)
    stated = 0.0 if kind == 3 else None
    sensors = Sensors(delay=0.01 if late else 0.0, noise=late, stated=stated, seed=seed)
    motion = undisturbed(TOLERANCE + sensors.error)
    faults = () if kind is None or kind == 3 else (_fault(problem, motion, kind, seed),)
    return Drawn(
        part=part,
        problem=problem,
        surprises=Surprises(
            objects=random_surprise(problem, motion, seed).objects, sensors=sensors, faults=faults
        ),
    )


def _fault(problem: to.Problem, motion: to.Trajectory, kind: int, seed: int) -> Fault:
    rng = np.random.default_rng((seed, kind))
    names, begin = problem.reduced.joint_names, float(rng.uniform(0.0, 0.9 * motion.duration))
    joint = str(rng.choice(names))
    if kind == 0:
        return Fault(kind=FaultKind.STUCK, begin=begin, end=begin + 60.0, joint=joint)
    if kind == 1:
        return Fault(kind=FaultKind.DRIFT, begin=begin, end=begin + 60.0, joint=joint, size=10.0 * TOLERANCE)
    return Fault(kind=FaultKind.LOST_COMMANDS, begin=begin, end=begin + 60.0)


def _crossing(
    part: Part, problem: to.Problem, motion: to.Trajectory, seed: int, *, beyond: tuple[float, float]
) -> Drawn:
    """Draw a cube that crosses the way.

    Raises:
        ProblemError: If all that are drawn begin where the robot stands.
    """
    rng = np.random.default_rng((seed, 8))
    for _ in range(DRAWS):
        at = float(rng.uniform(0.3, 0.8)) * motion.duration
        tip = str(rng.choice(ends_of(problem.scene, problem.group)))
        where = problem.scene.placement_of(tip, problem.reduced.all_positions(motion(at))).translation
        velocity = np.append(rng.uniform(-SPEED, SPEED, 2), 0.0)
        edge, direction = float(rng.uniform(*EDGES)), rng.standard_normal(3)
        direction /= float(np.linalg.norm(direction))
        share = float(rng.uniform(0.0, 1.0))
        cube = Surprise(
            name="cube", at=0.0, placement=to.placement(where - at * velocity), shape=to.Box(edge, edge, edge)
        )
        if has_room(problem, cube, motion(np.zeros(1))):
            break
    else:
        raise ProblemError(f"none of {DRAWS} cubes leaves the robot room where it starts")
    radius, growth = (share * own + more for own, more in zip(ERROR[:2], beyond, strict=True))

    def track(off: float, faster: float) -> to.Track:
        begin = where - at * velocity + off * direction
        return to.Track.constant_velocity(to.placement(begin), velocity + faster * direction)

    said = to.Prediction(track(0.0, 0.0), error=ERROR)
    scene = problem.scene.add("cube", to.Box(edge, edge, edge), motion=said)
    return Drawn(
        part=part,
        problem=replace(problem, scene=scene),
        surprises=_OffTrack(really=track(radius, growth)),
    )
