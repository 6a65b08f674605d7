"""A descent in one call of the core, of programs whose terms the core can evaluate."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from trajopt.native import descent
from trajopt.optimise.nlp import CostRows, Linearisation, Nlp
from trajopt.optimise.solvers import banded
from trajopt.optimise.solvers.choice import AUTO, WIDEST
from trajopt.optimise.solvers.descent import ACCURACY, QP_FAILURES, Descent, DescentLimits, TrustRegion
from trajopt.optimise.solvers.parts import Block, CompilableNlp, CompiledProgram
from trajopt.optimise.solvers.solver import Patient, Progress, SolverStatus, SqpStep
from trajopt.optimise.solvers.step import REGULARISATION
from trajopt.values.arrays import Floats, Ints

SILENCE = 3e-3
"""Delay of the reports of steps to a patient watch, and the step in progress besides: well below human
perception, and below Python's switching interval of threads [s].
"""
ENDINGS = (
    SolverStatus.CONVERGED,
    SolverStatus.MAX_ITERATIONS,
    SolverStatus.TRUST_REGION_COLLAPSED,
    SolverStatus.QP_FAILED,
    SolverStatus.NON_FINITE,
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
    """Return a descent in the core; None if program, backend or trust region are of another kind.

    Args:
        qp: Name of the QP backend.
        nlp: The program.
        sampling: The first samples per segment, shape (N - 1,).
        limits: Conditions that end a descent.
        progress: Called after every step.
        region: First trust region.
        penalty: First weight of violations.
    """
    if qp not in (AUTO, banded.NAME) or type(region) is not TrustRegion or not isinstance(nlp, CompilableNlp):
        return None
    program = nlp.compiled(sampling)
    if program is None or (qp == AUTO and program.span > WIDEST):
        return None
    return NativeDescent(nlp, limits, progress, region, penalty, compilable=nlp, program=program)


@dataclass(eq=False, kw_only=True)
class NativeDescent(Descent):
    """See `Descent`.

    Attributes:
        compilable: The program, as a `CompilableNlp`.
        program: Its parts, on the current samples.
        point: Values and rows at the current point.
    """

    compilable: CompilableNlp
    program: CompiledProgram
    point: descent.Point = field(init=False)

    @property
    def x(self) -> Floats:
        """The point, shape (N, n)."""
        return self.point.x.reshape(self.program.lower.shape)

    @property
    def sampling(self) -> Ints:
        """Samples per segment, shape (N - 1,)."""
        return self.program.sampling

    @property
    def feasible(self) -> bool:
        """Whether every constraint holds within its tolerance."""
        return self.point.feasible

    def begin(self, x: Floats, sampling: Ints) -> None:
        """Go to a point, on given samples."""
        if not np.array_equal(sampling, self.program.sampling):
            program = self.compilable.compiled(sampling)
            assert program is not None, "what can be compiled does not depend on the samples"
            self.program = program
        with self._counting():
            self.point = self.program.core.at(np.ascontiguousarray(x), self._in_python)

    def linearised(self) -> Linearisation:
        """Return everything at the point."""
        return self.program.linearised(self.point)

    def descend(self) -> SolverStatus:
        """Take steps until none is predicted to reduce the merit enough."""
        core, region = self.program.core, self.region
        rule = (region.smallest, region.largest, region.accept, region.good, region.grow, region.shrink)
        options = descent.Options(
            penalty=self.penalty,
            relative_gain=self.limits.relative_gain,
            absolute_gain=self.limits.absolute_gain,
            accuracy=ACCURACY,
            regularisation=REGULARISATION,
            qp_iterations=banded.BandedSteps().max_iterations,
            steps=self.limits.steps - len(self.log),
            failures=QP_FAILURES,
            until_feasible=not self.fine,
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
        """Return the work of the core up to which no step has to be reported; negative for any."""
        if self.progress is None:
            return -1
        patience = 0 if self._patient is None else self._patient.patience
        return -1 if patience is None else self.program.core.work[0] + patience

    @cached_property
    def _patient(self) -> Patient | None:
        """Receiver of the steps, if a small delay is allowed."""
        return self.progress if isinstance(self.progress, Patient) else None

    def _step(self, entry: "descent.Entry") -> SqpStep:
        cost, violation, merit, radius, accepted, rows, qp_iterations, _ = entry
        return SqpStep(
            cost, violation, accepted, merit, self.penalty, radius, rows, banded.NAME, qp_iterations
        )

    @contextmanager
    def _counting(self) -> "Generator[Callable[[descent.Worked], None]]":
        """Add the work of the core to the program's counts; yields a function that does so earlier."""
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
        """Evaluate the parts that the core requests."""
        counts = self.compilable.counts
        before = counts.forward_kinematics
        blocks = self.compilable.python_rows(x, self.program.sampling)
        return [_arrays(block) for block in blocks], counts.forward_kinematics - before, blocks


def _arrays(block: Block) -> tuple[Floats | Ints, ...]:
    """Return a block's rows in the core's format."""
    rows = block.rows
    if isinstance(block, CostRows):
        limits = (block.weight,)
    else:
        limits = (block.lower, block.upper)
    return (rows.value, rows.jacobian, rows.knots, *limits)
