"""Sequential quadratic programming with an L1 merit, a box trust region and penalty rounds.

Source: Nocedal and Wright, Numerical Optimization (2006), algorithm 18.5 and section 17.2; in motion planning
Schulman et al., IJRR 2014, algorithm 1. Costs are Gauss-Newton.
"""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil

import numpy as np

from trajopt.native import descent
from trajopt.optimise.nlp import CostRows, Linearisation, Nlp, Restartable
from trajopt.optimise.solvers.descent import (
    ACCURACY,
    QP_FAILURES,
    Descent,
    DescentLimits,
    StepwiseDescent,
    TrustRegion,
)
from trajopt.optimise.solvers.parts import Block, CompilableNlp, CompiledProgram
from trajopt.optimise.solvers.solver import Effort, Patient, Progress, SolveResult, SolverStatus, SqpStep
from trajopt.optimise.solvers.subproblem import NAME, REGULARISATION, BandedSteps, StepProgram, StepSolver
from trajopt.values.arrays import Bools, Floats, Ints, above_zero, at_least
from trajopt.values.errors.arguments import check_arguments, checked

AUTO = "auto"
"""The banded solver if rows couple neighbouring knots only, else PIQP."""
GENERAL = "piqp"
"""The backend of programs without the structure."""
WIDEST = 5
"""Knots that a row may span for the banded solver to be worthwhile."""


def step_solver(name: str) -> StepSolver:
    if name == AUTO:
        return ByStructure()
    if name == "banded":
        return BandedSteps()
    return _general(name)


def _general(name: str) -> StepSolver:
    from trajopt.optimise.solvers.flat import FlatSteps

    return FlatSteps(name)


@dataclass(eq=False)
class ByStructure:
    """Chooses for each program; `StepProgram.backend` is its choice."""

    _band: StepSolver = field(default_factory=lambda: step_solver("banded"))
    _wide: StepSolver | None = None

    def program(self, moves: Bools, at: Linearisation, penalty: float) -> StepProgram:
        if _span(at) <= WIDEST:
            return self._band.program(moves, at, penalty)
        if self._wide is None:
            self._wide = _general(GENERAL)
        return self._wide.program(moves, at, penalty)


def _span(at: Linearisation) -> int:
    blocks = [block.rows.knots for block in (*at.costs, *at.constraints)]
    return max((int(np.ptp(knots, axis=1).max()) for knots in blocks if knots.size), default=0)


WIDENED = 0.1
"""Least width of the trust region after a round, or on finer samples."""
NEAR_GAIN = 0.03
"""Relative gain below which a seed that is nearly a solution is left unchanged. This is one or two
hundredths of the travel.
"""
FINAL = {
    SolverStatus.MAX_ITERATIONS,
    SolverStatus.QP_FAILED,
    SolverStatus.NON_FINITE,
    SolverStatus.GIVEN_UP,
}
"""Endings after which no other penalty weight is tried."""


@checked
@dataclass(frozen=True)
class Sqp:
    """The solver; its fields are its options.

    Attributes:
        qp: QP backend; "auto" chooses by the structure of the program.
        penalty: First weight of constraint violations.
        penalty_growth: Factor when constraints do not hold at convergence.
        penalty_rounds: Most rounds of growth; 0 if the caller has other ways to try.
        max_iterations: Most QPs.
        relative_gain: Converged when the predicted reduction is below this share of the merit.
        absolute_gain: Or below this value.
        until_feasible: Whether any point that holds all constraints suffices, regardless of its cost.
        refines: Whether a point has to hold all constraints on many samples too; else the caller checks
            between the samples.
        fine_first: Whether the first samples have the final density, for seeds that are nearly solutions.
        gives_up: Whether a seed is given up if, at the rate of the last quarter of `max_iterations`, its
            constraints would not hold in time.
    """

    qp: str = AUTO
    penalty: float = 5.0
    penalty_growth: float = 10.0
    penalty_rounds: int = 4
    max_iterations: int = 30
    relative_gain: float = 5e-3
    absolute_gain: float = 1e-5
    until_feasible: bool = False
    refines: bool = True
    fine_first: bool = False
    gives_up: bool = False
    trust_region: TrustRegion = field(default_factory=TrustRegion)

    def __post_init__(self) -> None:
        above_zero(self, "penalty")
        at_least(self, 1, "penalty_growth", "max_iterations")
        at_least(self, 0, "penalty_rounds", "relative_gain", "absolute_gain")

    @property
    def name(self) -> str:
        return "sqp" if self.qp == AUTO else f"sqp-{self.qp}"

    @checked
    def with_effort(self, effort: Effort) -> "Sqp":
        match effort:
            case Effort.FULL:
                return self
            case Effort.TENTATIVE:
                return replace(self, gives_up=True)
            case Effort.BRIEF:
                return replace(self, max_iterations=self._few)
            case Effort.NEAR:
                return replace(self, fine_first=True, relative_gain=max(self.relative_gain, NEAR_GAIN))

    @property
    def _few(self) -> int:
        return ceil(self.max_iterations / 4)

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Solve on coarse samples until the constraints hold, then on fine ones."""
        check_arguments(Sqp.solve, locals())
        x = np.clip(x0, nlp.lower, nlp.upper)
        run = self._begun(nlp, x, nlp.sampling(x, fine=self.fine_first), progress)
        run.fine = self.fine_first and not self.until_feasible
        rounds = 0
        while True:
            status = run.descend()
            if run.feasible:
                # Steps are compared on equal samples; whether these are enough is checked at the end. More
                # samples only add rows: a point that still holds them all needs no other descent.
                if self.refines:
                    run.refine()
                enough = run.feasible and (self.until_feasible or run.fine)
                if status in FINAL:
                    return run.result(status)
                if enough:
                    return run.result(SolverStatus.CONVERGED)
                run.fine = not self.until_feasible
            elif status in FINAL:
                return run.result(status)
            elif rounds == self.penalty_rounds:
                collapsed = run.region.collapsed
                return run.result(
                    SolverStatus.TRUST_REGION_COLLAPSED if collapsed else SolverStatus.INFEASIBLE_STATIONARY
                )
            else:
                rounds += 1
                run.penalty *= self.penalty_growth
            run.region = replace(run.region, radius=max(run.region.radius, WIDENED))

    def _begun(self, nlp: Nlp, x: Floats, sampling: Ints, progress: Progress | None) -> Descent:
        if isinstance(nlp, Restartable):
            nlp.restart()
        steps = step_solver(self.qp)
        window = self._few if self.gives_up else None
        limits = DescentLimits(self.max_iterations, self.relative_gain, self.absolute_gain, window)
        run = native_descent(self.qp, nlp, sampling, limits, progress, self.trust_region, self.penalty)
        if run is None:
            run = StepwiseDescent(nlp, limits, progress, self.trust_region, self.penalty, steps=steps)
        run.begin(x, sampling)
        return run


SILENCE = 3e-3
"""Delay of reports of steps to a patient watch, with the step in progress: below Python's switching
interval of threads [s].
"""
ENDINGS = (
    SolverStatus.CONVERGED,
    SolverStatus.MAX_ITERATIONS,
    SolverStatus.TRUST_REGION_COLLAPSED,
    SolverStatus.QP_FAILED,
    SolverStatus.NON_FINITE,
    SolverStatus.GIVEN_UP,
)
"""How a descent ended, in the order of the core."""


def native_descent(
    qp: str,
    nlp: Nlp,
    sampling: Ints,
    limits: DescentLimits,
    progress: Progress | None,
    region: TrustRegion,
    penalty: float,
) -> "NativeDescent | None":
    if qp not in (AUTO, NAME) or type(region) is not TrustRegion or not isinstance(nlp, CompilableNlp):
        return None
    program = nlp.compiled(sampling)
    if program is None or (qp == AUTO and program.span > WIDEST):
        return None
    return NativeDescent(nlp, limits, progress, region, penalty, compilable=nlp, program=program)


@dataclass(eq=False, kw_only=True)
class NativeDescent(Descent):
    """Steps in the core; see `Descent`."""

    compilable: CompilableNlp
    program: CompiledProgram
    point: descent.Point = field(init=False)

    @property
    def x(self) -> Floats:
        return self.point.x.reshape(self.program.lower.shape)

    @property
    def sampling(self) -> Ints:
        return self.program.sampling

    @property
    def feasible(self) -> bool:
        return self.point.feasible

    def begin(self, x: Floats, sampling: Ints) -> None:
        if not np.array_equal(sampling, self.program.sampling):
            program = self.compilable.compiled(sampling)
            assert program is not None, "what can be compiled does not depend on the samples"
            self.program = program
        with self._counting():
            self.point = self.program.core.at(np.ascontiguousarray(x), self._in_python)

    def linearised(self) -> Linearisation:
        return self.program.linearised(self.point)

    def descend(self) -> SolverStatus:
        core, region = self.program.core, self.region
        rule = (region.smallest, region.largest, region.accept, region.good, region.grow, region.shrink)
        options = descent.Options(
            penalty=self.penalty,
            relative_gain=self.limits.relative_gain,
            absolute_gain=self.limits.absolute_gain,
            accuracy=ACCURACY,
            regularisation=REGULARISATION,
            qp_iterations=BandedSteps().max_iterations,
            steps=self.left,
            failures=QP_FAILURES,
            until_feasible=not self.fine,
            window=self.limits.window or 0,
            violations=self.violations,
        )
        with self._counting() as count:

            def tell(entries: "list[descent.Entry]") -> None:
                for entry in entries:
                    count(entry[-1])
                    self.note(self._step(entry))

            ending, self.point, radius, self.failures = core.descend(
                self.point,
                (region.radius, *rule),
                self.failures,
                options,
                self._in_python,
                tell,
                SILENCE,
                self._patience(),
            )
        self.region = replace(region, radius=radius)
        return ENDINGS[ending]

    def _patience(self) -> int:
        """Return the core's work up to which no step has to be reported; negative for any."""
        if self.progress is None:
            return -1
        patience = 0 if self._patient is None else self._patient.patience
        return -1 if patience is None else self.program.core.work[0] + patience

    @cached_property
    def _patient(self) -> Patient | None:
        return self.progress if isinstance(self.progress, Patient) else None

    def _step(self, entry: "descent.Entry") -> SqpStep:
        cost, violation, merit, radius, accepted, rows, qp_iterations, _ = entry
        return SqpStep(cost, violation, accepted, merit, self.penalty, radius, rows, NAME, qp_iterations)

    @contextmanager
    def _counting(self) -> "Generator[Callable[[descent.Worked], None]]":
        counts, core = self.compilable.counts, self.program.core
        before = (counts.forward_kinematics, counts.bounds, counts.distances)
        begun = core.work

        def count(work: "descent.Worked") -> None:
            counts.forward_kinematics, counts.bounds, counts.distances = (
                first + now - then for first, now, then in zip(before, work, begun, strict=True)
            )

        try:
            yield count
        finally:
            count(core.work)

    def _in_python(self, x: Floats) -> "descent.InPython":
        counts = self.compilable.counts
        before = counts.forward_kinematics
        blocks = self.compilable.python_rows(x, self.program.sampling)
        return [_arrays(block) for block in blocks], counts.forward_kinematics - before, blocks


def _arrays(block: Block) -> tuple[Floats | Ints, ...]:
    rows = block.rows
    if isinstance(block, CostRows):
        limits = (block.weight,)
    else:
        limits = (block.lower, block.upper)
    return (rows.value, rows.jacobian, rows.knots, *limits)
