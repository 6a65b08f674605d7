"""The base of every requirement, parts of a motion, alternative goals, and how kinds register."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from trajopt.values.arrays import Value
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked


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
    def relaxations(self) -> tuple[Relaxation, ...]:
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
    ) -> Relaxation:
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


GROUP = "trajopt.requirements"
"""Entry-point group in which packages name the modules that register their kinds of requirements."""

Result_co = TypeVar("Result_co", covariant=True)


class Dispatch(Protocol[Result_co]):
    """A function of `functools.singledispatch`."""

    @property
    def registry(self) -> Mapping[Any, Callable[..., Result_co]]:
        """The functions by class."""
        ...

    def dispatch(self, cls: Any) -> Callable[..., Result_co]:
        """Return the function for a class."""
        ...


@checked
def import_modules(package: str) -> None:
    """Import all modules of a package, without its subpackages, so that they register their functions."""
    for item in iter_modules(import_module(package).__path__):
        if not item.ispkg:
            import_module(f"{package}.{item.name}")


def import_subject(kind: type[Requirement], package: str) -> None:
    """Import the modules of a package that are named after the subjects of a built-in kind and its bases.

    Args:
        kind: The class of a requirement, such as `trajopt.problem.requirements.frames.Gaze`.
        package: A package with a module of the same name, `frames`.
    """
    for base in kind.__mro__:
        home, _, subject = base.__module__.rpartition(".")
        if home == f"{__package__}.requirements":
            import_module(f"{package}.{subject}")


def import_installed() -> None:
    """Import the modules that installed packages name in the entry-point group."""
    for entry in entry_points(group=GROUP):
        entry.load()


def has(dispatch: Dispatch[object], kind: type[Requirement]) -> bool:
    """Say whether a function is registered for a kind of requirement."""
    return dispatch.dispatch(kind) is not dispatch.registry[object]


def registered(dispatch: Dispatch[Result_co], kind: type[Requirement], what: str) -> Callable[..., Result_co]:
    """Return the function that is registered for a kind of requirement.

    Installed packages are imported before it counts as missing.

    Args:
        dispatch: The function that dispatches.
        kind: The class of the requirement.
        what: What it registers, for the error.

    Raises:
        ProblemError: If there is none.
    """
    if not has(dispatch, kind):
        import_installed()
    if not has(dispatch, kind):
        raise ProblemError(
            f"no {what} is registered for {kind.__name__}: import the module that registers it, or name that "
            f"module in the entry-point group {shown(GROUP)}"
        )
    return dispatch.dispatch(kind)


Required_co = TypeVar("Required_co", covariant=True)
Required = TypeVar("Required")


@dataclass(frozen=True)
class During(Generic[Required_co]):
    """Something that must hold on a part of the motion, its ends included.

    Attributes:
        required: What must hold there.
        after: The waypoint from which it holds; None for the start.
        until: The waypoint up to which it holds; None for the end.
    """

    required: Required_co
    after: str | None
    until: str | None

    @property
    def part(self) -> str:
        """The part in words."""
        return f"from {self.after or 'the start'} to {self.until or 'the end'}"

    def __str__(self) -> str:
        """Show what must hold, and where."""
        return f"{self.required}, {self.part}"


@checked
def during(required: Required, *, after: str | None = None, until: str | None = None) -> During[Required]:
    """Require something on a part of the motion only.

    Args:
        required: What must hold there: a requirement, or a constraint on a residual.
        after: Name of the waypoint from which it holds; from the start on when None.
        until: Name of the waypoint up to which it holds; to the end when None.

    Raises:
        ProblemError: If it is for the whole motion, which needs no `during`.
    """
    if after is None and until is None:
        raise ProblemError("during: name the waypoint from which or up to which it holds")
    return During(required, after, until)
