"""Portfolio: the first guesses of one problem, in rounds, the likeliest first.

Within a round no guess depends on what another came to: a round may be tried on any number of cores, and
in the end it is the number of a guess that decides, not who was first.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice, zip_longest

import numpy as np

from trajopt.arrays import Floats, Value
from trajopt.errors import MissingExtra
from trajopt.methods import Method, Program
from trajopt.model.requirements import joint_positions
from trajopt.planning.attempts import Attempts
from trajopt.planning.ends import Ends
from trajopt.planning.result import Result
from trajopt.planning.seeds import (
    Around,
    Blocked,
    Bumps,
    Guess,
    NoGuess,
    Ready,
    Route,
    SampledPaths,
    SeedKind,
    Source,
    StraightLines,
    WaypointLine,
    line_through,
)
from trajopt.planning.status import Certainty, Status
from trajopt.problem import Problem
from trajopt.query import Counts
from trajopt.solvers import SolveResult
from trajopt.terms import Acceleration, Clearance, Jerk, Velocity
from trajopt.transcription import fixed_goal

NEAR_BRANCHES = 3
"""Goal configurations that are planned to before lines are bent, nearest first."""
BRANCHES = 12
"""Goal configurations that are planned to at all."""
MIXED_ROUND = 6
"""Lines bent around what blocked, and as many bent at random, that are tried in turn."""
BENT_ROUND = 12
"""Bent lines that are looked at in a later round."""
PROMISING = 3
"""Of the lines looked at in a round, those that came nearest and are optimised to the end."""
SAMPLED_ROUND = 2
"""Goal configurations that the sampling planner is sent to in a round."""
CLOSE_BEND = 0.15
"""Bends of lines around the best motion so far, in ordinary steps."""


@dataclass(eq=False)
class Way(Value):
    """One end that a motion may have, and what was written for it so far.

    Attributes:
        kind: What its straight line is called.
        asked: The problem, with the goal that it is to end at.
        line: Straight legs there.
        method: Writes the program.
        blocked: Where its straight line ended against something.
    """

    kind: SeedKind
    asked: Problem
    line: WaypointLine
    method: Method
    blocked: tuple[Blocked, ...] = ()

    @cached_property
    def program(self) -> Program:
        """The program; owns a query, so one in each process."""
        return self.method.program(self.asked, self.line.knots, self.line.places)

    @cached_property
    def route(self) -> Route:
        """What sources of first guesses are told."""
        return Route(self.asked.reduced, self.line, self.program.scale, self.asked.requirements)


@dataclass(frozen=True, eq=False)
class Candidate:
    """A first guess that is yet to be made.

    Attributes:
        owner: The portfolio that it is from.
        way: Where it leads.
        kind: Its kind.
        guess: Makes it.
        briefly: Whether it is only looked at: a few steps show how promising it is.
    """

    owner: "Portfolio"
    way: Way
    kind: SeedKind
    guess: Guess
    briefly: bool = False


@dataclass(frozen=True, eq=False)
class Done:
    """What became of a candidate.

    Attributes:
        result: The motion, or why there is none.
        blocked: Where it ended against something.
    """

    result: Result
    blocked: tuple[Blocked, ...]


@dataclass(eq=False)
class Portfolio:
    """First guesses of one problem with one goal.

    Attributes:
        attempts: At the problem.
        method: Transcription and solver, with their options.
        rng: Draws starts and bends; every guess from a child of its own.
        goal_name: Of a goal set: the name of the goal.
        nearest: The failure that came nearest, if any try has failed.
    """

    attempts: Attempts
    method: Method
    rng: np.random.Generator
    goal_name: str = ""
    nearest: Result | None = None
    _ways: list[Way] = field(default_factory=list[Way])
    _bent: Iterator[Candidate] = field(default_factory=lambda: iter(()))
    _sampled: Iterator[Candidate] = field(default_factory=lambda: iter(()))
    _seen: list[tuple[float, Candidate]] = field(default_factory=list[tuple[float, Candidate]])

    def prepare(self) -> Result | None:
        """Look at the start and choose goal configurations; return why that is impossible, if it is."""
        problem, meter, ends = self.attempts.problem, self.attempts.meter, Ends(self.attempts)
        objection = self.method.objection(problem)
        if objection:
            words = f"{self.method.name}: {objection}"
            return self.attempts.result(Status.METHOD_CANNOT, words, certainty=Certainty.PROVEN)
        with meter.stage("examine"):
            refusal = ends.start()
        if refusal is not None:
            return refusal
        with meter.stage("seed"):
            goals = ends.goals(self.rng)
            if isinstance(goals, Result):
                return goals
            waypoints = ends.waypoints(self.rng)
            if isinstance(waypoints, Result):
                return waypoints
            self._ways = list(self._to([(*waypoints, goal) for goal in goals[:BRANCHES]]))
        self._bent = self._in_turn(Bumps(), self._ways[: NEAR_BRANCHES + 1])
        self._sampled = self._in_turn(SampledPaths(), self._ways[:NEAR_BRANCHES])
        return None

    @property
    def travel(self) -> float:
        """Time to the nearest goal configuration at full speed; known once prepared [s]."""
        reduced = self.attempts.problem.reduced
        away = [np.abs(way.line.knots[-1] - reduced.start_positions) for way in self._ways]
        return min(float((each / reduced.limits.velocity).max()) for each in away)

    def round(self, number: int, incumbent: Result | None = None) -> list[Candidate]:
        """Return the candidates of a round.

        Args:
            number: From 0. From 5 on lines are bent, the promising ones optimised, and the sampling planner
                called in turn, for ever; without a budget the last round is `ROUNDS - 1`.
            incumbent: The best motion so far, if one was found and a better one is looked for.
        """
        match number:
            case 0:
                return self._straight(self._ways[:1])
            case 1:
                return self._straight(self._ways[1 : NEAR_BRANCHES + 1])
            case 2:
                around = list(islice(self._in_turn(Around(), self._ways[:NEAR_BRANCHES]), MIXED_ROUND))
                bent = list(islice(self._bent, MIXED_ROUND))
                mixed = [item for pair in zip_longest(around, bent) for item in pair if item is not None]
                return [replace(item, briefly=True) for item in mixed]
            case 4:
                return self._straight(self._ways[NEAR_BRANCHES + 1 :])
            case _ if number == 3 or number % 3 == 0:
                return self._promising()
            case _ if number % 3 == 1:
                return list(islice(self._sampled, SAMPLED_ROUND))
            case _ if incumbent is not None and incumbent.path is not None:
                return self._close_to(incumbent.path.knots)
            case _:
                return [replace(item, briefly=True) for item in islice(self._bent, BENT_ROUND)]

    def learn(self, candidate: Candidate, done: Done) -> None:
        """Note what became of a candidate."""
        if candidate.kind is candidate.way.kind:
            candidate.way.blocked = done.blocked
        if candidate.briefly and not done.result.verified and done.result.path is not None:
            again = replace(candidate, guess=Ready(done.result.path.knots), briefly=False)
            self._seen.append((_rank(done.result), again))
        if not done.result.verified and (self.nearest is None or _rank(done.result) < _rank(self.nearest)):
            self.nearest = done.result

    def _to(self, goals: Sequence[Sequence[Floats]]) -> Iterator[Way]:
        """Yield the ends that a motion may have, nearest first.

        Where goal configurations were searched for, the program first gets each of them as it is, and
        only then the nearest with the freedom to choose another: that is harder to solve.
        """
        problem, reduced = self.attempts.problem, self.attempts.problem.reduced
        pinned = fixed_goal(problem)
        free = pinned is None
        chosen = free and _end_is_free(problem)
        for number, stops in enumerate(goals):
            kind = SeedKind.BRANCH if number else SeedKind.STRAIGHT
            line = line_through(reduced, (reduced.start_positions, *stops), problem.knots)
            there = free or np.array_equal(stops[-1], pinned)
            asked = problem if there and not chosen else _ending_at(problem, stops[-1])
            yield Way(kind, asked, line, self.method)
            if chosen and number == min(NEAR_BRANCHES, len(goals)) - 1:
                nearest = line_through(reduced, (reduced.start_positions, *goals[0]), problem.knots)
                yield Way(SeedKind.FREE_END, problem, nearest, self.method)

    def _promising(self) -> list[Candidate]:
        """Go on with the lines that came nearest, from where they were left."""
        nearest_first = sorted(self._seen, key=lambda seen: seen[0])
        self._seen.clear()
        return [candidate for _, candidate in nearest_first[:PROMISING]]

    def _straight(self, ways: Sequence[Way]) -> list[Candidate]:
        return [item for way in ways for item in self._from(StraightLines(way.kind), way)]

    def _close_to(self, knots: Floats) -> list[Candidate]:
        """Bend the best motion so far."""
        ending_there = [way for way in self._ways if np.array_equal(way.line.knots[-1], knots[-1])]
        free = [way for way in self._ways if way.kind is SeedKind.FREE_END]
        way = [*ending_there, *free, *self._ways][0]
        line = replace(way.line, knots=knots)
        guesses = Bumps(CLOSE_BEND).guesses(replace(way.route, line=line), (), self.rng)
        return [Candidate(self, way, SeedKind.BUMP, guess) for guess in islice(guesses, BENT_ROUND)]

    def _in_turn(self, source: Source, ways: Sequence[Way]) -> Iterator[Candidate]:
        """Yield candidates of one source to several ends in turn, until none has more."""
        running = [self._from(source, way) for way in ways]
        for round_of_them in zip_longest(*running):
            yield from (item for item in round_of_them if item is not None)

    def _from(self, source: Source, way: Way) -> Iterator[Candidate]:
        for guess in source.guesses(way.route, way.blocked, self.rng):
            yield Candidate(self, way, source.kind, guess)


def tried(attempts: Attempts, way: Way, guess: Guess, briefly: bool) -> Done:
    """Make a first guess; optimise, time and judge it.

    Args:
        attempts: At the problem.
        way: Where it leads.
        guess: Makes it.
        briefly: Whether it is only looked at.

    Raises:
        Stopped: If the budget ends before.
    """
    counts = Counts()
    try:
        with attempts.meter.stage("seed"):
            seed = guess(counts, lambda: attempts.meter.check(counts))
    except (NoGuess, MissingExtra) as reason:
        return Done(attempts.result(Status.NO_FIRST_GUESS, str(reason)), ())
    finally:
        attempts.meter.count_work(counts)
    result = attempts.optimised(way.program, seed, briefly=briefly)
    if attempts.meter.budget.improve:
        plain = attempts.as_it_is(seed)
        if plain is not None and plain.cost < result.cost:
            result = plain
    blocked = () if result.solve is None or result.solve.feasible else _blocked(result.solve)
    return Done(result, blocked)


ROUNDS = 14
"""Rounds that are tried where no budget says how many."""


def _end_is_free(problem: Problem) -> bool:
    """Whether any configuration that holds the goals will do: nothing but the program knows of more."""
    known = (Velocity, Acceleration, Jerk)
    return not problem.own_constraints and all(
        isinstance(cost.residual, known) for cost in problem.costs or ()
    )


def _ending_at(problem: Problem, positions: Floats) -> Problem:
    """Return the problem with a configuration of the group as its goal."""
    goal = joint_positions(dict(zip(problem.reduced.joint_names, positions.tolist(), strict=True)))
    return replace(problem, goal=goal)


def _rank(result: Result) -> float:
    """Order failures by how near they came: by what they violate."""
    return np.inf if result.solve is None else result.solve.at.violation


def _blocked(solved: SolveResult) -> tuple[Blocked, ...]:
    """Return where the worst pair undercuts its clearance most, if that is what is worst of all."""
    worst = max(solved.at.constraints, key=lambda block: block.worst / block.tolerance)
    if worst.kind is not Clearance:
        return ()
    row = int(np.argmax(worst.violation))
    return (Blocked(solved.x, float(worst.rows.place[row]), int(worst.rows.component[row])),)
