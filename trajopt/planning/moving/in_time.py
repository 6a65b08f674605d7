"""Among things that change with time: later, timed on the path, around them, or another way."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from math import ceil, inf
from typing import Protocol

import numpy as np

from trajopt.optimise.methods import Choice
from trajopt.optimise.methods.space_time import PRECISION, SpaceTime
from trajopt.planning.budget import BudgetTracker, Stopped
from trajopt.planning.judgement import Judged
from trajopt.planning.moving.meeting import Rendezvous, goals_that_move, soonest_goal
from trajopt.planning.moving.space_time import BECAUSE, ENOUGH, InSpaceTime
from trajopt.planning.moving.still import without_changes
from trajopt.planning.moving.why_not import explained, impossible
from trajopt.planning.result import Result
from trajopt.planning.search import ENDED
from trajopt.planning.status import Certainty, Status
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import GoalSet
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.arrays import Floats
from trajopt.values.placement import WORLD
from trajopt.values.shapes.shapes import bounding_box

LONGER = 1.5
"""Expected duration of a detour as a multiple of the motion without moving objects; their places of this
time are avoided.
"""
MOST_PLACES = 24
"""Largest number of places of one object: more would wall the arm in."""
AROUND, OTHERWISE = 4, 12
"""Attempts at a detour, a straight line and three sampled paths, and at any other way: objects frozen
on their paths often leave none at all.
"""


class Run(Protocol):
    """Plans one problem."""

    def __call__(
        self, problem: Problem, /, *, most: int | None = None, choice: Choice | None = None
    ) -> Result:
        """Plan with at most this number of attempts, by the requested method or another."""
        ...


def in_time(
    problem: Problem,
    run: Run,
    tracker: BudgetTracker,
    rng: np.random.Generator,
    on_incumbent: Callable[[Result], None] | None,
) -> Result:
    """Return the motion that ends soonest; for a moving goal, the one that meets it soonest.

    Args:
        problem: The problem.
        run: Plans a problem.
        tracker: Counts the use of the budget, and stops planning.
        rng: Random generator.
        on_incumbent: Called with every verified motion that is shorter than the one before.
    """
    if not goals_that_move(problem):
        return _to_where_it_stands(problem, run, tracker, rng, on_incumbent)
    if isinstance(problem.goal, GoalSet):
        return soonest_goal(problem, lambda alone: in_time(alone, run, tracker, rng, on_incumbent))
    return Rendezvous(problem, lambda each: run(each, most=AROUND), tracker).planned(on_incumbent)


def _to_where_it_stands(
    problem: Problem,
    run: Run,
    tracker: BudgetTracker,
    rng: np.random.Generator,
    on_incumbent: Callable[[Result], None] | None,
) -> Result:
    """Return the motion that ends soonest, by four ways of planning it, each timed among dynamic obstacles.

    The first is the motion without dynamic obstacles. If it is not clear, shape and time
    are planned together. If that fails, a motion clear of the places that objects
    pass, or end at, is looked for. If none is clear, the seeds of the schedule are attempted, with their
    shape and time planned together.
    """
    alone = run(replace(problem, scene=without_changes(problem.scene)))
    there = replace(alone.problem, scene=problem.scene)
    if not alone.verified:
        return replace(alone, problem=there)
    soonest, work = alone.require().trajectory.duration, PlanningWorkspace(there, tracker)
    best, stopped = work.result(Status.BLOCKED_IN_TIME), alone.stopped
    try:
        best = _soonest_from(alone, best, work, rng)
        ways = _other_ways(problem, LONGER * soonest)
        while not best.verified and not _ended(best, soonest) and (way := next(ways, None)) is not None:
            other, most = way
            found = run(other, most=most, choice=_choice(problem) if most == OTHERWISE else None)
            stopped = found.stopped
            if found.verified or found.status is Status.TOO_LATE:
                better = _among(found, problem.scene, tracker) if found.verified else found
                best = min(best, better, key=_order)
            if stopped is not None:
                break
        best = explained(best, alone, tracker)
    except Stopped as ended:
        stopped = ended.stop
    if best.verified and on_incumbent is not None:
        on_incumbent(best)
    if not best.verified and stopped is not None:
        best = replace(best, status=ENDED[stopped])
    return replace(best, stopped=stopped, counts=dict(tracker.counts), cpu_seconds=dict(tracker.seconds))


def _soonest_from(alone: Result, none: Result, work: PlanningWorkspace, rng: np.random.Generator) -> Result:
    """Return the motion that ends soonest, from the one without dynamic obstacles, or why there is none.

    Hardly longer motions come first, since nothing can be much better; the rest takes longer to find.
    If an obstacle sweeps the start, a proof that there is no motion is tried first: that takes less.
    """
    planned = alone.require()
    for motion in work.soon(_motion(alone), ENOUGH * planned.trajectory.duration):
        judged = work.judged(motion, alone.solve)
        if judged.verified:
            return _kept(judged, alone)
    swept = not work.stands_clear(planned.trajectory.duration)
    if swept and (refused := impossible(_unjudged(alone, work), alone, work.tracker)) is not None:
        return refused
    together, best = InSpaceTime.of(work, alone, none), none
    if together is not None:
        if (near := together.hardly_longer()).verified:
            return near
        best = together.longer()
        if best.stopped is not None:
            return best
    timed = _timed_among(alone, work, PRECISION * _duration(best))
    best = best if timed is None else min(timed, best, key=_order)
    if not best.verified and not swept:
        best = impossible(_unjudged(alone, work), alone, work.tracker) or best
    if together is not None and not _ended(best, planned.trajectory.duration):
        best = together.shortest(best, rng)
    if best.verified or best.certainty is Certainty.PROVEN:
        return best
    as_it_is = _as_it_is(alone, work)
    return as_it_is if best is none or as_it_is.verified else best


def _motion(result: Result) -> MotionCandidate:
    planned = result.require()
    return MotionCandidate(planned.path, planned.trajectory, result.timed)


def _unjudged(alone: Result, work: PlanningWorkspace) -> Result:
    """Return the motion without dynamic obstacles as a refused one; the violation is measured on demand."""
    motion = alone.require()
    judged = Judged(work.problem, motion.trajectory, verified=False)
    return work.result(
        Status.BLOCKED_IN_TIME,
        path=motion.path,
        solve=alone.solve,
        trajectory=motion.trajectory,
        timed=alone.timed,
        judged=judged,
    )


def _kept(judged: Result, other: Result) -> Result:
    """Return a judged motion with its method."""
    fields = ("attempts", "won", "method", "because", "along_path", "goal_name")
    kept = {name: getattr(other, name) for name in fields}
    return replace(judged, remarks=(*other.remarks, *judged.remarks), **kept)


def _choice(problem: Problem) -> Choice | None:
    """Return the method for seeds from which nothing was planned yet; None for the requested one."""
    method = SpaceTime()
    return None if method.objection(problem) else Choice(method, BECAUSE)


def _ended(best: Result, soonest: float) -> bool:
    """Return whether nothing can end sooner, or it is proven that nothing solves the problem."""
    return _duration(best) <= soonest if best.verified else best.certainty is Certainty.PROVEN


def _other_ways(problem: Problem, duration: float) -> Iterator[tuple[Problem, int]]:
    for around in _with_places(problem, duration):
        yield around, AROUND
    yield problem, OTHERWISE


def _order(result: Result) -> tuple[bool, bool, float]:
    """Order results: first motions, then ones that are only late, then by duration."""
    late = result.status is Status.TOO_LATE and result.trajectory is not None
    duration = inf if result.trajectory is None else result.trajectory.duration
    return not result.verified, not late, duration


def _duration(result: Result) -> float:
    return result.require().trajectory.duration if result.verified else inf


def _among(other: Result, scene: Scene, tracker: BudgetTracker) -> Result:
    if other.problem.scene is scene:
        return other
    return _judged(other, PlanningWorkspace(replace(other.problem, scene=scene), tracker))


def _judged(other: Result, work: PlanningWorkspace) -> Result:
    """Judge a motion among dynamic obstacles, unchanged, begun later, or retimed on its path."""
    return _timed_among(other, work) or _as_it_is(other, work)


def _as_it_is(other: Result, work: PlanningWorkspace) -> Result:
    """Judge a motion as it is, which may hold though it does not seem clear: looks keep some room."""
    judged = work.judged(_motion(other), other.solve)
    return _kept(judged, other) if judged.verified else _blocked(judged)


def _timed_among(other: Result, work: PlanningWorkspace, by: float = inf) -> Result | None:
    """Judge a motion timed so that it seems clear by a time [s]; None if none does."""
    refused: Result | None = None
    for motion in work.clear(_motion(other), by):
        judged = work.judged(motion, other.solve)
        if judged.verified:
            return _kept(judged, other)
        refused = judged if refused is None else min(refused, judged, key=_order)
    return None if refused is None else _blocked(refused)


def _blocked(refused: Result) -> Result:
    """Return a motion that was refused as one that is late, or else blocked."""
    if refused.status is Status.TOO_LATE:
        return refused
    return replace(
        refused,
        status=Status.BLOCKED_IN_TIME,
        message=f"the motion without what changes with time was refused: {refused.message}",
    )


def _with_places(problem: Problem, duration: float) -> Iterator[Problem]:
    """Yield the problem with objects at the places that they pass, and at the places at which they end."""
    scene = problem.scene
    yield _standing(problem, {name: _times(scene, name, duration) for name in scene.changing})
    ended = {
        name: np.array((max(_last(scene, name), 0.0),)) for name in scene.changing if _stays(scene, name)
    }
    if ended:
        yield _standing(problem, ended)


def _standing(problem: Problem, places: Mapping[str, Floats]) -> Problem:
    """Return the problem with each object at rest at its places of some times [s]."""
    scene = problem.scene
    among = without_changes(scene)
    for name, times in places.items():
        item = scene.objects[name]
        for number, time in enumerate(times.tolist()):
            copy = SceneObject(
                f"{name} {number}", item.parts, scene.placement_at(name, time), WORLD, item.touch_links
            )
            among = replace(among, objects={**among.objects, copy.name: copy})
    return replace(problem, scene=among)


def _stays(scene: Scene, name: str) -> bool:
    return scene.objects[name].timing.expires == inf and _last(scene, name) < inf


def _last(scene: Scene, name: str) -> float:
    """Return the time at which an object has come to rest [s]."""
    carrier = scene.carrier(name)
    motion = None if carrier is None else scene.objects[carrier].timing.motion
    return -inf if motion is None else motion.track.end


def _times(scene: Scene, name: str, duration: float) -> Floats:
    """Return times at which the places of a thing leave no gaps that the arm fits through, more or less."""
    item = scene.objects[name]
    begin, end = max(item.timing.appears, 0.0), min(item.timing.expires, duration)
    if begin >= end or scene.carrier(name) is None:
        return np.array((begin,)) if begin < duration else np.empty(0)
    looks = np.linspace(begin, end, 4 * MOST_PLACES)
    points = np.array([scene.placement_at(name, time).translation for time in looks.tolist()])
    way = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    sizes = [float((np.subtract(*bounding_box(shape)[::-1])).min()) for shape, _ in item.parts]
    count = min(MOST_PLACES, 1 + ceil(way / max(min(sizes, default=way), 1e-3)))
    return np.linspace(begin, end, count)
