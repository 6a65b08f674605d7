"""Planning to one goal: its branches, and the candidates of each round."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, islice, zip_longest

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.optimise.kinematics.inverse import SAME
from trajopt.optimise.methods import Choice, Method, Program
from trajopt.optimise.solvers import Effort, SolverStatus
from trajopt.optimise.terms import Acceleration, Clearance, Jerk, Velocity
from trajopt.optimise.transcription import fixed_goal
from trajopt.planning.attempt import plan_once
from trajopt.planning.endpoints import EndpointChecks
from trajopt.planning.result import Result
from trajopt.planning.schedule import NEAREST, SOURCES, Round, Row
from trajopt.planning.seeds import (
    Blocked,
    Bumps,
    GivenPaths,
    GivenSeed,
    MakeSeed,
    NoSeed,
    SeedContext,
    SeedKind,
    SeedSource,
    StraightLines,
    WaypointLine,
    least_steps,
    line_through,
    with_knots,
)
from trajopt.planning.status import Certainty, Status
from trajopt.planning.workspace import PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import joint_positions
from trajopt.problem.stated import MOST_KNOTS
from trajopt.values.arrays import Floats, Value


@dataclass(eq=False)
class GoalBranch(Value):
    """One possible end of a motion.

    Attributes:
        asked: The problem, whatever its goal.
        end: The end, shape (n,) [rad | m]; None if it is free to change, or already the goal.
    """

    kind: SeedKind
    asked: Problem
    line: WaypointLine
    method: Method
    end: Floats | None = None
    blocked: tuple[Blocked, ...] = ()

    @cached_property
    def problem(self) -> Problem:
        """The problem with this end as its goal."""
        if self.end is None:
            return self.asked
        goal = dict(zip(self.asked.reduced.joint_names, self.end.tolist(), strict=True))
        return replace(self.asked, goal=joint_positions(goal))

    @cached_property
    def program(self) -> Program:
        """The transcribed problem; owns a query, so one in each thread."""
        return self.method.program(self.problem, self.line.knots, self.line.places)

    @cached_property
    def context(self) -> SeedContext:
        return SeedContext(self.problem, self.line, self.program.scale)


def branches(problem: Problem, stops: Sequence[Sequence[Floats]], method: Method) -> Iterator[GoalBranch]:
    """Yield the possible ends of a motion, nearest first.

    Searched goal configurations are fixed first; then the nearest is free to change.

    Args:
        stops: For each goal configuration, nearest first: the waypoints' configurations, and itself.
    """
    reduced, pinned = problem.reduced, fixed_goal(problem)
    chosen, least = pinned is None and _end_is_free(problem), least_steps(problem)
    for number, way in enumerate(stops):
        kind = SeedKind.BRANCH if number else SeedKind.STRAIGHT
        line = line_through(reduced, (reduced.start_positions, *way), problem.knots, least)
        there = pinned is None or np.array_equal(way[-1], pinned)
        yield GoalBranch(kind, problem, line, method, None if there and not chosen else way[-1])
        if chosen and number == min(NEAREST, len(stops)) - 1:
            nearest = line_through(reduced, (reduced.start_positions, *stops[0]), problem.knots, least)
            yield GoalBranch(SeedKind.FREE_END, problem, nearest, method)


def _end_is_free(problem: Problem) -> bool:
    known = (Velocity, Acceleration, Jerk)
    return not problem.residual_constraints and all(
        isinstance(cost.residual, known) for cost in problem.costs or ()
    )


BRANCHES = 12
"""Most goal configurations to plan to."""
ALIKE = 8
"""The nearest of these; the others differ most from those: the nearest may all be on the wrong side."""


def several(goals: Sequence[Floats], velocity: Floats) -> list[Floats]:
    """Return some of many goal configurations, in their order.

    Args:
        goals: Nearest first, shape (n,) each [rad | m].
        velocity: Limits that make distances of joints comparable, shape (n,) [rad/s | m/s].
    """
    every = np.array(goals) / velocity
    chosen = list(range(min(ALIKE, len(goals))))
    apart = np.full(len(goals), np.inf)
    for place in chosen:
        apart = np.minimum(apart, np.abs(every - every[place]).max(axis=1))
    while len(chosen) < min(BRANCHES, len(goals)):
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, np.abs(every - every[chosen[-1]]).max(axis=1))
    return [goals[place] for place in sorted(chosen)]


CLOSE_BEND = 0.15
"""Bends of lines around the best motion so far, in ordinary steps."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A seed to be made.

    Attributes:
        branches: Its possible branches: the end of the seed selects one.
    """

    workspace: PlanningWorkspace
    branches: tuple[GoalBranch, ...]
    kind: SeedKind
    make_seed: MakeSeed
    effort: Effort = Effort.FULL
    goal_name: str = ""

    def branch_of(self, seed: Floats) -> GoalBranch:
        return min(self.branches, key=lambda each: float(np.abs(each.line.knots[-1] - seed[-1]).max()))


def attempt(candidate: Candidate) -> Result:
    """Make a seed and plan from it."""
    work, counts = candidate.workspace, WorkCounts()
    try:
        with work.tracker.stage("seed"):
            seed = candidate.make_seed(counts, lambda: work.tracker.check(counts))
    except NoSeed as reason:
        return work.result(Status.NO_SEED, str(reason))
    finally:
        work.tracker.count_work(counts)
    branch = candidate.branch_of(seed)
    result = plan_once(work.problem, seed, program=branch.program, workspace=work, effort=candidate.effort)
    if result.status is Status.NOT_VERIFIED:
        result = _finer(result, branch, work)
    if work.tracker.budget.improve and not work.problem.starts_moving:
        plain = work.judged_as_it_is(seed)
        if plain is not None and plain.cost < result.cost:
            return plain
    return result


def _finer(refused: Result, branch: GoalBranch, work: PlanningWorkspace) -> Result:
    """Plan from a path with a knot more in each step: what the judge refuses happens between the knots."""
    problem = work.problem
    if refused.path is None or problem.starts_moving or problem.scene.changing:
        return refused
    seed = refused.path.knots
    knots = 2 * len(seed) - 1
    if knots > MOST_KNOTS:
        return refused
    fine = np.insert(seed, np.arange(1, len(seed)), (seed[:-1] + seed[1:]) / 2.0, axis=0)
    places = tuple(2 * place for place in branch.line.places)
    program = branch.method.program(replace(branch.problem, knots=knots), fine, places)
    result = plan_once(problem, fine, program=program, workspace=work)
    return result if result.verified else refused


@dataclass(eq=False)
class GoalSearch:
    """Seeds of one problem with one goal.

    Attributes:
        nearest: The failure that came nearest, if any attempt has failed.
    """

    workspace: PlanningWorkspace
    choice: Choice
    rng: np.random.Generator
    goal_name: str = ""
    given: tuple[Floats, ...] = ()
    nearest: Result | None = None
    _waypoints: Sequence[Floats] = ()
    _branches: list[GoalBranch] = field(default_factory=list[GoalBranch])
    _running: dict[SeedKind, Iterator[Candidate]] = field(default_factory=dict[SeedKind, Iterator[Candidate]])
    _seen: list[tuple[float, Candidate]] = field(default_factory=list[tuple[float, Candidate]])

    def prepare(self) -> Result | None:
        """Check the start and choose goal configurations; return why that is impossible, if it is."""
        work = self.workspace
        objection = self.choice.objection(work.problem)
        if objection:
            return work.result(Status.METHOD_CANNOT, objection, certainty=Certainty.PROVEN)
        ends = EndpointChecks(work)
        with work.tracker.stage("examine"):
            refusal = ends.start()
        if refusal is not None:
            return refusal
        with work.tracker.stage("seed"):
            goals = ends.goals(self.rng)
            if isinstance(goals, Result):
                return goals
            waypoints = ends.waypoints(self.rng)
            if isinstance(waypoints, Result):
                return waypoints
            chosen = several(goals, work.problem.limits.velocity)
            self._waypoints = waypoints
            stops = [(*waypoints, goal) for goal in chosen]
            self._branches = list(branches(work.problem, stops, self.choice.method))
        return None

    def widen(self) -> None:
        """Search more goal configurations, since no path was found to the others."""
        work = self.workspace
        with work.tracker.stage("seed"):
            ends = [branch.line.knots[-1] for branch in self._branches]
            new = [
                goal
                for goal in EndpointChecks(work).more_goals(self.rng)
                if min(float(np.abs(goal - end).max()) for end in ends) > SAME
            ]
            for goal in several(new, work.problem.limits.velocity) if new else ():
                way = (work.problem.reduced.start_positions, *self._waypoints, goal)
                line = line_through(work.problem.reduced, way, work.problem.knots, least_steps(work.problem))
                branch = GoalBranch(SeedKind.BRANCH, work.problem, line, self.choice.method, goal)
                self._branches.append(branch)
            if new:
                self._running.pop(SeedKind.SAMPLED, None)

    @property
    def travel(self) -> float:
        reduced = self.workspace.problem.reduced
        away = [np.abs(branch.line.knots[-1] - reduced.start_positions) for branch in self._branches]
        return min(float((each / reduced.limits.velocity).max()) for each in away)

    @property
    def late(self) -> bool:
        """Whether a motion was found that only misses the deadline."""
        return self.nearest is not None and self.nearest.status is Status.TOO_LATE

    def candidates(self, rows: Round, incumbent: Result | None = None) -> list[Candidate]:
        """Return the candidates of a round.

        Args:
            incumbent: The best motion, if one was found and a better one is wanted.
        """
        in_turn = zip_longest(*(self._of(row, incumbent) for row in rows))
        return [item for one_of_each in in_turn for item in one_of_each if item is not None]

    def learn(self, candidate: Candidate, result: Result) -> None:
        if candidate.kind is candidate.branches[0].kind:
            candidate.branches[0].blocked = _blocked(result)
        if result.verified:
            return
        if _unfinished(candidate, result) and result.path is not None:
            seed = GivenSeed(with_knots(result.path.knots, result.problem.knots))
            again = replace(candidate, make_seed=seed, effort=Effort.FULL)
            self._seen.append((_rank(result), again))
        if self.nearest is None or _rank(result) < _rank(self.nearest):
            self.nearest = result

    def _of(self, row: Row, incumbent: Result | None) -> Sequence[Candidate]:
        if row.source is None:
            nearest_first = sorted(self._seen, key=lambda seen: seen[0])
            self._seen.clear()
            return [candidate for _, candidate in nearest_first[: row.count]]
        if row.source is SeedKind.STRAIGHT:
            straight = (
                self._from(StraightLines(each.kind), each) for each in self._branches[slice(*row.branches)]
            )
            return [replace(item, effort=row.effort) for item in chain.from_iterable(straight)]
        if row.bends_best and incumbent is not None and incumbent.path is not None:
            return self._close_to(with_knots(incumbent.path.knots, incumbent.problem.knots), row)
        if row.source not in self._running:
            to = self._branches[slice(*row.branches)]
            given = row.source is SeedKind.GIVEN
            source = GivenPaths(self.given) if given else SOURCES[row.source]
            # With waypoints each branch has knots of its own for them.
            any_will_do = row.to_any and not self.workspace.problem.waypoints
            self._running[row.source] = self._to_any(source, to) if any_will_do else self._in_turn(source, to)
        return [replace(item, effort=row.effort) for item in islice(self._running[row.source], row.count)]

    def _close_to(self, knots: Floats, row: Row) -> list[Candidate]:
        ending_there = [each for each in self._branches if np.array_equal(each.line.knots[-1], knots[-1])]
        free = [each for each in self._branches if each.kind is SeedKind.FREE_END]
        branch = [*ending_there, *free, *self._branches][0]
        context = replace(branch.context, line=replace(branch.line, knots=knots))
        seeds = Bumps(CLOSE_BEND).seeds(context, (), self.rng)
        return [self._candidate((branch,), SeedKind.BUMP, make) for make in islice(seeds, row.count)]

    def _in_turn(self, source: SeedSource, to: Sequence[GoalBranch]) -> Iterator[Candidate]:
        running = [self._from(source, branch) for branch in to]
        for one_of_each in zip_longest(*running):
            yield from (item for item in one_of_each if item is not None)

    def _to_any(self, source: SeedSource, to: Sequence[GoalBranch]) -> Iterator[Candidate]:
        first, *others = to
        ends = tuple(each.line.knots[-1] for each in others if each.kind is not SeedKind.FREE_END)
        context = replace(first.context, other_ends=ends)
        for make in source.seeds(context, first.blocked, self.rng):
            yield self._candidate(to, source.kind, make)

    def _from(self, source: SeedSource, branch: GoalBranch) -> Iterator[Candidate]:
        for make in source.seeds(branch.context, branch.blocked, self.rng):
            yield self._candidate((branch,), source.kind, make)

    def _candidate(self, branches: Sequence[GoalBranch], kind: SeedKind, make: MakeSeed) -> Candidate:
        return Candidate(self.workspace, tuple(branches), kind, make, goal_name=self.goal_name)


def _unfinished(candidate: Candidate, result: Result) -> bool:
    given_up = result.solve is not None and result.solve.status is SolverStatus.GIVEN_UP
    return given_up or candidate.effort is Effort.BRIEF


def _rank(result: Result) -> float:
    if result.status is Status.TOO_LATE and result.trajectory is not None:
        return -1.0 / result.trajectory.duration
    return np.inf if result.solve is None else result.solve.at.violation


def _blocked(result: Result) -> tuple[Blocked, ...]:
    solved = result.solve
    if solved is None or solved.feasible:
        return ()
    worst = max(solved.at.constraints, key=lambda block: block.worst / block.tolerance)
    if worst.kind is not Clearance:
        return ()
    row = int(np.argmax(worst.violation))
    # A program that decides on time too has a column of that after those of the joints.
    knots = solved.x[:, : len(result.problem.reduced.joint_names)]
    return (Blocked(knots, float(worst.rows.place[row]), int(worst.rows.component[row])),)
