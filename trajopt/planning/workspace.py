"""Workspace: judge, budget and maker of results, shared by the attempts at one problem."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from trajopt.geometry import Evaluator, WorkCounts
from trajopt.optimise.methods import Decoded
from trajopt.optimise.methods.timing import PATH_TOLERANCE, retime_path, retime_with_stops
from trajopt.optimise.solvers import SolveResult
from trajopt.planning.budget import BudgetTracker, Stop
from trajopt.planning.infeasibility import reasons
from trajopt.planning.infeasibility.reasons import Obstruction
from trajopt.planning.judgement import Judged, decide, holds
from trajopt.planning.moving.dynamic_timing import DynamicTiming
from trajopt.planning.moving.timed_path import TimedOnPath
from trajopt.planning.result import Result
from trajopt.planning.status import Certainty, Status
from trajopt.problem.problem import Problem
from trajopt.timing import Retimed, RetimeFailure
from trajopt.values.arrays import Floats, Printed
from trajopt.values.trajectory import Path, Trajectory
from trajopt.verify import CheckKind, Judge

PATH_TOLERANCES = (PATH_TOLERANCE, 1e-3)
"""Largest distances of the timed motion from the checked path, tried in turn if the judge refuses it [m]."""
EXACT_TOLERANCE = 1e-4
"""The same, a third time, for waypoints, which may be at corners of the path, and for narrow gaps [m]."""


@dataclass(frozen=True, eq=False)
class MotionCandidate(Printed):
    """A motion that is ready to be judged.

    Attributes:
        timed: Report of retiming; None if the method determined time itself.
        remarks: Its changes because of changing objects, in sentences.
    """

    path: Path
    trajectory: Trajectory
    timed: Retimed | None
    remarks: tuple[str, ...] = ()


def _verdict(found: Judged) -> tuple[Status, str]:
    if found.known is None or found.verified:
        return Status.SOLVED, ""
    failed = found.known.failed
    if failed and all(check.kind is CheckKind.DEADLINE for check in failed):
        words = f"the soonest motion that was found takes {found.trajectory.duration:.3f} s"
        return Status.TOO_LATE, f"{words}; the deadline is {found.problem.finish_by:g} s"
    return Status.NOT_VERIFIED, reasons.not_verified(found.known)


@dataclass(eq=False)
class PlanningWorkspace(Printed):
    """One per thread; serves any number of attempts at the same problem."""

    problem: Problem
    tracker: BudgetTracker

    @cached_property
    def judge(self) -> Judge:
        """The judge of this problem; it keeps its own kinematics and geometry."""
        return Judge(self.problem.reduced)

    @cached_property
    def query(self) -> Evaluator:
        """Measures torques and displacements for retiming; the same for all motions."""
        return self.problem.evaluator(self.problem.reduced)

    def timed(self, decoded: Iterable[Decoded]) -> Iterator[MotionCandidate | RetimeFailure]:
        """Time the path of a method, nearer to the path each time another motion is needed.

        A motion already that near is not made twice.
        """
        for item in decoded:
            if item.trajectory is not None:
                yield from self.avoiding(MotionCandidate(item.path, item.trajectory, None))
                continue
            exact = (EXACT_TOLERANCE,) if self.problem.waypoints or item.narrow else ()
            away = np.inf
            for tolerance in (*PATH_TOLERANCES, *exact):
                if away <= tolerance:
                    continue
                with self.tracker.stage("retime"):
                    retimed = retime_path(
                        self.problem,
                        item.path,
                        through=item.waypoint_knots,
                        tolerance=tolerance,
                        query=self.query,
                    )
                if isinstance(retimed, RetimeFailure):
                    yield retimed
                    return
                away = retimed.deviation
                yield from self.avoiding(MotionCandidate(item.path, retimed.trajectory, retimed))
            if item.waypoint_knots:
                yield from self._stopping(item)

    def _stopping(self, item: Decoded) -> Iterator[MotionCandidate | RetimeFailure]:
        with self.tracker.stage("retime"):
            retimed = retime_with_stops(
                self.problem, item.path, item.waypoint_knots, tolerance=PATH_TOLERANCES[-1], query=self.query
            )
        if isinstance(retimed, RetimeFailure):
            yield retimed
        else:
            stops = "the motion stops at each waypoint, as the tolerances cannot be held in passing"
            yield from self.avoiding(MotionCandidate(item.path, retimed.trajectory, retimed, (stops,)))

    def avoiding(self, motion: MotionCandidate) -> Iterator[MotionCandidate]:
        """Yield a motion timed to be clear of changing objects, the soonest first; unchanged if never.

        Raises:
            Stopped: If the budget ends before.
        """
        clear = False
        for timed in self.retimed(motion) if self._timing else ():
            clear = True
            yield timed
        if not clear:
            yield motion

    def retimed(self, motion: MotionCandidate, by: float = np.inf) -> Iterator[MotionCandidate]:
        """Yield motions among changing objects that seem clear and end by a time [s], the soonest first.

        Raises:
            Stopped: If the budget ends before.
        """
        assert self._timing is not None
        yield from self._counted(self._timing, self._timing.timings(motion.trajectory, by), motion)

    def delayed(self, motion: MotionCandidate, by: float) -> Iterator[MotionCandidate]:
        """Yield a motion unchanged, or begun later, if it seems clear and ends by a time [s].

        Raises:
            Stopped: If the budget ends before.
        """
        assert self._timing is not None
        yield from self._counted(self._timing, self._timing.delayed(motion.trajectory, by), motion)

    def _counted(
        self, timing: DynamicTiming, timings: Iterator[TimedOnPath], motion: MotionCandidate
    ) -> Iterator[MotionCandidate]:
        while True:
            before = replace(timing.counts)
            with self.tracker.stage("wait"):
                found = next(timings, None)
            self.tracker.count_work(timing.counts.since(before))
            if found is None:
                return
            yield replace(motion, trajectory=found.trajectory, remarks=(*motion.remarks, *found.remarks))

    @cached_property
    def _timing(self) -> DynamicTiming | None:
        return DynamicTiming.of(self.problem, self.query) if self.problem.scene.changing else None

    def judged(self, motion: MotionCandidate, solve: SolveResult | None = None) -> Result:
        """Have a motion judged against all requirements of the problem.

        Args:
            solve: Result of its solver; None if no solver made it.
        """
        with self.tracker.stage("verify"):
            found, distances = decide(self.problem, motion.trajectory, self.judge)
        self.tracker.count(judge_distance_calls=distances)
        return self.result(*_verdict(found), solve=solve, motion=motion, judged=found)

    def proven(self, motion: MotionCandidate) -> Result | None:
        """Have a motion judged, and return it if it is verified; a refusal has no reasons."""
        with self.tracker.stage("verify"):
            verdict = holds(self.problem, motion.trajectory, self.judge)
        self.tracker.count(judge_distance_calls=verdict.counts.distances)
        if not verdict.verified:
            return None
        judged = Judged(self.problem, motion.trajectory, verified=True)
        return self.result(Status.SOLVED, motion=motion, judged=judged)

    def judged_as_it_is(self, seed: Floats) -> Result | None:
        """Time and judge a seed itself; None if something is too near at its knots.

        Raises:
            Stopped: If the budget ends before.
        """
        reduced, counts = self.problem.reduced, WorkCounts()
        touching = self.problem.evaluator(reduced, counts).close_pairs(seed, reduced.pairs.required)
        self.tracker.count_work(counts)
        self.tracker.check()
        if len(touching.pair):
            return None
        path, result = Path(reduced.joint_names, seed), None
        for motion in self.timed((Decoded(path),)):
            if isinstance(motion, RetimeFailure):
                return self.result(Status.NO_TIMING, motion.reason, path=path)
            result = self.judged(motion)
            if result.verified:
                break
        return result

    def result(
        self,
        status: Status,
        message: str = "",
        *,
        certainty: Certainty | None = None,
        path: Path | None = None,
        solve: SolveResult | None = None,
        motion: MotionCandidate | None = None,
        judged: Judged | None = None,
        stopped: Stop | None = None,
        blocks: tuple[Obstruction, ...] = (),
    ) -> Result:
        """Return a result with the current counts.

        Args:
            certainty: Proven by default if the motion is verified.
        """
        proven = judged is not None and judged.verified
        return Result(
            problem=self.problem,
            status=status,
            message=message,
            path=path if motion is None else motion.path,
            solve=solve,
            trajectory=None if motion is None else motion.trajectory,
            timed=None if motion is None else motion.timed,
            judged=judged,
            counts=dict(self.tracker.counts),
            cpu_seconds=dict(self.tracker.seconds),
            stopped=stopped,
            certainty=certainty or (Certainty.PROVEN if proven else Certainty.EVIDENCE),
            remarks=() if motion is None else motion.remarks,
            blocks=blocks,
        )
