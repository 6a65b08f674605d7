"""Parts of a program that the core evaluates without Python."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, cast, runtime_checkable

import numpy as np

from trajopt.native import descent
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation, Nlp
from trajopt.values.arrays import Bools, Floats, Ints, Loss, Rows, Value

KINDS = {
    Loss.SQUARED: descent.Kind.SQUARED,
    Loss.ABSOLUTE: descent.Kind.ABSOLUTE,
    Loss.HINGE: descent.Kind.HINGE,
}
"""The losses, as the core names them."""

Block = CostRows | ConstraintRows


def role_of(block: Block) -> descent.Role:
    if isinstance(block, CostRows):
        return descent.cost(KINDS[block.loss], block.weight)
    return descent.bounds(block.lower, block.upper, block.tolerance)


@dataclass(frozen=True, eq=False)
class LinearPart(Value):
    """Rows whose values are linear in the knots; all their other data are constant.

    Attributes:
        at_zero: The rows at knots of zero.
    """

    at_zero: Block

    def add_to(self, program: descent.Program) -> None:
        rows = self.at_zero.rows
        program.add_linear(role_of(self.at_zero), rows.value, np.ascontiguousarray(rows.jacobian), rows.knots)

    def block(self, made: descent.MadeRows) -> Block:
        return replace(self.at_zero, rows=replace(self.at_zero.rows, value=made.value))


@dataclass(frozen=True, eq=False)
class Samples(Value):
    """Samples of a curve: each is a weighted mean of few knots.

    Attributes:
        knots: Shape (S, k).
        weight: Shape (S, k).
        place: Along the motion, in knots, shape (S,).
    """

    knots: Ints
    weight: Floats
    place: Floats


@dataclass(frozen=True, eq=False)
class Taper(Value):
    """Change of the distances that p pairs must keep along a motion; shape (p,), unless stated otherwise.

    Attributes:
        required: Required distance everywhere [m].
        at_start: Distance at a fixed start [m].
        at_end: Distance at a fixed end [m].
        contact_until: Knot up to which contact is allowed; -1 for none.
        contact_from: Knot from which contact is allowed; inf for none.
        depth: Penetration accepted there [m].
        gives: Pairs for which a share of the margin beyond the requirement suffices.
        knots: Number of knots over which it grows from an end to its full size.
    """

    required: Floats
    at_start: Floats
    at_end: Floats
    contact_until: Floats
    contact_from: Floats
    depth: Floats
    gives: Bools
    last: float
    knots: float
    share: float

    def in_core(self, full: Floats) -> descent.Margins:
        """Return the taper of the full margins, shape (p,) [m]."""
        return descent.tapered(
            full=full,
            required=self.required,
            at_start=self.at_start,
            at_end=self.at_end,
            contact_until=self.contact_until,
            contact_from=self.contact_from,
            depth=self.depth,
            gives=self.gives,
            last=self.last,
            taper=self.knots,
            share=self.share,
        )


@dataclass(frozen=True, eq=False)
class _EmptyPart(Value):
    """Rows of which there are as many as the core makes.

    Attributes:
        empty: Cost or constraint without rows; weight or bounds are one number, or one for each pair.
    """

    empty: Block

    def block(self, made: descent.MadeRows) -> Block:
        rows = Rows(made.value, made.jacobian, made.knots, made.component, made.place)
        if isinstance(self.empty, CostRows):
            return replace(self.empty, rows=rows, weight=made.weight)
        return replace(self.empty, rows=rows, lower=made.lower, upper=made.upper)


@dataclass(frozen=True, eq=False)
class DistancePart(_EmptyPart):
    """factor (distance - margin) of every one of p pairs nearer than its reach.

    Attributes:
        reach: Pairs farther apart have no row, shape (p,) [m].
        factor: Shape (p,).
        margin: Full margins, shape (p,) [m].
    """

    samples: Samples
    reach: Floats
    factor: Floats
    margin: Floats
    taper: Taper | None

    def add_to(self, program: descent.Program) -> None:
        at, role = self.samples, role_of(self.empty)
        margins = descent.Margins(self.margin) if self.taper is None else self.taper.in_core(self.margin)
        program.add_distances(role, at.knots, at.weight, at.place, self.reach, self.factor, margins)


@dataclass(frozen=True, eq=False)
class FramePart(_EmptyPart):
    """A term of a frame at every sample.

    Attributes:
        configurations: Number that count as evaluated: terms over the same samples share them.
    """

    samples: Samples
    view: descent.View
    term: descent.FrameTerm
    configurations: int

    def add_to(self, program: descent.Program) -> None:
        at, role = self.samples, role_of(self.empty)
        program.add_frames(role, at.knots, at.weight, at.place, self.view, self.term, self.configurations)


@dataclass(frozen=True, eq=False)
class ChangingDistancePart(_EmptyPart):
    """Distance less error and margin of p pairs that change with time, while both are there; S samples.

    Attributes:
        times: Of each sample, shape (S,) [s].
        driven: Positions of the joints driven by time, shape (S, m) [rad | m].
        among: Measures them, by the group's positions and these.
        margin: Clearance to keep, shape (p,) [m].
        errors: Radius, velocity and acceleration of each pair's error, shape (p, 3).
        appears: Time from which both are there, shape (p,) [s].
        expires: Time until which both are there, shape (p,) [s].
    """

    samples: Samples
    times: Floats
    driven: Floats
    among: descent.RobotQuery
    reach: Floats
    margin: Floats
    errors: Floats
    appears: Floats
    expires: Floats

    def add_to(self, program: descent.Program) -> None:
        """Hand it to the core."""
        program.add_distances_in_time(
            role=role_of(self.empty),
            knots=self.samples.knots,
            weight=self.samples.weight,
            place=self.samples.place,
            when=self.times,
            driven=self.driven,
            among=self.among,
            reach=self.reach,
            margin=self.margin,
            errors=np.ascontiguousarray(self.errors.T),
            appears=self.appears,
            expires=self.expires,
        )


@dataclass(frozen=True, eq=False)
class TorquePart(_EmptyPart):
    """Torques as shares of their limits, at moments of a spline over time, for joints with high torque.

    Attributes:
        velocity: Weights of velocities, shape (S, k).
        acceleration: Weights of accelerations, shape (S, k).
        effort: Limits, shape (n,) [Nm | N]; inf for none.
        listed: Share from which a torque has a row.
    """

    moments: Samples
    velocity: Floats
    acceleration: Floats
    dynamics: descent.RobotDynamics
    effort: Floats
    listed: float

    def add_to(self, program: descent.Program) -> None:
        """Hand it to the core."""
        program.add_torques(
            role=role_of(self.empty),
            knots=self.moments.knots,
            position=self.moments.weight,
            velocity=self.velocity,
            acceleration=self.acceleration,
            place=self.moments.place,
            dynamics=self.dynamics,
            effort=self.effort,
            listed=self.listed,
        )


@dataclass(frozen=True, eq=False)
class PythonPart(Value):
    """Rows that the program itself evaluates at every point, in Python."""

    role: Loss | float

    def add_to(self, program: descent.Program) -> None:
        none = np.zeros(0)
        if isinstance(self.role, Loss):
            program.add_outside(descent.cost(KINDS[self.role], none))
        else:
            program.add_outside(descent.bounds(none, none, self.role))


Part = LinearPart | DistancePart | ChangingDistancePart | FramePart | TorquePart | PythonPart


@dataclass(frozen=True, eq=False)
class CompiledProgram:
    """A program on given samples, in parts.

    Attributes:
        scale: A step of ordinary size in each variable, shape (n,).
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
        parts = (*self.costs, *self.constraints)
        linear = (part.at_zero.rows.knots for part in parts if isinstance(part, LinearPart))
        return max(int(np.ptp(knots, axis=1).max(initial=0)) for knots in (self.support, *linear))

    @cached_property
    def core(self) -> descent.Program:
        program = descent.Program(self.lower, self.upper, self.scale, self.query)
        for part in (*self.costs, *self.constraints):
            part.add_to(program)
        return program

    def linearised(self, point: descent.Point) -> Linearisation:
        in_python = iter(cast(tuple[Block, ...], point.kept or ()))
        blocks = [
            next(in_python) if isinstance(part, PythonPart) else part.block(self.core.rows(point, number))
            for number, part in enumerate((*self.costs, *self.constraints))
        ]
        costs = tuple(block for block in blocks if isinstance(block, CostRows))
        constraints = tuple(block for block in blocks if isinstance(block, ConstraintRows))
        return Linearisation(point.x.reshape(self.lower.shape), costs, constraints, self.sampling)


class CoreCounts(Protocol):
    """Exact counts of the work done so far."""

    forward_kinematics: int
    bounds: int
    distances: int


@runtime_checkable
class CompilableNlp(Nlp, Protocol):
    """A program that the core may evaluate; its `linearise` returns the same at the same point."""

    @property
    def counts(self) -> CoreCounts:
        """The work done so far, which the core adds to."""
        ...

    def compiled(self, sampling: Ints) -> CompiledProgram | None:
        """Return the program in parts on given samples; None if a term is unknown to the core."""
        ...

    def python_rows(self, x: Floats, sampling: Ints) -> tuple[Block, ...]:
        """Return the rows of the parts that the core requests, at a point."""
        ...
