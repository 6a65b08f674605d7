"""plan(problem): seeds in order, until a motion is verified."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from threading import Event
from typing import Protocol, TypeVar, overload, runtime_checkable

import numpy as np

from trajopt.optimise.methods import Choice, Method, choose
from trajopt.planning.budget import Budget, BudgetTracker, Progress, Stop, Stopped
from trajopt.planning.experience import Experience
from trajopt.planning.moving.dynamic_search import planned_among_obstacles
from trajopt.planning.moving.space_time_attempts import BestMotion
from trajopt.planning.result import PlanArguments, Recalled, Result
from trajopt.planning.search import ENDED, PlanSearch, failure_of_all
from trajopt.planning.seeds import SeedLike, stated_seeds
from trajopt.planning.status import Certainty, Status
from trajopt.planning.workspace import PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.values.arrays import function, one_of, unless_none
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import named

NO_BOUNDS = Budget()
"""The default budget: the seeds of the schedule, in order."""


Outcome_co = TypeVar("Outcome_co", covariant=True)


@runtime_checkable
class Plannable(Protocol[Outcome_co]):
    """Several motions planned together; `trajopt.tasks.Task` is one."""

    def planned(
        self,
        *,
        improve: bool = False,
        rng: np.random.Generator | None = None,
        budget: Budget = NO_BOUNDS,
        cancel: Event | None = None,
        progress: Progress | None = None,
    ) -> Outcome_co:
        """Plan all motions; the arguments are those of `plan`."""
        ...


@overload
def plan(
    problem: Problem,
    *,
    method: Method | str | None = None,
    improve: bool = False,
    every_goal: bool = False,
    seeds: Sequence[SeedLike] = (),
    experience: Experience | None = None,
    seconds: float | None = None,
    rng: np.random.Generator | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
    progress: Progress | None = None,
    on_incumbent: Callable[[Result], None] | None = None,
) -> Result: ...


@overload
def plan(
    problem: Plannable[Outcome_co],
    *,
    improve: bool = False,
    seconds: float | None = None,
    rng: np.random.Generator | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
    progress: Progress | None = None,
) -> Outcome_co: ...


@named
def plan(
    problem: Problem | Plannable[Outcome_co],
    *,
    method: Method | str | None = None,
    improve: bool = False,
    every_goal: bool = False,
    seeds: Sequence[SeedLike] = (),
    experience: Experience | None = None,
    seconds: float | None = None,
    rng: np.random.Generator | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
    progress: Progress | None = None,
    on_incumbent: Callable[[Result], None] | None = None,
) -> Result | Outcome_co:
    """Plan a motion, or all motions of a task, and have them judged.

    Among dynamic obstacles the motion may begin later, stop, slow down, or go around; the fastest is
    returned. If a deadline is missed (`problem.finish_by`) and no method is named, shape and time are
    optimised together too.

    Args:
        problem: A problem, or a task (`trajopt.tasks.Task`), which takes only `improve`, `seconds`, `rng`,
            `budget`, `cancel` and `progress`.
        method: A method or its name ("chomp"). When None sequential QP over knots, or for a start in motion
            the method that supports it; the result names it.
        improve: Whether to optimise shape and time together too ("free-duration"), which takes a few times as
            long.
        every_goal: Whether all goals of a set are planned to (`result.of_each_goal`); the plan is the
            fastest. The goals share a budget's seconds and work.
        seeds: Paths to try first, the best first; each is moved so that it leads from the start to the goal.
        experience: Remembers motions (`trajopt.planning.experience.Experience`); the most similar is tried
            after `seeds`.
        seconds: Time limit [s, wall clock]; short for a budget of as many seconds.
        rng: Random generator; a fixed seed when None.
        budget: Limits of work, time and cores, and whether to go on improving.
        cancel: Set it from another thread to stop; the best motion so far is returned.
        progress: Called at every stage and step of the solver.
        on_incumbent: Called with every verified motion better than the one before.

    Returns:
        A result; `result.require()` returns the plan or raises with the reason. Of a task a `TaskResult`.

    Raises:
        SolverNotFound: If the method's name is unknown.
        ProblemError: If a requirement does not fit this robot, an argument is of the wrong kind, the method's
            plans cannot be improved, every goal is requested of one, or seeds with waypoints, or a task does
            not take an argument.
        ShapeError: If a seed does not fit the group's joints (`JointNotFound` if it does not name one).
        KeyboardInterrupt: If interrupted before there is a motion; afterwards the motion is returned.
    """
    if not isinstance(problem, Problem) and isinstance(problem, Plannable):  # pyright: ignore[reportUnnecessaryIsInstance]
        of_problems = (
            *(("method", method), ("experience", experience), ("on_incumbent", on_incumbent)),
            *(("every_goal", every_goal or None), ("seeds", seeds or None)),
        )
        for name, value in of_problems:
            if value is not None:
                raise ProblemError(f"{name} is an argument for a problem; a task does not take it")
        bounds = bounded(budget, seconds)
        return problem.planned(improve=improve, rng=rng, budget=bounds, cancel=cancel, progress=progress)
    tracker = BudgetTracker(bounded(budget, seconds), cancel, progress)
    function("on_incumbent", on_incumbent)
    given = unless_none("rng", rng, np.random.Generator)
    choice = choose(one_of("problem", problem, Problem), method, improve=improve)
    stated = stated_seeds(problem, seeds)
    recalled = _recalled(problem, experience, tracker)
    paths = stated if recalled is None else (*stated, *recalled.seeds)
    arguments = PlanArguments.of(method, improve, every_goal, tracker.budget, given, paths, recalled)
    search = PlanSearch(
        problem, choice, given or np.random.default_rng(0), tracker, on_incumbent, given=paths
    )
    if one_of("every_goal", every_goal, bool):
        result = _every_goal(search, given)
    else:
        result = _by_deadline(
            _planner(problem)(search), problem, search, decided=method is not None or improve
        )
    if experience is not None and recalled is not None:
        experience.learn(problem, result, recalled, len(stated))
    return replace(result, arguments=arguments)


def _recalled(problem: Problem, experience: Experience | None, tracker: BudgetTracker) -> Recalled | None:
    if experience is None:
        return None
    one_of("experience", experience, Experience)
    with tracker.stage("seed"):
        return experience.recall(problem)


def _every_goal(search: PlanSearch, given: np.random.Generator | None) -> Result:
    each = EveryGoal(search.problem, search.choice, given, search.tracker, search.on_incumbent)
    return each.planned(lambda one: _planner(one.problem)(replace(one, given=search.given)))


def _by_deadline(result: Result, problem: Problem, search: PlanSearch, *, decided: bool) -> Result:
    missed = result.status is Status.TOO_LATE and result.certainty is Certainty.EVIDENCE
    if not missed or result.stopped is not None or decided or problem.starts_moving:
        return result
    choice = choose(problem, None, improve=True)
    best = BestMotion(result)
    shorter = _planner(problem)(search.again(problem, choice=choice, on_incumbent=search.on_incumbent))
    if shorter.verified or shorter.status is Status.TOO_LATE:
        best.learn(shorter)
    return best.result


def _planner(problem: Problem) -> Callable[[PlanSearch], Result]:
    return planned_among_obstacles if problem.scene.changing else PlanSearch.run


def bounded(budget: Budget, seconds: float | None) -> Budget:
    one_of("budget", budget, Budget)
    if seconds is None:
        return budget
    if budget.seconds is not None:
        raise ProblemError("give seconds once: to plan, or to its budget")
    return replace(budget, seconds=seconds)


@dataclass(eq=False)
class EveryGoal:
    """One call of planning that keeps the result of every goal."""

    problem: Problem
    choice: Choice
    rng: np.random.Generator | None
    tracker: BudgetTracker
    on_incumbent: Callable[[Result], None] | None = None
    results: dict[str, Result] = field(default_factory=dict[str, Result])

    def __post_init__(self) -> None:
        if not self.problem.alternatives:
            raise ProblemError("every_goal compares the goals of a set: make one with any_of({name: goal})")

    def planned(self, run: Callable[[PlanSearch], Result]) -> Result:
        """Plan to each goal; return the fastest motion with the results of all.

        Each goal gets an equal part of the remaining seconds and work; attempts hold for each goal.
        """
        goals, interrupted = self.problem.alternatives, False
        for number, (name, alone) in enumerate(goals.items()):
            try:
                if interrupted:
                    raise Stopped(Stop.CANCEL)
                result = self._of(name, alone, len(goals) - number, run)
            except Stopped as ended:
                result = self._unplanned(alone, ended.stop)
            except KeyboardInterrupt:
                if not any(found.verified for found in self.results.values()):
                    raise
                result = self._unplanned(alone, Stop.CANCEL)
            interrupted = result.stopped is Stop.CANCEL
            self.results[name] = replace(result, goal_name=name)
        best_first = dict(sorted(self.results.items(), key=lambda item: item[1].cost))
        found = next(iter(best_first.values()))
        if not found.verified:
            found = failure_of_all(self.problem, found, best_first)
        return replace(found, of_each_goal=best_first).counted(self.tracker)

    def _of(self, name: str, alone: Problem, left: int, run: Callable[[PlanSearch], Result]) -> Result:
        rng = np.random.default_rng(0) if self.rng is None else self.rng.spawn(1)[0]
        part = BudgetTracker(
            shared(self.tracker.remaining(), left), self.tracker.cancel, self.tracker.progress
        )
        result = run(PlanSearch(alone, self.choice, rng, part, self._better(name)))
        self.tracker.add(part.counts, part.seconds)
        return result

    def _unplanned(self, alone: Problem, stop: Stop) -> Result:
        workspace = PlanningWorkspace(alone, self.tracker)
        return workspace.result(ENDED[stop], "nothing was attempted", stopped=stop)

    def _better(self, name: str) -> Callable[[Result], None] | None:
        told = self.on_incumbent
        if told is None:
            return None
        best = min((result.cost for result in self.results.values()), default=inf)
        return lambda found: told(replace(found, goal_name=name)) if found.cost < best else None


def shared(budget: Budget, parts: int) -> Budget:
    seconds, work = budget.seconds, budget.work
    return replace(
        budget,
        seconds=None if seconds is None else seconds / parts,
        work=None if work is None else max(1, work // parts),
    )
