"""The SQP step by step in Python, whatever the core could do: the oracle of the core's descents."""

from dataclasses import dataclass

from trajopt.optimise.nlp import Linearisation, Nlp
from trajopt.optimise.solvers import SolveResult, Sqp
from trajopt.optimise.solvers.solver import Progress
from trajopt.values.arrays import Floats, Ints


@dataclass(frozen=True, eq=False)
class Uncompiled:
    """A program, and no more than what every program offers."""

    nlp: Nlp

    @property
    def lower(self) -> Floats:
        return self.nlp.lower

    @property
    def upper(self) -> Floats:
        return self.nlp.upper

    @property
    def scale(self) -> Floats:
        return self.nlp.scale

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        return self.nlp.sampling(x, fine=fine)

    def linearise(self, x: Floats, sampling: Ints) -> Linearisation:
        return self.nlp.linearise(x, sampling)


@dataclass(frozen=True)
class SqpInPython(Sqp):
    """The solver as it is for programs that the core does not know."""

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        return super().solve(Uncompiled(nlp), x0, progress=progress)
