"""The base of every requirement, and what several of them need."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from trajopt.values.arrays import Value


@dataclass(frozen=True)
class ShownUnit:
    """Unit in which reports show a number.

    Attributes:
        name: Its sign; empty for a plain number.
        size: One of it, in the unit of the number itself.
        base: Unit of the number itself: "m", "rad", or empty.
    """

    name: str
    size: float
    base: str


MILLIMETRES = ShownUnit("mm", 1e-3, "m")
DEGREES = ShownUnit("deg", np.pi / 180.0, "rad")
RADIANS = ShownUnit("rad", 1.0, "rad")
PERCENT = ShownUnit("%", 0.01, "")
PLAIN = ShownUnit("", 1.0, "")


@dataclass(frozen=True)
class Requirement(Value):
    """Base of everything that a motion can be required to hold.

    A class of your own is three modules: the data, a term (`trajopt.optimise.terms.constrain`) and a check
    (`trajopt.verify.checks.quantities`); docs/extending.md shows them.
    """

    def __repr__(self) -> str:
        """Show its kind and what it says, or its fields where it says nothing."""
        if type(self).__str__ is object.__str__:
            return super().__repr__()
        return f"{type(self).__name__}({self})"

    def in_full(self) -> str:
        """Say it as in a printed problem: with what helps to see whether it is what was meant."""
        return str(self)

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames and objects it names, so that a problem with unknown ones is an error at once."""
        return ()

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it names, likewise."""
        return ()

    @property
    def relaxations(self) -> "tuple[Relaxation, ...]":
        """How it can be relaxed: remedies and prices try these; none by default."""
        return ()

    @property
    def units(self) -> tuple[str, ...]:
        """The units in which its violation is measured: "m", "rad", or empty if not known."""
        return ("",)


@dataclass(frozen=True, eq=False, kw_only=True)
class Relaxation:
    """One number of a requirement that can be relaxed: a tolerance that grows, or a bound that shrinks.

    Attributes:
        what: What the number bounds.
        now: The number.
        largest: By how much it can be relaxed at most.
        unit: Unit in which it is shown.
        apply: Returns the requirement relaxed by an amount.
        shrinks: Whether the number gets smaller.
    """

    what: str
    now: float
    largest: float
    unit: ShownUnit
    apply: Callable[[float], Requirement]
    shrinks: bool = False

    @staticmethod
    def of(
        required: Requirement,
        field: str,
        what: str,
        *,
        largest: float,
        unit: ShownUnit,
        shrinks: bool = False,
    ) -> "Relaxation":
        """Relax one field of a requirement.

        Args:
            required: The requirement.
            field: Name of the field, a number.
            what: What it bounds.
            largest: By how much it can be relaxed at most.
            unit: Unit in which it is shown.
            shrinks: Whether the number gets smaller.
        """
        now, sign = float(getattr(required, field)), -1.0 if shrinks else 1.0

        def apply(amount: float) -> Requirement:
            return replace(required, **{field: now + sign * amount})

        return Relaxation(what=what, now=now, largest=largest, unit=unit, apply=apply, shrinks=shrinks)

    def words(self, amount: float) -> str:
        """State the change by an amount."""
        unit, after = self.unit, self.now - amount if self.shrinks else self.now + amount
        return f"{self.what} {self.now / unit.size:.3g} to {after / unit.size:.3g} {unit.name}".rstrip()
