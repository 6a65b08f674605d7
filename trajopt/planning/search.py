"""Search: state of one call of planning, with its attempts and best motion."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from threading import Event
from typing import TypeVar

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.optimise.methods import Choice
from trajopt.optimise.solvers import Effort
from trajopt.optimise.transcription.margins import shrinkable
from trajopt.planning.budget import BudgetTracker, Stop, Stopped
from trajopt.planning.goal_search import Candidate, GoalSearch, attempt
from trajopt.planning.infeasibility import ClosedCut, closed_cut, joints_between, met_braking, never_apart
from trajopt.planning.infeasibility.reasons import enclosed, margin_out_of_reach, worst_on_the_way
from trajopt.planning.result import Attempt, Result
from trajopt.planning.schedule import OPENING, rounds
from trajopt.planning.status import Certainty, Status
from trajopt.planning.workspace import PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import JointPositions
from trajopt.robot.joints import joint_unit
from trajopt.scene.clearances import PairKind, Part
from trajopt.scene.scene import DEFAULT_MARGIN, Scene
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_degrees

BEFORE_PROOF = 2
"""After this many failed rounds, planning looks for a proof that there is no path at all."""
MARGINS_MAY_HELP = (Status.STUCK, Status.NOT_VERIFIED)
"""Failures that smaller margins may prevent."""
FEW_JOINTS = 2
"""Links with at most so many joints between them are almost next to each other."""
ENDED = {
    Stop.CLOCK: Status.OUT_OF_TIME,
    Stop.WORK: Status.OUT_OF_WORK,
    Stop.CANCEL: Status.CANCELLED,
}
"""How planning ends without a motion when it is stopped."""


@dataclass(eq=False)
class PlanSearch:
    """One call of planning.

    Attributes:
        given: Knots of the paths tried first, shape (k, n) each.
    """

    problem: Problem
    choice: Choice
    rng: np.random.Generator
    tracker: BudgetTracker
    on_incumbent: Callable[[Result], None] | None = None
    remarks: tuple[str, ...] = ()
    given: tuple[Floats, ...] = ()
    most: int | None = None
    incumbent: Result | None = None
    attempts: list[Attempt] = field(default_factory=list[Attempt])
    _refusals: dict[str, Result] = field(default_factory=dict[str, Result])
    _rounds: int = 0
    _narrow: str = "no motion was found that keeps the requested margins"

    def run(self) -> Result:
        """Attempt seeds until the search is done or stopped.

        Raises:
            KeyboardInterrupt: If interrupted before there is a motion.
        """
        stopped: Stop | None = None
        try:
            for candidates in self.rounds():
                parallel = self.in_threads(candidates)
                results = (
                    attempted_in_threads(candidates, self.tracker) if parallel else map(attempt, candidates)
                )
                for candidate, result in zip(candidates, results, strict=True):
                    self.learn(candidate, result)
                    if self.done:
                        break
        except Stopped as ended:
            stopped = ended.stop
        except KeyboardInterrupt:
            if self.incumbent is None:
                raise
            stopped = Stop.CANCEL
        return self.result(stopped)

    def again(
        self,
        problem: Problem,
        *,
        choice: Choice | None = None,
        most: int | None = None,
        on_incumbent: Callable[[Result], None] | None = None,
    ) -> "PlanSearch":
        chosen = choice or self.choice
        return PlanSearch(problem, chosen, self.rng, self.tracker, on_incumbent, given=self.given, most=most)

    @cached_property
    def goals(self) -> tuple[GoalSearch, ...]:
        asked = self.problem.alternatives or {"": self.problem}
        return tuple(
            GoalSearch(PlanningWorkspace(problem, self.tracker), self.choice, self.rng, name, self.given)
            for name, problem in asked.items()
        )

    def rounds(self) -> Iterator[list[Candidate]]:
        """Yield the candidates of each round, goals nearest first, until nothing is left to try."""
        turns = long_turns(self.problem)
        self.problem, margins = with_possible_margins(self.problem, self.tracker)
        self.remarks = (*turns, *margins)
        for problem, words, last in with_smaller_margins(self.problem):
            yield from self._rounds_until(last + bool(self.given))
            stuck = any(goal.nearest and goal.nearest.status in MARGINS_MAY_HELP for goal in self.goals)
            if not stuck or self.incumbent is not None or self.done:
                return
            self.problem = problem
            self.remarks = (*self.remarks, f"{self._narrow}; {words}")
            del self.goals
        yield from self._rounds_until(None)

    def _rounds_until(self, last: int | None) -> Iterator[list[Candidate]]:
        """Yield the candidates of each round; if there is no motion, only up to the last round."""
        nearest_first = self._prepared()
        budget = self.tracker.budget
        opened = len(OPENING) + bool(self.given)
        for number, rows in enumerate(rounds(bounded=budget.bounded, given=bool(self.given))):
            if number == opened and not budget.bounded:
                # A cycle looks for ways through; a motion that is late has one.
                nearest_first = [goal for goal in nearest_first if not goal.late]
            if not nearest_first or (number == last and self.incumbent is None):
                return
            if number == opened and self.incumbent is None:
                for goal in nearest_first:
                    goal.widen()
            candidates = [item for goal in nearest_first for item in goal.candidates(rows, self._best(goal))]
            left = None if self._most is None else self._most - len(self.attempts)
            self._rounds += 1
            if left is not None and len(candidates) >= left:
                candidates = [*candidates[: left - 1], replace(candidates[left - 1], effort=Effort.FULL)]
            yield candidates
            if self.done:
                return
            excluded = {1: self._met_braking, BEFORE_PROOF: self._walled_in}.get(number + 1)
            if excluded is not None and self.incumbent is None and number + 1 != last:
                nearest_first = [goal for goal in nearest_first if not excluded(goal)]

    def _prepared(self) -> list[GoalSearch]:
        for goal in self.goals:
            refusal = self._refusals.get(goal.goal_name) or goal.prepare()
            if refusal is not None:
                self._refusals[goal.goal_name] = refusal
        open_ones = [goal for goal in self.goals if goal.goal_name not in self._refusals]
        return sorted(open_ones, key=lambda goal: goal.travel)

    def in_threads(self, candidates: Sequence[Candidate]) -> bool:
        return self._rounds > 1 and min(self.tracker.budget.workers, len(candidates)) > 1

    @property
    def _most(self) -> int | None:
        bounds = [bound for bound in (self.most, self.tracker.budget.attempts) if bound is not None]
        return min(bounds, default=None)

    @property
    def done(self) -> bool:
        budget = self.tracker.budget
        found = self.incumbent is not None and not budget.improve
        return found or (self._most is not None and len(self.attempts) >= self._most)

    def learn(self, candidate: Candidate, result: Result) -> None:
        """Take the outcome of a candidate into account for the next ones."""
        next(goal for goal in self.goals if goal.goal_name == candidate.goal_name).learn(candidate, result)
        solved = result.solve
        block = None if solved is None or result.verified else worst_on_the_way(result.problem, solved)
        attempted = Attempt(
            number=len(self.attempts) + 1,
            kind=candidate.kind,
            status=result.status,
            solver=None if solved is None else solved.status,
            message=result.message,
            iterations=0 if solved is None else len(solved.log),
            block=block,
            goal_name=candidate.goal_name,
        )
        self.attempts.append(attempted)
        if result.cost < (float("inf") if self.incumbent is None else self.incumbent.cost):
            self.incumbent = replace(result, won=attempted, goal_name=candidate.goal_name)
            if self.on_incumbent is not None:
                self.on_incumbent(self._complete(self.incumbent))

    def result(self, stopped: Stop | None) -> Result:
        found = self.incumbent or self._failure(stopped)
        return self._complete(replace(found, stopped=stopped or found.stopped))

    def _best(self, goal: GoalSearch) -> Result | None:
        best = self.incumbent
        return best if best is not None and best.goal_name == goal.goal_name else None

    def _met_braking(self, goal: GoalSearch) -> bool:
        failed = goal.nearest
        if failed is None or not self.problem.starts_moving:
            return False
        counts = WorkCounts()
        with self.tracker.stage("proof"):
            met = met_braking(goal.workspace.problem, counts)
        self.tracker.count_work(counts)
        if met is not None:
            certainty = Certainty.PROVEN if met.boxes else Certainty.EVIDENCE
            goal.nearest = replace(
                failed, status=Status.START_TOO_FAST, message=met.words, certainty=certainty
            )
        return met is not None

    def _walled_in(self, goal: GoalSearch) -> bool:
        stuck = goal.nearest
        if stuck is None or stuck.status is not Status.STUCK:
            return False
        with self.tracker.stage("proof"):
            cut = closed_cut(goal.workspace.problem)
        if cut is not None:
            message = enclosed(stuck.problem, cut)
            proven, status = Certainty.PROVEN, Status.PROVEN_INFEASIBLE
            goal.nearest = replace(stuck, status=status, message=message, certainty=proven)
            return True
        with self.tracker.stage("proof"):
            narrow = margin_cut(goal.workspace.problem)
        if narrow is not None:
            self._narrow = margin_out_of_reach(stuck.problem, narrow)
            goal.nearest = replace(stuck, message=f"{stuck.message}; {self._narrow}")
        return narrow is not None

    def _failure(self, stopped: Stop | None) -> Result:
        failures = {goal.goal_name: self._refusals.get(goal.goal_name) or goal.nearest for goal in self.goals}
        known = {name: failure for name, failure in failures.items() if failure is not None}
        attempted = [goal for goal in self.goals if goal.nearest is not None]
        if attempted:
            first = known[min(attempted, key=lambda goal: goal.travel).goal_name]
        elif known:
            first = next(iter(known.values()))
        else:
            first = self.goals[0].workspace.result(Status.CANCELLED, "nothing was attempted")
        if self.problem.starts_moving and first.status in (Status.STUCK, Status.NOT_VERIFIED):
            first = replace(first, message=f"{first.message}; the start is in motion: a slower one may do")
        if self.problem.alternatives:
            first = failure_of_all(self.problem, first, known)
        if stopped is None:
            return first
        message = first.message if self.problem.alternatives or not known else f"so far: {first.reason}"
        return replace(first, status=ENDED[stopped], message=message, certainty=Certainty.EVIDENCE)

    def _complete(self, result: Result) -> Result:
        return replace(
            result.counted(self.tracker),
            attempts=tuple(self.attempts),
            method=self.choice.method.name,
            because=self.choice.because,
            remarks=(*self.remarks, *result.remarks),
        )


def failure_of_all(problem: Problem, first: Result, known: Mapping[str, Result]) -> Result:
    """Return the failure of a goal set, proven only if every goal's failure is; `first` is reported first."""
    certainties = {failure.certainty for failure in known.values()}
    proven = len(known) == len(problem.alternatives) and certainties == {Certainty.PROVEN}
    nearest_first = sorted(known, key=lambda name: known[name] is not first)
    return replace(
        first,
        problem=problem,
        message="; ".join(f"{name}: {failure.reason}" for name, failure in known.items()),
        alternatives={name: known[name] for name in nearest_first},
        certainty=Certainty.PROVEN if proven else Certainty.EVIDENCE,
    )


POLL = 0.005
"""Interval of budget checks while waiting [s]."""


def attempted_in_threads(candidates: Sequence[Candidate], tracker: BudgetTracker) -> Iterator[Result]:
    """Attempt candidates; yield their results in the order given, their work added to the tracker.

    Ending the iteration ends the attempts. The budget limits the number of workers.
    """
    from concurrent.futures import ThreadPoolExecutor, wait

    over, so_far = Event(), tracker.so_far

    def alone(candidate: Candidate) -> Result:
        mine = BudgetTracker.elsewhere(tracker.budget, so_far, over)
        work = PlanningWorkspace(candidate.workspace.problem, mine)
        branches = tuple(copy(branch) for branch in candidate.branches)
        return attempt(replace(candidate, workspace=work, branches=branches))

    pool = ThreadPoolExecutor(min(tracker.budget.workers, len(candidates)), "trajopt")
    try:
        for running in [pool.submit(alone, candidate) for candidate in candidates]:
            while not running.done():
                tracker.check()
                wait((running,), POLL)
            result = running.result()
            tracker.add(result.counts, result.cpu_seconds)
            tracker.check()
            yield result
    finally:
        over.set()
        pool.shutdown(cancel_futures=True)


MIDDLE = (0.5, 0.25, 0.75)
"""Shares of the way from start to goal at which joints are cut: nearer to the ends a margin may be
reduced.
"""


def with_possible_margins(problem: Problem, tracker: BudgetTracker) -> tuple[Problem, tuple[str, ...]]:
    """Return the problem with the default margin for pairs that cannot keep the requested one.

    A pair cannot if it is proven to be nearer in every configuration, or consists of two links that are
    nearer at the start and almost next to each other.
    Returns the problem itself if there are none, and a sentence on each pair.
    """
    reduced = problem.reduced
    pairs, asked_for = reduced.pairs, ~shrinkable(reduced.pairs)
    if not asked_for.any():
        return problem, ()
    counts, asked, words, scene = WorkCounts(), dict[tuple[str, str], float](), list[str](), problem.scene
    with tracker.stage("examine"):
        near = problem.evaluator(reduced, counts).close_pairs(
            reduced.start_positions[None], np.where(asked_for, pairs.margin, -np.inf)
        )
        for pair in sorted(near.pair.tolist()):
            first, second = reduced.owners(pair)
            if of_robot(scene, first, second) and joints_between(reduced, [pair]).sum() <= FEW_JOINTS:
                scene = scene.with_margin(DEFAULT_MARGIN, first, second)
                words.append(
                    f"{1000 * pairs.margin[pair]:g} mm of margin are asked of {first} and {second}, which "
                    "are nearer at the start"
                )
            else:
                asked[first, second] = float(pairs.margin[pair])
        for item in never_apart(reduced, asked, counts):
            scene = scene.with_margin(min(DEFAULT_MARGIN, item.distance), item.first, item.second)
            words.append(item.words("of margin are asked of"))
    tracker.count_work(counts)
    remarks = tuple(f"{each}: they have the default margin" for each in dict.fromkeys(words))
    return (replace(problem, scene=scene), remarks) if remarks else (problem, ())


def of_robot(scene: Scene, first: str, second: str) -> bool:
    return scene.part(first) is scene.part(second) is Part.LINK


def with_smaller_margins(problem: Problem) -> Iterator[tuple[Problem, str, int]]:
    """Yield the problem with the default margin between links, then between all, if a larger one is asked.

    With the words for it, and the number of rounds in which planning first tries to do without.
    """
    scene, reduced = problem.scene, problem.reduced
    asked = {reduced.owners(pair) for pair in np.flatnonzero(~shrinkable(reduced.pairs)).tolist()}
    links = {name for name in chain.from_iterable(asked) if scene.part(name) is Part.LINK}
    apart = [links.issuperset(pair) for pair in asked]
    if any(apart):
        single = {pair: m for pair, m in scene.pair_margins.items() if of_robot(scene, *pair)}
        own = {PairKind.ROBOT: scene.kind_margins.get(PairKind.ROBOT, scene.margin)}
        scene = replace(
            scene,
            pair_margins={**scene.pair_margins, **_at_most_default(single)},
            kind_margins={**scene.kind_margins, **_at_most_default(own)},
        )
        words = "links have the default margin from each other"
        yield replace(problem, scene=scene), words, BEFORE_PROOF
    if not all(apart):
        scene = replace(
            scene,
            margin=min(scene.margin, DEFAULT_MARGIN),
            pair_margins=_at_most_default(scene.pair_margins),
            kind_margins=_at_most_default(scene.kind_margins),
        )
        words = "requested margins give way to the default margin"
        yield replace(problem, scene=scene), words, len(OPENING)


T = TypeVar("T")


def _at_most_default(margins: Mapping[T, float]) -> dict[T, float]:
    return {each: min(margin, DEFAULT_MARGIN) for each, margin in margins.items()}


def margin_cut(problem: Problem) -> ClosedCut | None:
    pairs = problem.reduced.pairs
    asked_for = ~shrinkable(pairs)
    if not asked_for.any():
        return None
    return closed_cut(problem, apart=np.where(asked_for, pairs.margin, -np.inf), shares=MIDDLE)


TURN = 2.0 * np.pi


def long_turns(problem: Problem) -> tuple[str, ...]:
    """Return a sentence on each joint without limits whose goal is more than half a turn away.

    Turns may be intended, as when a cable is unwound.
    """
    found: dict[str, None] = {}
    start, turning = _turning(problem)
    for one in problem.alternatives.values() or (problem,):
        for goal in one.goals:
            if not isinstance(goal, JointPositions):
                continue
            for joint in turning.intersection(goal.positions):
                way = goal.positions[joint] - start[joint]
                slack = goal.above[joint] if way < 0.0 else goal.below[joint]
                if abs(way) - slack > np.pi:
                    near = goal.positions[joint] - TURN * round(way / TURN)
                    found[
                        f"{joint} is asked to turn by {in_degrees(abs(way))}: {near:.4g} rad is the same "
                        f"angle, {in_degrees(abs(near - start[joint]))} away"
                    ] = None
    return tuple(sorted(found))


def _turning(problem: Problem) -> tuple[dict[str, float], set[str]]:
    reduced = problem.reduced
    free = np.isinf(reduced.limits.lower) & np.isinf(reduced.limits.upper)
    return (
        dict(zip(reduced.joint_names, reduced.start_positions.tolist(), strict=True)),
        {
            name
            for name, without in zip(reduced.joint_names, free.tolist(), strict=True)
            if without and joint_unit(problem.scene.robot.model, name) == "rad"
        },
    )
