"""The next goal, planned while the motion to the one before is driven: from its end, or passing near it."""

from dataclasses import dataclass

import numpy as np

from trajopt.driving.commitment import Commitment
from trajopt.driving.events import Kind
from trajopt.driving.guard import start_from
from trajopt.driving.intention import Goal, Intention
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.room import with_share
from trajopt.planning import on_the_way
from trajopt.planning.plan import plan
from trajopt.scene.group_tools import tool_of
from trajopt.timing.standing import JOLT
from trajopt.values.arrays import Value

LOOK = 5e-3
"""Time between two looks at where the tool is [s]: at 1 m/s half a centimetre."""


@dataclass(frozen=True, eq=False)
class Transition(Value):
    """How one motion goes over into the next.

    Attributes:
        intended: The next motion.
        kind: What is noted when it begins: the goal before is reached, or passed.
        words: The particulars.
        at_rest: How it does from where the robot rests, of one that passes; else None.
    """

    intended: Intention
    kind: Kind
    words: str = ""
    at_rest: "Transition | None" = None


def from_rest(
    commitment: Commitment, options: SupervisorOptions, before: Intention, following: Goal
) -> tuple[Transition | None, str]:
    """Plan from where a motion that is being driven ends to the next goal.

    Args:
        commitment: What the robot will do.
        options: Of the supervisor.
        before: The motion.
        following: The goal after it.

    Returns:
        How to go on; or None, and why not.
    """
    begin = before.end + 2.0 * JOLT
    if stale := commitment.world.stale(begin):
        return None, stale
    problem, motion = following.problem, before.trajectory
    there = commitment.still_at(problem, begin, commitment.around(begin, commitment.world))
    positions, robot = np.array(there.start_positions), there.scene.robot
    positions[robot.index(problem.reduced.joint_names)] = motion(motion.duration)
    there = start_from(there, robot.followed(positions), there.scene)
    result = plan(there, budget=options.budget)
    if not result.verified:
        return None, with_share(result, following.guard.deviation)
    return Transition(Intention.of(following, result.require().trajectory, begin), Kind.REACHED), ""


def passing(
    commitment: Commitment, options: SupervisorOptions, before: Intention, at_rest: Transition
) -> tuple[Transition, str]:
    """Plan to the next goal from where a motion has come near enough to its own, as fast as it is there.

    Args:
        commitment: What the robot will do.
        options: Of the supervisor.
        before: The motion.
        at_rest: How to go on from its end.

    Returns:
        What is over sooner, and nothing.
    """
    following, near, away = at_rest.intended.goal, *_comes_near(before)
    if not commitment.soonest < near < before.end or commitment.world.stale(near):
        return at_rest, ""
    here = commitment.still_at(following.problem, near, commitment.around(near, commitment.world))
    result = plan(on_the_way(here, before.trajectory, near - before.begin), budget=options.budget)
    if not result.verified or commitment.soonest > near:
        return at_rest, ""
    intended = Intention.of(following, result.require().trajectory, near)
    if intended.end >= at_rest.intended.end:
        return at_rest, ""
    words = f"at {1e3 * away:.1f} mm, of {1e3 * before.goal.blend_radius:.1f} mm"
    return Transition(intended, Kind.PASSED, words, at_rest), ""


def _comes_near(intended: Intention) -> tuple[float, float]:
    """Return when the tool is near enough to where a motion takes it, for good [s], and how near then [m]."""
    motion, scene = intended.trajectory, intended.goal.problem.scene
    tool, reduced = tool_of(scene, intended.goal.problem.group), intended.goal.problem.reduced
    times = np.append(np.arange(0.0, motion.duration, LOOK), motion.duration)
    points = [scene.placement_of(tool, reduced.all_positions(each)).translation for each in motion(times)]
    away = np.linalg.norm(np.array(points) - points[-1], axis=1)
    far = np.flatnonzero(away > intended.goal.blend_radius)
    first = int(far[-1]) + 1 if len(far) else 0
    return intended.begin + float(times[first]), float(away[first])
