"""Plans made while a robot is driven."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from trajopt.driving.active_motion import ActiveMotion
from trajopt.driving.commit_loop import Commitment
from trajopt.driving.events import EventKind
from trajopt.driving.intended_motion import GuardedGoal, IntendedMotion
from trajopt.driving.motion_guard import reason_with_margin, start_from
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.planning import Budget, on_the_way
from trajopt.planning.moving.dynamic_timing import DynamicTiming
from trajopt.planning.moving.timed_path import TimedOnPath
from trajopt.planning.plan import plan
from trajopt.planning.replan import replan
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import joint_positions
from trajopt.problem.stated import GoalLike
from trajopt.scene.group_tools import tool_of
from trajopt.scene.scene import Scene
from trajopt.timing.time_scaling import JOLT
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Judge

TOOL_STEP = 5e-3
"""Time between samples of the tool's position [s]: half a centimetre at 1 m/s."""
DEEPEST = 0.01
"""Deepest penetration that counts as light contact [m]."""
YIELD = 1e-3
"""Additional penetration while the robot leaves a contact [m]."""
LEAVING_TIME = 60.0
"""Longest time for which the contact is allowed [s]; separation is checked."""
DISTANCE_ROUNDING = 1e-6
"""Smaller differences of distances count as none [m]."""
SEPARATION_STEP = 5e-3
"""Time between checks that the bodies in contact separate [s]."""


@dataclass(frozen=True, eq=False)
class Transition(Value):
    """The change from a motion to the one to the next goal.

    Attributes:
        at_rest: The transition from rest that replaces it if passing fails; None for one from rest.
    """

    intended: IntendedMotion
    kind: EventKind
    words: str = ""
    at_rest: "Transition | None" = None


def replan_from(active: ActiveMotion, goal: GuardedGoal, at: float, *, only_sooner: bool) -> Result:
    """Plan to a goal from the commanded state at a time on the executor's clock [s].

    If growing position errors prevent a proof up to the goal, a plan is made for the errors of the last
    report; it is followed as far as it is proven.

    Args:
        only_sooner: Whether only a motion that ends sooner is of use.
    """
    world = active.commitment.world
    result = _plan_in(world, active, goal, at, only_sooner)
    frozen = world.without_growing_errors(at)
    if result.verified or frozen is None or not world.errors_grow:
        return result
    other = _plan_in(frozen, active, goal, at, only_sooner)
    return other if other.verified else result


def _plan_in(
    world: WorldSnapshot, active: ActiveMotion, goal: GuardedGoal, at: float, only_sooner: bool
) -> Result:
    commitment, intended, budget = active.commitment, active.intended, active.options.budget
    slow = only_sooner or intended is None or intended.held_back or intended.scaling.speed != 1.0
    if intended is None or slow or not intended.begin <= at < intended.end:
        return plan(commitment.continued(goal.problem, at, world), budget=budget)
    there = commitment.resting(goal.problem, at, commitment.planning_scene(at, world))
    return replan(there, intended.trajectory, at - intended.begin, budget=budget)


def retime_on_path(
    commitment: Commitment, intended: IntendedMotion, here: Problem, begin: float, patience: float
) -> TimedOnPath | None:
    """Return the rest of a motion with another timing on its path, proven to its end, or None.

    Args:
        here: From the state of the robot when the rest begins.
        patience: It ends no later than this after the present motion [s].
    """
    timing = DynamicTiming.of(here, here.evaluator(here.reduced))
    if timing is None:
        return None
    rest = intended.after(begin)
    until = min(rest.duration + patience, timing.latest)
    world, committed = commitment.world, commitment.motion

    def proven(motion: Trajectory) -> bool:
        # A longer wait cannot begin at the end of another: the acceleration may jump there.
        refused = committed.refusal(motion, begin, earliest=begin)
        return not refused and intended.goal.guard.proven(motion, world, begin)

    motions = timing.timing.timings(rest, until)
    return next((each for each in motions if proven(each.trajectory)), None)


def return_to_path(commitment: Commitment, problem: Problem, at: float, budget: Budget) -> Trajectory | None:
    """Return a motion back to the place at which a stop left a path, or None.

    The motion is proven for limits and clearances; path constraints may not hold on it.
    """
    if commitment.left_path_at is None:
        return None
    driven = commitment.executor.joint_names
    positions = {name: float(commitment.left_path_at[driven.index(name)]) for name in commitment.joint_names}
    there = replace(problem, goal=joint_positions(positions), constraints=(), waypoints=())
    result = plan(commitment.continued(there, at, commitment.world), budget=budget)
    if not result.verified:
        return None
    motion = result.require().trajectory
    proven = commitment.guard.proven(motion, commitment.world, at, requirements=False)
    return motion if proven else None


def from_rest(
    commitment: Commitment, options: SupervisorOptions, before: IntendedMotion, goal: GuardedGoal
) -> tuple[Transition | None, str]:
    """Return the plan from the end of a motion to the next goal; or None and the reason."""
    begin = before.end + 2.0 * JOLT
    if stale := commitment.world.stale(begin):
        return None, stale
    problem, motion = goal.problem, before.trajectory
    there = commitment.resting(problem, begin, commitment.planning_scene(begin, commitment.world))
    positions, robot = np.array(there.start_positions), there.scene.robot
    positions[robot.index(problem.reduced.joint_names)] = motion(motion.duration)
    there = start_from(there, robot.followed(positions), there.scene)
    result = plan(there, budget=options.budget)
    if not result.verified:
        return None, reason_with_margin(result, goal.guard.deviation)
    return Transition(IntendedMotion.of(goal, result.require(), begin), EventKind.REACHED), ""


def passing(
    commitment: Commitment, options: SupervisorOptions, before: IntendedMotion, at_rest: Transition
) -> Transition:
    """Plan to the next goal from the entry into the blend radius; return the transition that ends sooner."""
    goal, near, distance = at_rest.intended.goal, *_enters_blend(before)
    if not commitment.soonest < near < before.end or commitment.world.stale(near):
        return at_rest
    here = commitment.resting(goal.problem, near, commitment.planning_scene(near, commitment.world))
    result = plan(on_the_way(here, before.trajectory, near - before.begin), budget=options.budget)
    if not result.verified or commitment.soonest > near:
        return at_rest
    intended = IntendedMotion.of(goal, result.require(), near)
    if intended.end >= at_rest.intended.end:
        return at_rest
    words = f"at {1e3 * distance:.1f} mm, of {1e3 * before.goal.blend_radius:.1f} mm"
    return Transition(intended, EventKind.PASSED, words, at_rest)


def _enters_blend(intended: IntendedMotion) -> tuple[float, float]:
    """Return when the tool enters the blend radius for good [s], and its distance from the goal then [m]."""
    motion, scene = intended.trajectory, intended.goal.problem.scene
    tool, reduced = tool_of(scene, intended.goal.problem.group), intended.goal.problem.reduced
    times = np.append(np.arange(0.0, motion.duration, TOOL_STEP), motion.duration)
    points = [scene.placement_of(tool, reduced.all_positions(each)).translation for each in motion(times)]
    distances = np.linalg.norm(np.array(points) - points[-1], axis=1)
    outside = np.flatnonzero(distances > intended.goal.blend_radius)
    first = int(outside[-1]) + 1 if len(outside) else 0
    return intended.begin + float(times[first]), float(distances[first])


@dataclass(frozen=True, eq=False)
class Recovery(Value):
    """A motion out of contact."""

    trajectory: Trajectory | None
    words: str


def recovery(
    problem: Problem, scene: Scene, positions: Floats, goal: GoalLike, *, scaling: float
) -> Recovery:
    """Plan from a configuration that may be in light contact to a goal, slowly.

    Pairs in contact may touch until they are apart, no deeper than they yield; from then on all clearances
    hold. Their distances never decrease.

    Args:
        scaling: Factor on the limits of velocity and acceleration.

    Raises:
        ProblemError: If the scaling is not in (0, 1].
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
        depth = max(-pair.distance, 0.0) + YIELD
        eased = eased.allow_contact(
            f"leaving {pair.second}", pair.first, pair.second, depth=depth, first=LEAVING_TIME
        )
    result = plan(replace(slow, scene=eased))
    if not result.verified:
        return Recovery(None, result.reason)
    motion = result.require().trajectory
    words = ", ".join(f"{pair.first} leaves {pair.second}" for pair in touching)
    approaching = _approaching(here, motion)
    if approaching:
        return Recovery(None, f"the planned motion increases a contact: {approaching}")
    return Recovery(motion, words or "nothing touches")


def _approaching(here: Problem, motion: Trajectory) -> str:
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
