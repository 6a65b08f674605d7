"""Plans made while a robot is driven: replanning, retiming, the next goal, return to the path, recovery."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from trajopt.driving.active_motion import ActiveMotion
from trajopt.driving.commit_loop import Commitment
from trajopt.driving.events import EventKind
from trajopt.driving.intended_motion import GuardedGoal, IntendedMotion
from trajopt.driving.motion_guard import start_from, with_margin_share
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.world_snapshot import WorldSnapshot, grow_uncertain
from trajopt.geometry import Query
from trajopt.planning import Budget, on_the_way
from trajopt.planning.moving.among import Among
from trajopt.planning.moving.timed_path import TimedOnPath
from trajopt.planning.plan import plan
from trajopt.planning.replan import replan
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import joint_positions
from trajopt.problem.stated import GoalLike
from trajopt.scene.group_tools import tool_of
from trajopt.scene.scene import Scene
from trajopt.timing.standing import JOLT
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Judge


def replanned(running: ActiveMotion, goal: GuardedGoal, at: float, *, hurry: bool) -> Result:
    """Plan to a goal from where the robot will be at a time.

    Where things are known worse and worse, and nothing is proven to the goal for that, what is clear as
    well as they were known when they were seen will do: it is gone along as far as that is proven.

    Args:
        running: The motion that the robot is on.
        goal: The goal.
        at: On the executor's clock [s].
        hurry: Whether only what is over sooner is of use.
    """
    world = running.commitment.world
    result = _among(running, goal, at, world, hurry)
    known = world.as_well_known(at)
    if result.verified or known is None or not grow_uncertain(world):
        return result
    other = _among(running, goal, at, known, hurry)
    return other if other.verified else result


def _among(running: ActiveMotion, goal: GuardedGoal, at: float, world: WorldSnapshot, hurry: bool) -> Result:
    """Plan in a world, beginning with what is left of the motion.

    What is left of one that goes slower than it could, or waits, would be that slow again.
    """
    commitment, intended, budget = running.commitment, running.intended, running.options.budget
    slow = hurry or intended is None or intended.held_back or intended.scaling.speed != 1.0
    if intended is None or slow or not intended.begin <= at < intended.end:
        return plan(commitment.from_then(goal.problem, at, world), budget=budget)
    there = commitment.still_at(goal.problem, at, commitment.around(at, world))
    return replan(there, intended.trajectory, at - intended.begin, budget=budget)


def retime_on_path(
    intended: IntendedMotion, here: Problem, world: WorldSnapshot, begin: float, patience: float
) -> TimedOnPath | None:
    """Return what is left of a motion, timed anew on its path and proven to its end; None if no timing is.

    Args:
        intended: The motion.
        here: Its problem, from where the robot will be when the rest begins.
        world: What is known of the world.
        begin: When the rest begins, on the executor's clock [s].
        patience: It is over no later than so much after the motion as it was [s].
    """
    among = Among.of(here, Query(here.reduced))
    if among is None:
        return None
    rest = intended.left(begin)
    until = min(rest.duration + patience, among.latest)
    motions = among.timing.timings(rest, until)
    return next((each for each in motions if intended.goal.guard.proven(each.trajectory, world, begin)), None)


def return_to_path(commitment: Commitment, problem: Problem, at: float, budget: Budget) -> Trajectory | None:
    """Return the way from where a robot rests to where a stop led it off a path on which all held.

    Nothing that is required on the way may hold on it, but limits and clearances; it is proven.

    Args:
        commitment: What the robot will do.
        problem: What is asked of it.
        at: When it begins, on the executor's clock [s].
        budget: What the plan may take.

    Returns:
        The way; None where there is none, or no stop led off a path.
    """
    if commitment.left is None:
        return None
    driven = commitment.executor.joint_names
    places = {name: float(commitment.left[driven.index(name)]) for name in commitment.joint_names}
    there = replace(problem, goal=joint_positions(places), constraints=(), waypoints=())
    result = plan(commitment.from_then(there, at, commitment.world), budget=budget)
    if not result.verified:
        return None
    motion = result.require().trajectory
    proven = commitment.guard.proven(motion, commitment.world, at, requirements=False)
    return motion if proven else None


TOOL_STEP = 5e-3
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

    intended: IntendedMotion
    kind: EventKind
    words: str = ""
    at_rest: "Transition | None" = None


def from_rest(
    commitment: Commitment, options: SupervisorOptions, before: IntendedMotion, following: GuardedGoal
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
        return None, with_margin_share(result, following.guard.deviation)
    return Transition(IntendedMotion.of(following, result.require().trajectory, begin), EventKind.REACHED), ""


def passing(
    commitment: Commitment, options: SupervisorOptions, before: IntendedMotion, at_rest: Transition
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
    intended = IntendedMotion.of(following, result.require().trajectory, near)
    if intended.end >= at_rest.intended.end:
        return at_rest, ""
    words = f"at {1e3 * away:.1f} mm, of {1e3 * before.goal.blend_radius:.1f} mm"
    return Transition(intended, EventKind.PASSED, words, at_rest), ""


def _comes_near(intended: IntendedMotion) -> tuple[float, float]:
    """Return when the tool is near enough to where a motion takes it, for good [s], and how near then [m]."""
    motion, scene = intended.trajectory, intended.goal.problem.scene
    tool, reduced = tool_of(scene, intended.goal.problem.group), intended.goal.problem.reduced
    times = np.append(np.arange(0.0, motion.duration, TOOL_STEP), motion.duration)
    points = [scene.placement_of(tool, reduced.all_positions(each)).translation for each in motion(times)]
    away = np.linalg.norm(np.array(points) - points[-1], axis=1)
    far = np.flatnonzero(away > intended.goal.blend_radius)
    first = int(far[-1]) + 1 if len(far) else 0
    return intended.begin + float(times[first]), float(away[first])


DEEPEST = 0.01
"""Contact deeper than this is no light contact: somebody has to look [m]."""
YIELD = 1e-3
"""How much deeper than it is a contact may get while the robot leaves it: what touches yields so much [m]."""
LEAVING = 60.0
"""Contact is accepted so long at most [s]; that it ends is looked at."""
DISTANCE_ROUNDING = 1e-6
"""Differences of distances below this are none [m]."""
SEPARATION_STEP = 5e-3
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
    for number, configuration in enumerate(motion(np.arange(0.0, motion.duration, SEPARATION_STEP))):
        near = {(pair.first, pair.second): pair for pair in judge.examine(configuration).collisions}
        for pair, found in near.items():
            if number and found.distance < before.get(pair, inf) - DISTANCE_ROUNDING:
                return found.words
        before = {pair: found.distance for pair, found in near.items()}
        if not before:
            return ""
    return ", ".join(" and ".join(pair) for pair in before)
