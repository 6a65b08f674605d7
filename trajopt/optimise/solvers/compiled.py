"""A program in parts that the core evaluates without Python: what an `Nlp` may offer besides itself."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, cast, runtime_checkable

import numpy as np

from trajopt.native import descent
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation, Nlp
from trajopt.optimise.solvers.parts import Block, LinearPart, Part, PythonPart
from trajopt.values.arrays import Floats, Ints


@dataclass(frozen=True, eq=False)
class CompiledProgram:
    """A program on given samples, in parts.

    Attributes:
        lower: Lower bounds of the knots, shape (N, n).
        upper: Upper bounds, shape (N, n).
        scale: A step of ordinary size in each variable, shape (n,).
        sampling: The samples per segment, shape (N - 1,).
        query: Measures distances and places frames.
        costs: Parts of the costs.
        constraints: Parts of the constraints.
        support: The knots that each sample depends on, shape (S, k).
    """

    lower: Floats
    upper: Floats
    scale: Floats
    sampling: Ints
    query: descent.RobotQuery
    costs: tuple[Part, ...]
    constraints: tuple[Part, ...]
    support: Ints

    @cached_property
    def span(self) -> int:
        """Knots between the first and the last that one row depends on, at most."""
        parts = (*self.costs, *self.constraints)
        linear = (part.at_zero.rows.knots for part in parts if isinstance(part, LinearPart))
        return max(int(np.ptp(knots, axis=1).max(initial=0)) for knots in (self.support, *linear))

    @cached_property
    def core(self) -> descent.Program:
        """The program in the core."""
        program = descent.Program(self.lower, self.upper, self.scale, self.query)
        for part in (*self.costs, *self.constraints):
            part.add_to(program)
        return program

    def linearised(self, point: descent.Point) -> Linearisation:
        """Return everything at a point."""
        in_python = iter(cast(tuple[Block, ...], point.kept or ()))
        blocks = [
            next(in_python) if isinstance(part, PythonPart) else part.block(self.core.rows(point, number))
            for number, part in enumerate((*self.costs, *self.constraints))
        ]
        costs = tuple(block for block in blocks if isinstance(block, CostRows))
        constraints = tuple(block for block in blocks if isinstance(block, ConstraintRows))
        return Linearisation(point.x.reshape(self.lower.shape), costs, constraints, self.sampling)


class WorkCounts(Protocol):
    """Exact numbers of the work done so far.

    Attributes:
        forward_kinematics: Configurations evaluated.
        bounds: Bounds of distances compared.
        distances: Distances measured.
    """

    forward_kinematics: int
    bounds: int
    distances: int


@runtime_checkable
class CompilableNlp(Nlp, Protocol):
    """A program that may be evaluated in the core; its `linearise` says the same of the same point."""

    @property
    def counts(self) -> WorkCounts:
        """The work done so far, which the core adds to."""
        ...

    def compiled(self, sampling: Ints) -> CompiledProgram | None:
        """Return the program in parts on given samples; None if one of its terms is unknown to the core."""
        ...

    def python_rows(self, x: Floats, sampling: Ints) -> tuple[Block, ...]:
        """Return the rows of those parts that the core asks for, at a point."""
        ...
