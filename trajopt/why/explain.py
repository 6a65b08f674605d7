"""explain(result): the whole explanation."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import inf, isfinite

import numpy as np

from trajopt.geometry import WorkCounts, evaluator
from trajopt.optimise.terms import constrain
from trajopt.optimise.terms.joint_positions import fixed_positions
from trajopt.planning.infeasibility.inevitable import INTERVAL, LONGEST, InTime
from trajopt.planning.infeasibility.reasons import Obstruction, ObstructionKind
from trajopt.planning.plan import plan as plan_problem
from trajopt.planning.result import Result, Status
from trajopt.problem.motion import Motion
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FramePlacement, Relaxation, Requirement
from trajopt.problem.residual import WHOLE
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, function
from trajopt.values.errors import shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD
from trajopt.values.printed import in_unit
from trajopt.why.change import (
    ProblemChange,
    lighter_load,
    moved_joint_goal,
    moved_object,
    moved_placement,
    moved_start,
    slower_start,
    smaller_clearance,
    smaller_margin,
    smallest_changes,
    stronger_joint,
    with_requirement,
)
from trajopt.why.explanation import Explanation, diagnose
from trajopt.why.nearest import NearestFree, least_missed
from trajopt.why.prices import prices


@checked
def explain(
    result: Result, *, plan_again: bool = False, plan: Callable[[Problem], Result] = plan_problem
) -> Explanation:
    """Explain a result; see `Result.explain`.

    Args:
        plan_again: Whether to search remedies of a failure, or prices of a success in seconds.
        plan: Plans a changed problem; pass your own for a non-default method.

    Raises:
        ProblemError: If an argument is of the wrong kind.
    """
    function("plan", plan)
    if result.alternatives:
        name, nearest = next(iter(result.alternatives.items()))
        alone = explain(nearest, plan_again=plan_again, plan=plan)
        grounds = f"of the goal {shown(name)}, {alone.grounds}"
        return replace(alone, reason=result.reason, grounds=grounds, certainty=result.certainty)
    found = diagnose(result)
    if result.verified:
        return replace(found, prices=prices(result, seconds=plan_again))
    if plan_again:
        return replace(found, remedies=smallest_changes(candidates(found), plan))
    return found


AT_THE_START = {
    Status.START_IN_COLLISION,
    Status.START_OUT_OF_LIMITS,
    Status.START_CANNOT_BE_HELD,
    Status.START_BREAKS_CONSTRAINT,
}
AT_THE_GOAL = {
    Status.GOAL_IN_COLLISION,
    Status.GOAL_OUT_OF_LIMITS,
    Status.GOAL_CANNOT_BE_HELD,
    Status.GOAL_BREAKS_CONSTRAINT,
    Status.NO_INVERSE_KINEMATICS,
    Status.CONFLICTING_CONSTRAINTS,
}
IN_TIME = {
    Status.INEVITABLE,
    Status.FIXED_LINK_MET,
    Status.GOAL_OCCUPIED,
    Status.BLOCKED_IN_TIME,
    Status.TOO_LATE,
}
SPARE = 1.05
"""Factor on the violation of the elastic relaxation: the program keeps a reserve."""
SMALLEST = 1e-3
"""First amount of a change without an estimate [m | rad]."""
PAIRS = 3
"""Number of pairs in contact for which changes are tried."""
SAME_WAY = 0.999
"""Cosine of the angle below which two directions of an object count as one."""


def candidates(known: Explanation) -> Iterator[ProblemChange]:
    """Yield changes that may make a failed problem solvable, the most promising first."""
    problem = known.problem
    if known.status is Status.FIXED_LINK_MET:
        yield from (may_touch(problem, *block.subjects) for block in known.blocks)
    if known.status in IN_TIME:
        yield from changes_in_time(problem, known.blocks)
        return
    if known.status in AT_THE_START:
        yield from _at_the_start(known)
    elif known.status in AT_THE_GOAL:
        goal = fixed_positions(problem.goals, problem.reduced)
        yield from (_at_a_searched_goal(known) if goal is None else _at_a_fixed_goal(known, goal))
    elif known.status is Status.NO_WAYPOINT:
        yield from _at_the_waypoints(problem)
    elif problem.starts_moving:
        yield slower_start(problem)
    yield from _requirements_in_the_way(known)
    yield from _contacts(known)
    for block in known.blocks:
        if block.kind is ObstructionKind.EFFORT:
            yield from _effort(problem, block)


def _at_the_waypoints(problem: Problem) -> Iterator[ProblemChange]:
    def named(name: str, words: Callable[[float], str], amount: float) -> str:
        return f"at waypoint {name}, {words(amount)}"

    named_stops = zip(problem.waypoint_names, problem.waypoint_requirements, strict=True)
    for stop, (name, wanted) in enumerate(named_stops, start=1):
        for change in _gives_way(problem, wanted, problem.requirements_at(stop)):
            yield replace(change, words=partial(named, name, change.words))


def _at_the_start(known: Explanation) -> Iterator[ProblemChange]:
    if known.nearest_free is not None:
        yield moved_start(known.problem, known.nearest_free.moved)
    if known.status is Status.START_BREAKS_CONSTRAINT:
        start = known.problem.reduced.start_positions
        yield from _broken(known.problem, start, known.problem.requirements_at(0))


def _at_a_fixed_goal(known: Explanation, goal: Floats) -> Iterator[ProblemChange]:
    if known.nearest_free is not None:
        yield moved_joint_goal(known.problem, known.nearest_free.moved)
    if known.status is Status.GOAL_BREAKS_CONSTRAINT:
        yield from _broken(known.problem, goal, known.problem.requirements_at(known.problem.last_stop))


def _at_a_searched_goal(known: Explanation) -> Iterator[ProblemChange]:
    problem = known.problem
    always = problem.requirements_at(problem.last_stop)
    yield from _gives_way(problem, problem.goals, always)
    for required in always:
        # The start holds it, so widening it changes the path too.
        rest = [*problem.goals, *(item for item in always if item is not required)]
        stood = least_missed(problem, [required], hard=rest)
        if stood is not None:
            yield from (_widened(problem, required, way, stood.given) for way in required.relaxations)


def _gives_way(
    problem: Problem, wanted: Sequence[Requirement], always: Sequence[Requirement]
) -> Iterator[ProblemChange]:
    for required in wanted:
        rest = [*(item for item in wanted if item is not required), *always]
        stood = least_missed(problem, [required], hard=rest)
        if stood is None:
            continue
        if isinstance(required, FramePlacement):
            yield from _moved(problem, required, stood)
        yield from (_widened(problem, required, way, stood.given) for way in required.relaxations)


def _moved(problem: Problem, goal: FramePlacement, stood: NearestFree) -> Iterator[ProblemChange]:
    place = problem.reduced.all_positions(stood.positions)
    scene = problem.scene
    point = scene.placement_of(goal.frame, place) * goal.offset
    shift = scene.placement_of(goal.reference, place).inverse() * point - goal.placement.translation
    length = float(np.linalg.norm(shift))
    if length < 1e-6 or not np.isfinite(goal.position_tolerance).all():
        return
    axis = np.zeros(3)
    main = int(np.argmax(np.abs(shift)))
    axis[main] = np.sign(shift[main])
    if abs(shift[main]) > 0.7 * length:
        yield moved_placement(problem, goal, axis, SPARE * length)
    if abs(shift[main]) < 0.999 * length:
        yield moved_placement(problem, goal, shift, SPARE * length)


def _widened(problem: Problem, required: Requirement, way: Relaxation, amount: float) -> ProblemChange:
    return ProblemChange(
        what=way.what,
        unit=way.unit.base,
        first=min(max(SPARE * amount, SMALLEST), way.largest),
        largest=way.largest,
        words=way.words,
        apply=lambda more: with_requirement(problem, required, way.apply(more)),
    )


def _broken(problem: Problem, positions: Floats, always: Sequence[Requirement]) -> Iterator[ProblemChange]:
    motion = Motion.single(positions, problem.evaluator(problem.reduced))
    for required in always:
        items = constrain(required, problem.reduced, WHOLE)
        excess = max((item.excess(motion) for item in items), default=0.0)
        if excess > 0.0:
            yield from (_widened(problem, required, way, excess) for way in required.relaxations)


def _requirements_in_the_way(known: Explanation) -> Iterator[ProblemChange]:
    problem = known.problem
    for block in known.blocks:
        if block.kind is ObstructionKind.REQUIREMENT and block.place is not None:
            for required in problem.all_requirements:
                residuals = (item.residual for item in constrain(required, problem.reduced, WHOLE))
                if any(type(item) is block.residual and block.subjects == (item.name,) for item in residuals):
                    ways = required.relaxations
                    yield from (_widened(problem, required, way, block.amount) for way in ways)


def _contacts(known: Explanation) -> Iterator[ProblemChange]:
    problem, reduced = known.problem, known.problem.reduced
    pairs = [block for block in known.blocks if block.kind is ObstructionKind.CONTACT][:PAIRS]
    for block in pairs:
        margin = smaller_margin(problem, block.subjects[0], block.subjects[1], block.amount)
        if block.place is not None and margin is not None and block.amount <= margin.largest:
            yield margin
        clearance = smaller_clearance(problem, block.subjects[0], block.subjects[1], SPARE * block.amount)
        if clearance is not None and block.amount <= clearance.largest:
            yield clearance
    if known.configuration is None:
        return
    ways: list[tuple[str, Floats]] = []
    seen = evaluator(reduced).close_pairs(known.configuration[None], reduced.pairs.margin)
    for row in np.argsort(seen.distance).tolist():
        owners = reduced.owners(int(seen.pair[row]))
        if not any(block.subjects == owners for block in pairs):
            continue
        for name, sign in zip(owners, (-1.0, 1.0), strict=True):
            if name in problem.scene.objects and problem.scene.holder(name).link == WORLD:
                away = sign * seen.normal[row]
                if any(name == other and away @ way > SAME_WAY for other, way in ways):
                    continue
                ways.append((name, away))
                lack = float(reduced.pairs.margin[seen.pair[row]] - seen.distance[row])
                yield _moved_away(problem, name, away, lack)
        pairs = [block for block in pairs if block.subjects != owners]


def _moved_away(problem: Problem, name: str, direction: Floats, lack: float) -> ProblemChange:
    frame = problem.scene.holder(problem.scene.object(name).frame).placement
    return moved_object(problem, name, frame.rotation.T @ direction, SPARE * max(lack, SMALLEST))


def _effort(problem: Problem, block: Obstruction) -> Iterator[ProblemChange]:
    for name, item in problem.scene.objects.items():
        if item.mass > 0.0 and problem.scene.holder(name).link != WORLD:
            yield lighter_load(problem, name)
    joint = block.subjects[0]
    limit = float(problem.limits.effort[problem.reduced.joint_names.index(joint)])
    yield stronger_joint(problem, joint, limit + block.amount)


FIRST = 0.5
"""First amount of a change of times [s]: about half the duration of a motion."""
THINGS = 2
"""Number of obstacles for which changes are tried."""


def changes_in_time(problem: Problem, blocks: Sequence[Obstruction]) -> list[ProblemChange]:
    """Return candidate changes of a problem that fails among dynamic obstacles.

    Args:
        blocks: The obstacles, each named second in its block.
    """
    named = dict.fromkeys(block.subjects[-1] for block in blocks)
    things = [name for name in named if name in problem.scene.changing][:THINGS]
    found = [removed(problem, name) for name in things]
    found += [delayed(problem, name) for name in things if problem.scene.objects[name].frame == WORLD]
    ends = [block.end for block in blocks if block.end is not None and block.end < inf]
    later = begun_later(problem, max([FIRST, *ends]))
    deadline = None if problem.finish_by is None else longer(problem, problem.finish_by)
    return [change for change in (later, deadline, *found) if change is not None]


def begun_later(problem: Problem, first: float) -> ProblemChange | None:
    """Return the change to a later start; None if that cannot help, or the motions are unknown then."""
    timed, scene = problem.reduced.timed, problem.scene
    if timed is None or timed.until <= 2.0 * INTERVAL or problem.finish_by is not None:
        return None
    largest = min(LONGEST, timed.until - INTERVAL)
    moments: Floats = np.arange(0.0, largest, INTERVAL, dtype=np.float64)
    start = np.tile(problem.reduced.start_positions, (len(moments), 1))
    free = InTime(problem, timed, WorkCounts()).occupancy.free(start, moments)

    def words(amount: float) -> str:
        swept = not free[moments <= amount].all()
        return f"start {in_unit(amount, 's')} later" + (", and be elsewhere before" if swept else "")

    return ProblemChange(
        what="time of the start",
        unit="s",
        first=min(first, largest),
        largest=largest,
        words=words,
        apply=lambda amount: replace(problem, scene=scene.at(amount)),
    )


def longer(problem: Problem, deadline: float) -> ProblemChange:
    return ProblemChange(
        what="deadline",
        unit="s",
        first=FIRST,
        largest=LONGEST,
        words=lambda amount: f"allow {in_unit(amount, 's')} more, until {deadline + amount:.6g} s",
        apply=lambda amount: replace(problem, finish_by=deadline + amount),
    )


def may_touch(problem: Problem, link: str, name: str) -> ProblemChange:
    touching = replace(problem, scene=problem.scene.allow(link, name))
    return _whole(problem, touching, f"contact of {link} and {name}", f"let {name} touch {link}")


def removed(problem: Problem, name: str) -> ProblemChange:
    return _whole(problem, replace(problem, scene=_without(problem.scene, name)), name, f"remove {name}")


def _whole(problem: Problem, changed: Problem, what: str, words: str) -> ProblemChange:
    return ProblemChange(
        what=what,
        unit="",
        first=1.0,
        largest=1.0,
        words=lambda _: words,
        apply=lambda amount: changed if amount >= 1.0 else problem,
        whole=True,
    )


def delayed(problem: Problem, name: str) -> ProblemChange:
    """Return the change that delays an obstacle's motion."""
    scene, timing = problem.scene, problem.scene.objects[name].timing
    # What was always there would come later only from where it is.
    moves = timing.motion is not None

    def apply(amount: float) -> Problem:
        motion = timing.motion
        if motion is not None:
            motion = replace(motion, track=motion.track.shifted(-amount), until=motion.until + amount)
        times = {
            "appears": timing.appears + amount if isfinite(timing.appears) else None,
            "expires": timing.expires + amount if timing.expires < inf else None,
        }
        return replace(problem, scene=scene.with_motion(name, motion, **times))

    return ProblemChange(
        what=f"time of {name}",
        unit="s",
        first=FIRST,
        largest=8.0 * FIRST,
        words=lambda amount: f"let {name} {'move' if moves else 'appear'} {in_unit(amount, 's')} later",
        apply=apply,
    )


def _without(scene: Scene, name: str) -> Scene:
    for other, item in scene.objects.items():
        if item.frame == name and other in scene.objects:
            scene = _without(scene, other)
    return scene.remove(name)
