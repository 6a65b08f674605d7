"""Base class of requirements, parts of a motion, and registration of kinds."""

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
    """Unit of a number in reports.

    Attributes:
        name: Symbol; empty for a plain number.
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
    """Base class of all requirements.

    Your own requirement consists of three modules: its data, a term (`trajopt.optimise.terms.constrain`) and
    a check (`trajopt.verify.checks.quantities`); see docs/extending.md.
    """

    def __repr__(self) -> str:
        if type(self).__str__ is object.__str__:
            return super().__repr__()
        return f"{type(self).__name__}({self})"

    def in_full(self) -> str:
        """Describe it for a printed problem, with details that help to spot a mistake."""
        return str(self)

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of its frames and objects, by default `frame` and `reference`; checked in a problem."""
        return tuple(getattr(self, field) for field in ("frame", "reference") if hasattr(self, field))

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of its joints, checked when a problem is constructed."""
        return ()

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """Its relaxations, tried by remedies and prices; none by default."""
        return ()

    @checked
    def relaxed(
        self, field: str, what: str, largest: float, unit: ShownUnit, *, shrinks: bool = False
    ) -> Relaxation:
        """Return the relaxation of one field by up to `largest`, for `relaxations`; see `Relaxation`.

        Raises:
            ProblemError: If the requirement has no such field.
        """
        if not hasattr(self, field):
            raise ProblemError(f"field: {type(self).__name__} has no {shown(field)}")
        now, sign = float(getattr(self, field)), -1.0 if shrinks else 1.0

        def apply(amount: float) -> Requirement:
            return replace(self, **{field: now + sign * amount})

        return Relaxation(what=what, now=now, largest=largest, unit=unit, apply=apply, shrinks=shrinks)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of its violation: "m", "rad", or empty if unknown."""
        return ("",)


@dataclass(frozen=True, eq=False, kw_only=True)
class Relaxation:
    """One number of a requirement that can be relaxed: a tolerance that grows, or a bound that shrinks.

    Attributes:
        what: Name of the number in reports.
        apply: Returns the requirement relaxed by an amount.
    """

    what: str
    now: float
    largest: float
    unit: ShownUnit
    apply: Callable[[float], Requirement]
    shrinks: bool = False

    def words(self, amount: float) -> str:
        """Describe the change by an amount."""
        unit, after = self.unit, self.now - amount if self.shrinks else self.now + amount
        return f"{self.what} {self.now / unit.size:.3g} to {after / unit.size:.6g} {unit.name}".rstrip()


GROUP = "trajopt.requirements"
"""Entry-point group in which packages name the modules that register their requirements."""

Result_co = TypeVar("Result_co", covariant=True)


class Dispatch(Protocol[Result_co]):
    """A function of `functools.singledispatch`."""

    @property
    def registry(self) -> Mapping[Any, Callable[..., Result_co]]:
        """Registered functions by class."""
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
    """Import the modules of a package that are named like the modules of a built-in kind and its bases.

    Args:
        kind: Class of a requirement, such as `trajopt.problem.requirements.frames.Gaze`.
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
    """Whether a function is registered for a kind of requirement."""
    return dispatch.dispatch(kind) is not dispatch.registry[object]


def registered(dispatch: Dispatch[Result_co], kind: type[Requirement], what: str) -> Callable[..., Result_co]:
    """Return the function registered for a kind of requirement.

    Installed packages are imported before an error is raised.

    Args:
        what: Name of the registered function in the error.
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
    """A requirement on a part of the motion, ends included."""

    required: Required_co
    after: str | None
    until: str | None

    @property
    def part(self) -> str:
        """Description of the part."""
        return f"from {self.after or 'the start'} to {self.until or 'the end'}"

    def __str__(self) -> str:
        return f"{self.required}, {self.part}"


@checked
def during(required: Required, *, after: str | None = None, until: str | None = None) -> During[Required]:
    """Require something on a part of the motion only.

    Args:
        required: Requirement, or a constraint on a residual.
        after: Name of the waypoint from which it holds; the start by default.
        until: Name of the waypoint up to which it holds; the end by default.

    Raises:
        ProblemError: If neither `after` nor `until` is given.
    """
    if after is None and until is None:
        raise ProblemError("during: name the waypoint from which or up to which it holds")
    return During(required, after, until)
