"""Search among dynamic obstacles: sources in turn, until a motion is fast enough."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf

from trajopt.optimise.methods import Choice
from trajopt.optimise.methods.space_time import PRECISION, SpaceTime
from trajopt.planning.budget import Stop, Stopped
from trajopt.planning.moving.blocking_obstacles import explained, may_be_inevitable, proof_of_failure
from trajopt.planning.moving.rendezvous import Rendezvous, goals_that_move
from trajopt.planning.moving.space_time_attempts import BECAUSE, ENOUGH, FAR, BestMotion, SpaceTimeAttempts
from trajopt.planning.moving.static_scenes import along_tracks, at_ends, without_changes
from trajopt.planning.result import Result
from trajopt.planning.schedule import DYNAMIC, DynamicRow, MotionSource
from trajopt.planning.search import ENDED, PlanSearch
from trajopt.planning.status import Certainty, Status
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.problem.requirements import GoalSet
from trajopt.scene.scene import Scene

DETOUR = 1.5
"""Assumed ratio of detour duration to static duration."""


def planned_among_obstacles(search: PlanSearch) -> Result:
    """Return the motion that ends soonest among dynamic obstacles, or why there is none."""
    problem = search.problem
    if not goals_that_move(problem):
        return _to_resting_goal(search)
    if not isinstance(problem.goal, GoalSet):
        return Rendezvous(search).planned()
    told = search.on_incumbent
    found = {
        name: planned_among_obstacles(search.again(alone, on_incumbent=told))
        for name, alone in problem.alternatives.items()
    }
    name = min(found, key=lambda each: found[each].cost)
    return replace(found[name], goal_name=name)


def _to_resting_goal(search: PlanSearch) -> Result:
    problem = search.problem
    static = search.again(replace(problem, scene=without_changes(problem.scene))).run()
    found = static.problem.scene
    scene = replace(
        problem.scene,
        margin=found.margin,
        pair_margins={**problem.scene.pair_margins, **found.pair_margins},
        kind_margins=found.kind_margins,
    )
    there = replace(static.problem, scene=scene)
    if not static.verified:
        late = static.status is Status.TOO_LATE and static.certainty is not Certainty.PROVEN
        words = f"{'without what changes with time ' * late}{static.message}"
        return replace(static, problem=there, message=words)
    work = PlanningWorkspace(there, search.tracker)
    return DynamicSearch(search, static, work, BestMotion(work.result(Status.BLOCKED_IN_TIME))).run()


@dataclass(eq=False)
class DynamicSearch:
    """The search for one goal that rests.

    Attributes:
        search: The call of planning; its problem may have a goal set.
        work: Of the problem with the goal of that motion.
    """

    search: PlanSearch
    static: Result
    work: PlanningWorkspace
    best: BestMotion
    _stopped: Stop | None = field(init=False)

    def __post_init__(self) -> None:
        self._stopped = self.static.stopped

    def run(self) -> Result:
        """Try the rows of the table in turn; return the best motion, or why there is none."""
        best, tracker = self.best, self.search.tracker
        try:
            for row in DYNAMIC:
                if best.verified and not row.improves:
                    continue
                for found in SOURCES[row.source](self, row):
                    best.learn(found)
                if best.impossible or best.duration <= self.shortest or (row.ends and best.verified):
                    break
                if row.attempts and self._stopped is not None:
                    break
            best.result = explained(best.result, self.static, tracker)
        except Stopped as ended:
            self._stopped = ended.stop
        result = best.result
        if best.verified and self.search.on_incumbent is not None:
            self.search.on_incumbent(result)
        if not best.verified and self._stopped is not None:
            result = replace(result, status=ENDED[self._stopped])
        return replace(result, stopped=self._stopped).counted(tracker)

    @property
    def shortest(self) -> float:
        return self.static.require().trajectory.duration

    @cached_property
    def swept(self) -> bool:
        return may_be_inevitable(self.work.problem, self.static, self.search.tracker)

    @cached_property
    def attempts(self) -> SpaceTimeAttempts | None:
        return SpaceTimeAttempts.of(self.work, self.static, self.best)

    def planned(self, row: DynamicRow, scene: Scene, choice: Choice | None = None) -> Iterator[Result]:
        problem = self.search.problem
        found = self.search.again(replace(problem, scene=scene), choice=choice, most=row.attempts).run()
        self._stopped = found.stopped
        if found.verified and scene is not problem.scene:
            work = PlanningWorkspace(replace(found.problem, scene=problem.scene), self.search.tracker)
            yield _timed(found, work) or _unchanged(found, work)
        elif found.verified or found.status is Status.TOO_LATE:
            yield found


def _delay(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    del row
    for motion in search.work.delayed(_motion(search.static), ENOUGH * search.shortest):
        judged = search.work.judged(motion, search.static.solve)
        if judged.verified:
            yield _derived(judged, search.static)
            return


def _swept_start(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    del row
    if search.swept:
        yield from _proof(search)


def _occupied_goal(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    del row
    if not search.swept:
        yield from _proof(search)


def _proof(search: DynamicSearch) -> Iterator[Result]:
    found = proof_of_failure(search.work.problem, search.static, search.search.tracker)
    if found is not None:
        yield found


def _hardly_longer(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    del row
    if search.attempts is not None:
        search.attempts.hardly_longer()
    return iter(())


def _longer(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    del row
    if search.attempts is not None:
        search.attempts.longer()
    return iter(())


def _other_seeds(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    del row
    if search.attempts is not None:
        search.attempts.from_best()
        search.attempts.from_later_start()
        search.attempts.from_sampled_paths(search.search.rng)
    return iter(())


def _timing(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    del row
    if search.best.duration <= FAR * search.shortest:
        return
    timed = _timed(search.static, search.work, PRECISION * search.best.duration)
    if timed is not None:
        yield timed


def _as_it_is(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    del row
    unchanged = _unchanged(search.static, search.work)
    if unchanged.verified or search.best.result.path is None:
        yield unchanged


def _detour_along_tracks(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    return search.planned(row, along_tracks(search.search.problem.scene, DETOUR * search.shortest))


def _detour_around_ends(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    scene = at_ends(search.search.problem.scene)
    return iter(()) if scene is None else search.planned(row, scene)


def _all_seeds(search: DynamicSearch, row: DynamicRow) -> Iterator[Result]:
    problem, method = search.search.problem, SpaceTime()
    choice = None if method.objection(problem) else Choice(method, BECAUSE)
    return search.planned(row, problem.scene, choice)


SOURCES: Mapping[MotionSource, Callable[[DynamicSearch, DynamicRow], Iterator[Result]]] = {
    MotionSource.DELAY: _delay,
    MotionSource.SWEPT_START: _swept_start,
    MotionSource.HARDLY_LONGER: _hardly_longer,
    MotionSource.LONGER: _longer,
    MotionSource.TIMING: _timing,
    MotionSource.OCCUPIED_GOAL: _occupied_goal,
    MotionSource.OTHER_SEEDS: _other_seeds,
    MotionSource.UNCHANGED: _as_it_is,
    MotionSource.DETOUR_ALONG_TRACKS: _detour_along_tracks,
    MotionSource.DETOUR_AROUND_ENDS: _detour_around_ends,
    MotionSource.ALL_SEEDS: _all_seeds,
}
"""The results of each source, in the order in which they are found."""


def _motion(result: Result) -> MotionCandidate:
    planned = result.require()
    return MotionCandidate(planned.path, planned.trajectory, result.timed)


def _derived(judged: Result, other: Result) -> Result:
    return replace(judged.planned_as(other), remarks=(*other.remarks, *judged.remarks))


def _unchanged(other: Result, work: PlanningWorkspace) -> Result:
    """Judge a motion unchanged: it may hold although it does not seem clear, as checks keep a margin."""
    judged = work.judged(_motion(other), other.solve)
    return _derived(judged, other) if judged.verified else _blocked(judged)


def _timed(other: Result, work: PlanningWorkspace, by: float = inf) -> Result | None:
    refused: BestMotion | None = None
    for motion in work.retimed(_motion(other), by):
        judged = work.judged(motion, other.solve)
        if judged.verified:
            return _derived(judged, other)
        if refused is None:
            refused = BestMotion(judged)
        refused.learn(judged)
    return None if refused is None else _blocked(refused.result)


def _blocked(refused: Result) -> Result:
    if refused.status is Status.TOO_LATE:
        return refused
    words = f"the motion without what changes with time was refused: {refused.message}"
    return replace(refused, status=Status.BLOCKED_IN_TIME, message=words)
