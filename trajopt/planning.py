"""Planning of one problem: seeds, transcription, solver, retiming, judge. The only place where all meet.

Everything it does can be done by hand, one arrow at a time; this is the sequence a reader would have
typed.
"""

import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import cycle, islice

import numpy as np

from trajopt import reasons
from trajopt.arrays import Floats
from trajopt.judgement import judge
from trajopt.methods import Method, Outcome, Program
from trajopt.model.requirements import joint_positions
from trajopt.problem import Problem
from trajopt.proofs import closed_cut
from trajopt.query import Counts, query_of
from trajopt.result import Result, Status
from trajopt.retime import Retimed, RetimeFailure
from trajopt.seeds import SeedKind, bumps, choose_waypoints, conflicting, goal_candidates, line_through
from trajopt.solvers import Iteration
from trajopt.terms import Acceleration, Jerk, Velocity, constrain
from trajopt.terms.motion import Motion
from trajopt.terms.residual import WHOLE
from trajopt.timing import timed as time_path
from trajopt.trajectory import Trajectory
from trajopt.transcription import fixed_goal
from trajopt.tries import Try
from trajopt.verify import Certificate, Examination, Judge, Moment

PATH_TOLERANCES = (5e-3, 1e-3)
"""How far the timed motion may leave the checked path, and again if the judge refuses it [m]."""
WAYPOINT_TOLERANCE = 1e-4
"""The same, a third time, for problems with waypoints: they may be at corners of the path [m]."""
GOALS_TRIED = 3
"""Goal configurations that are planned to, nearest first."""
ATTEMPTS = 48
"""First guesses that are tried before giving up."""

BEFORE_PROOF = 4
"""First guesses that fail before a proof is looked for that there is no way at all."""

Progress = Callable[[str, Iteration | None], None]
"""Called with the stage, and with the solver's step while it works."""


@dataclass(eq=False)
class Planning:
    """Planning of one problem: what it has done so far.

    Attributes:
        problem: The problem, with one goal.
        method: Transcription and solver, with their options.
        rng: Draws starts and bends.
        progress: Called at every stage and step.
        counts: Exact numbers of the work.
        seconds: Process time of each stage [s].
        tries: What each first guess came to.
    """

    problem: Problem
    method: Method
    rng: np.random.Generator
    progress: Progress | None
    counts: dict[str, int] = field(default_factory=dict[str, int])
    seconds: dict[str, float] = field(default_factory=dict[str, float])
    tries: list[Try] = field(default_factory=list[Try])
    _stops: list[tuple[Floats, ...]] = field(default_factory=list[tuple[Floats, ...]])
    _guesses: Iterator[tuple[SeedKind, Program, Floats]] = field(default_factory=lambda: iter(()))
    _best: Result | None = None

    @cached_property
    def judge(self) -> Judge:
        """The judge of this problem; it keeps its own kinematics and geometry."""
        return Judge(self.problem.reduced)

    def prepare(self) -> Result | None:
        """Look at the start and choose goal configurations; return why that is impossible, if it is."""
        objection = self.method.objection(self.problem)
        if objection:
            return self._result(Status.METHOD_CANNOT, f"{self.method.name}: {objection}")
        with self._stage("examine"):
            refusal = self._examine_start()
        if refusal is not None:
            return refusal
        with self._stage("seed"):
            goals, refusal = self._goals()
        if refusal is not None:
            return refusal
        with self._stage("seed"):
            counts = Counts()
            waypoints = choose_waypoints(
                self.problem.reduced,
                self.problem.waypoint_requirements,
                [
                    self.problem.requirements_at(1 + place)
                    for place in range(len(self.problem.waypoint_names))
                ],
                rng=self.rng,
                counts=counts,
            )
            self._count(distance_calls=counts.distances, forward_kinematics=counts.forward_kinematics)
        if waypoints.problem:
            return self._result(Status.NO_WAYPOINT, waypoints.problem)
        self._stops = [(*waypoints.found, goal) for goal in goals[:GOALS_TRIED]]
        self._guesses = self._seeds(self._stops)
        return None

    @property
    def travel(self) -> float:
        """Time to the nearest goal configuration at full speed; known once prepared [s]."""
        reduced = self.problem.reduced
        away = [np.abs(stops[-1] - reduced.start_positions) for stops in self._stops]
        return min(float((each / reduced.limits.velocity).max()) for each in away)

    def attempt(self, attempts: int) -> Result:
        """Plan from so many more first guesses; the result that came nearest if none succeeds."""
        for kind, program, seed in islice(self._guesses, attempts):
            result = self._from(program, seed)
            self.tries.append(_told(len(self.tries) + 1, kind, result))
            if self._best is None or _rank(result) < _rank(self._best):
                self._best = result
            if len(self.tries) == BEFORE_PROOF and self._best.status is Status.STUCK:
                self._best = self._walled_in(self._best)
            if self._best.status in {Status.SOLVED, Status.WALLED_IN}:
                self._guesses = iter(())
                break
        assert self._best is not None
        return replace(self._best, tries=tuple(self.tries))

    def _walled_in(self, stuck: Result) -> Result:
        """Look for a proof that no other first guess can do better either."""
        with self._stage("proof"):
            cut = closed_cut(self.problem)
        if cut is None:
            return stuck
        return replace(stuck, status=Status.WALLED_IN, message=reasons.walled_in(cut))

    def _seeds(self, goals: Sequence[Sequence[Floats]]) -> Iterator[tuple[SeedKind, Program, Floats]]:
        """Yield first guesses: straight legs through the stops to every goal, then bent ones in turn.

        Where goal configurations were searched for, the program first gets each of them as it is,
        and only then the nearest with the freedom to choose another: that is harder to solve.
        """
        problem, reduced = self.problem, self.problem.reduced
        kinds = [SeedKind.STRAIGHT, *[SeedKind.BRANCH] * (len(goals) - 1)]
        programs = [(kind, problem, stops) for kind, stops in zip(kinds, goals, strict=True)]
        if fixed_goal(problem) is None and _end_is_free(problem):
            programs = [(kind, _ending_at(problem, stops[-1]), stops) for kind, _, stops in programs]
            programs.append((SeedKind.FREE_END, problem, goals[0]))
        bent: list[tuple[Program, Iterator[Floats]]] = []
        for kind, asked, stops in programs:
            with self._stage("optimise"):
                line = line_through(reduced, (reduced.start_positions, *stops), problem.knots)
                program = self.method.program(asked, line.knots, line.places)
                bent.append((program, bumps(line.knots, program.scale, self.rng)))
            yield kind, program, line.knots
        for program, guesses in cycle(bent):
            yield SeedKind.BUMP, program, next(guesses)

    def _from(self, program: Program, seed: Floats) -> Result:
        """Optimise from a first guess; time and judge what comes out."""
        before = replace(program.counts)
        with self._stage("optimise"):
            found = program.solve(seed, progress=self._step)
        solved, done = found.solve, program.counts
        self._count(
            attempts=1,
            distance_calls=done.distances - before.distances,
            bounds=done.bounds - before.bounds,
            forward_kinematics=done.forward_kinematics - before.forward_kinematics,
            qp_solves=solved.qp_solves,
            qp_iterations=solved.qp_iterations,
        )
        if not solved.feasible:
            return self._result(Status.STUCK, reasons.stuck(self.problem, solved), found=found)
        if found.trajectory is not None:
            return self._judged(found, found.trajectory)
        return self._timed(found)

    def _timed(self, found: Outcome) -> Result:
        """Time a path and have it judged, each time nearer to the path, until the judge agrees."""
        problem = self.problem
        result: Result | None = None
        for tolerance in (*PATH_TOLERANCES, *((WAYPOINT_TOLERANCE,) if problem.waypoints else ())):
            with self._stage("retime"):
                timed = time_path(problem, query_of(problem.reduced), found.path, tolerance=tolerance)
            if isinstance(timed, RetimeFailure):
                return self._result(Status.NO_TIMING, timed.reason, found=found)
            result = self._judged(found, timed.trajectory, timed)
            if result.verified:
                break
        assert result is not None
        return result

    def _judged(self, found: Outcome, trajectory: Trajectory, timed: Retimed | None = None) -> Result:
        with self._stage("verify"):
            certificate = judge(self.problem, trajectory, workspace=self.judge)
        self._count(judge_distance_calls=certificate.counts.distances)
        return self._result(
            Status.SOLVED if certificate.verified else Status.NOT_VERIFIED,
            reasons.not_verified(certificate),
            found=found,
            trajectory=trajectory,
            timed=timed,
            certificate=certificate,
        )

    def _examine_start(self) -> Result | None:
        """Refuse a start that no motion can leave."""
        reduced = self.problem.reduced
        seen = self.judge.examine(reduced.start_positions, moment=Moment.START)
        refusal = self._refuse(seen, Status.START_OUT_OF_LIMITS, Status.START_IN_COLLISION)
        if refusal is not None:
            return refusal
        broken = self._broken(reduced.start_positions, 0)
        if broken:
            return self._result(Status.START_BREAKS_CONSTRAINT, broken)
        return None

    def _goals(self) -> tuple[Sequence[Floats], Result | None]:
        """Return goal configurations, nearest first, or why there is none."""
        reduced = self.problem.reduced
        goal = fixed_goal(self.problem)
        if goal is not None:
            seen = self.judge.examine(goal, moment=Moment.END)
            refusal = self._refuse(seen, Status.GOAL_OUT_OF_LIMITS, Status.GOAL_IN_COLLISION)
            broken = self._broken(goal, self._last_stop)
            if refusal is None and broken:
                refusal = self._result(Status.GOAL_BREAKS_CONSTRAINT, broken)
            return (goal,), refusal
        beyond = reasons.joint_goal_beyond_limits(self.problem)
        if beyond:
            words = "; ".join(block.words for block in beyond)
            return (), self._result(Status.GOAL_OUT_OF_LIMITS, words)
        counts = Counts()
        wanted = (*self.problem.goals, *self.problem.requirements_at(self._last_stop))
        found = goal_candidates(reduced, wanted, rng=self.rng, counts=counts)
        self._count(distance_calls=counts.distances, forward_kinematics=counts.forward_kinematics)
        if found.free:
            return found.free, None
        if found.blocking is not None:
            return (), self._result(Status.GOAL_IN_COLLISION, reasons.no_goal_configuration(found))
        clash = conflicting(reduced, wanted, rng=self.rng, counts=counts)
        status = Status.CONFLICTING_CONSTRAINTS if len(clash) > 1 else Status.NO_INVERSE_KINEMATICS
        return (), self._result(status, reasons.unreachable(clash, found.nearest_miss))

    @property
    def _last_stop(self) -> int:
        return 1 + len(self.problem.waypoint_names)

    def _refuse(self, seen: Examination, limits: Status, collision: Status) -> Result | None:
        if seen.out_of_limits:
            return self._result(limits, reasons.out_of_limits(seen))
        if seen.collisions:
            return self._result(collision, reasons.collisions(seen))
        return None

    def _broken(self, positions: Floats, stop: int) -> str:
        """Say which path constraint does not hold at a configuration, or nothing."""
        reduced = self.problem.reduced
        motion = Motion.standing(positions, query_of(reduced))
        for required in self.problem.requirements_at(stop):
            for item in constrain(required, reduced, WHOLE, inset=0.0):
                excess = item.excess(motion)
                if excess > 0.0:
                    return f"{required} is exceeded by {excess:.3g}"
        return ""

    def _result(
        self,
        status: Status,
        message: str,
        *,
        found: Outcome | None = None,
        trajectory: Trajectory | None = None,
        timed: Retimed | None = None,
        certificate: Certificate | None = None,
    ) -> Result:
        return Result(
            problem=self.problem,
            status=status,
            message=message,
            path=None if found is None else found.path,
            solve=None if found is None else found.solve,
            trajectory=trajectory,
            timed=timed,
            certificate=certificate,
            counts=dict(self.counts),
            cpu_seconds=dict(self.seconds),
        )

    def _step(self, iteration: Iteration) -> None:
        if self.progress is not None:
            self.progress("optimise", iteration)

    def _count(self, **numbers: int) -> None:
        for name, number in numbers.items():
            self.counts[name] = self.counts.get(name, 0) + number

    @contextmanager
    def _stage(self, name: str) -> Generator[None]:
        if self.progress is not None:
            self.progress(name, None)
        begin = time.process_time()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + time.process_time() - begin


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


def _rank(result: Result) -> tuple[bool, float]:
    """Order results by how near they came: feasible paths first, then by what they violate."""
    solved = result.solve
    return result.status is not Status.SOLVED, np.inf if solved is None else solved.at.violation


def _told(number: int, kind: SeedKind, result: Result) -> Try:
    """Tell of a try what planning ended with after it."""
    solved = result.solve
    blocks = () if solved is None else reasons.blocks_on_the_way(result.problem, solved)
    return Try(
        number=number,
        kind=kind,
        status=result.status,
        solver=None if solved is None else solved.status,
        message=result.message,
        iterations=0 if solved is None else len(solved.log),
        block=next(iter(blocks), None),
    )
