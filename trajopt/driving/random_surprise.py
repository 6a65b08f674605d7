"""A random surprise: a box that appears on the way that a robot still has before it.

The rule, the same for every robot: the motion to the goal is planned in the world as it is known. A time is
drawn evenly from the first nine tenths of it, and a later time of the motion, at least `NOTICE` after the
robot could have come to rest. The box appears at the first time, where the tip of the group (one of them, if
it has several) is at the second: its edges are drawn from 4 to 12 cm, it is turned about the vertical by any
angle, and off the tip by up to half an edge along each axis. It is drawn anew while it is within `ROOM` of
the robot, or of what it carries, as it is then or anywhere on the way on which it would come to rest, or at
the start or the goal: no robot could avoid the first, and none would get there with the others. A supervised
robot begins to move `BEHIND` after it was asked to, so the way counts from so long before.
"""

from dataclasses import replace
from math import pi

import numpy as np

from trajopt.driving.guard import guard_within
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.room import with_room
from trajopt.driving.simulated import TOLERANCE
from trajopt.driving.surprises import Surprise, Surprises
from trajopt.planning.plan import plan
from trajopt.problem.problem import Problem
from trajopt.scene.clearances import Part
from trajopt.scene.group_tools import ends_of
from trajopt.scene.reduced import reduce_model
from trajopt.simulation.whole import driven_joints
from trajopt.timing.stops import StopsAlong
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import placement
from trajopt.values.shapes.shapes import Box
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Judge

NOTICE = 0.15
"""Between rest, if the robot stopped at once, and where the box is in its way [s]: what is seen is late, and
so is what is commanded."""
BEHIND = SupervisorOptions().ahead
"""So far may a robot be behind the clock of the motion when the box appears [s]."""
ROOM = 0.02
"""Between the box and the robot where it cannot be elsewhere any more [m]."""
EDGES = (0.04, 0.12)
"""Least and largest edge of the box [m]."""
DRAWS = 200
"""So many boxes are drawn at most."""
LOOK = 0.02
"""Time between two places on the way to rest at which the box must be clear of the robot [s]: at 1 m/s as far
as it has to be away."""


@checked
def undisturbed(problem: Problem, *, tolerance: float = TOLERANCE) -> Trajectory:
    """Return the motion that a supervisor drives if nothing happens, for `random_surprise`.

    It keeps farther away than `plan` has to, by how far the robot can be off where it has to be.

    Args:
        problem: What is asked.
        tolerance: How far each joint may be from where it has to be [rad | m].

    Raises:
        PlanningFailed: If there is none.
    """
    driven = driven_joints(problem.scene.robot)
    guard = guard_within(problem, driven, np.full(len(driven), tolerance))
    roomy = with_room(problem.scene, guard.options.distance_error)
    return plan(replace(problem, scene=roomy)).require().trajectory


@checked
def random_surprise(problem: Problem, motion: Trajectory, seed: int) -> Surprises:
    """Draw a surprise on the way of a motion; the module says how.

    Args:
        problem: The problem that the motion solves.
        motion: The motion, from the clock's 0.
        seed: The same surprise every time.

    Raises:
        ProblemError: If no box of all that are drawn leaves the robot a way to rest.
    """
    rng, stops = np.random.default_rng(seed), StopsAlong(motion, problem.limits)
    scene, reduced = problem.scene, problem.reduced
    ends = ends_of(scene, problem.group)
    tip = ends[int(rng.integers(len(ends))) if len(ends) > 1 else 0]
    for _ in range(DRAWS):
        at = float(rng.uniform(0.0, 0.9 * motion.duration))
        rest = stops.earliest(at).trajectory
        first = at + rest.duration + NOTICE
        edges, turn = rng.uniform(*EDGES, 3), float(rng.uniform(-pi, pi))
        off, share = rng.uniform(-0.5, 0.5, 3) * edges, float(rng.uniform())
        if first >= motion.duration:
            continue
        later = first + share * (motion.duration - first)
        centre = scene.placement_of(tip, reduced.all_positions(motion(later))).translation + off
        box = Surprise(
            name="surprise", at=at, placement=placement(centre, rpy=(0.0, 0.0, turn)), shape=Box(*edges)
        )
        kept = [
            motion(np.arange(max(at - BEHIND, 0.0), at, LOOK)),
            rest(np.arange(0.0, rest.duration + LOOK, LOOK)),
            motion(np.array((0.0, motion.duration))),
        ]
        if has_room(problem, box, np.concatenate(kept)):
            return Surprises(objects=(box,))
    raise ProblemError(
        f"none of {DRAWS} random boxes leaves the robot a way to rest: the motion is too short"
    )


def has_room(problem: Problem, box: Surprise, configurations: Floats) -> bool:
    """Say whether robot and load are `ROOM` away from a box at configurations of shape (s, n)."""
    known = problem.scene
    carried = {name: item for name, item in known.objects.items() if known.part(name) is Part.CARRIED}
    alone = replace(known, objects=carried)
    scene = Surprises(objects=(box,)).seen(alone, box.at).with_clearance(world=ROOM)
    judge = Judge(reduce_model(scene, problem.group, problem.start_positions))
    return all(judge.examine(each).clear for each in configurations)
