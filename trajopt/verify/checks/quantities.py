"""Checks of requirements: kinds register `quantities` (numbers with bounds) or `check_requirement`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import singledispatch

import numpy as np

from trajopt.problem.requirement import Requirement, has, import_installed, import_subject, registered
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_unit_apart
from trajopt.verify.certificate import Check, Evidence
from trajopt.verify.kernel.interval_proof import Excess, Proof, prove_over_time
from trajopt.verify.kernel.motion import JudgedMotion, sampled_times


class When(Enum):
    """Time at which a requirement has to hold."""

    END = "goal"
    ALWAYS = "path"


@dataclass(frozen=True, eq=False)
class Component:
    """One number of a requirement at its tightest moment.

    Attributes:
        tolerance: Its largest accepted size [unit].
    """

    name: str
    value: float
    tolerance: float


def tightest(names: tuple[str, ...], values: Floats, tolerances: Floats) -> Component:
    at = int(np.argmax(values - tolerances))
    return Component(names[at], float(values[at]), float(tolerances[at]))


def requirement_check(
    when: When,
    *,
    kind: str,
    subject: str,
    unit: str,
    component: Component,
    proof: Proof,
) -> Check:
    """Return the check of a requirement whose numbers must stay below tolerances.

    Args:
        kind: Kind of the number, such as "position".
    """
    here, accepted = in_unit_apart(component.value, component.tolerance, unit)
    many = f"{component.name} is {here}, {accepted} is accepted"
    if proof.interval is not None:
        many += f"; no proof from {proof.interval[0]:.5f} to {proof.interval[1]:.5f} s"
    return Check(
        name=f"{when.value}: {kind}",
        subject=subject,
        value=component.value,
        bound=component.tolerance,
        unit=unit,
        time=proof.time,
        slack=component.tolerance - component.value,
        evidence=proof.evidence,
        holds=proof.evidence is Evidence.PROVEN,
        detail=many,
    )


def proof_at_end(motion: JudgedMotion, excess: float) -> Proof:
    evidence = Evidence.PROVEN if excess <= motion.options.excess else Evidence.SAMPLED
    return Proof(evidence, motion.duration, None)


_MOMENT = 1e-6
"""Duration of the motion that represents one moment [s]."""

Bound = Callable[[Floats, Floats, Floats], Floats]
"""Begin and end of intervals, (c,) each [s], and the states at begin, middle and end, (3, c, ...) -> upper
bound of the excess (the number minus its bound, or the reverse for a lower bound), (c,).
"""


@dataclass(frozen=True, eq=False, kw_only=True)
class Quantity:
    """A number along a motion, with a bound.

    Attributes:
        least: Whether the bound is a lower one.
        states: Times (c,) -> state from which the number is computed, shape (c, ...).
        number: States -> number, shape (c,).
        bound: Bounds the excess over intervals; None if the number is only sampled.
    """

    kind: str
    name: str
    subject: str
    unit: str
    limit: float
    states: Callable[[Floats], Floats]
    number: Callable[[Floats], Floats]
    bound: Bound | None
    least: bool = False

    def excess(self, states: Floats) -> Floats:
        over = self.number(states) - self.limit
        return -over if self.least else over

    def check(self, motion: JudgedMotion, when: When) -> Check:
        """Judge the number on a motion."""
        proof = self._proof(motion, when)
        value = float(self.number(self.states(np.array((proof.time,))))[0])
        slack = value - self.limit if self.least else self.limit - value
        here, limit = in_unit_apart(value, self.limit, self.unit)
        words = f"{self.name} is {here}, at {'least' if self.least else 'most'} {limit} is accepted"
        if proof.interval is not None:
            words += f"; no proof from {proof.interval[0]:.5f} to {proof.interval[1]:.5f} s"
        sampled = when is When.ALWAYS and self.bound is None
        return Check(
            name=f"{when.value}: {self.kind}",
            subject=self.subject,
            value=value,
            bound=self.limit,
            unit=self.unit,
            time=proof.time,
            slack=slack,
            evidence=proof.evidence,
            holds=slack >= -motion.options.excess if sampled else proof.evidence is Evidence.PROVEN,
            detail=words,
        )

    def _proof(self, motion: JudgedMotion, when: When) -> Proof:
        if when is When.END:
            return proof_at_end(motion, float(self.excess(self.states(np.array((motion.duration,))))[0]))
        if self.bound is None:
            times = sampled_times(motion)
            return Proof(Evidence.SAMPLED, float(times[self.excess(self.states(times)).argmax()]), None)
        bound = self.bound

        def excess(begin: Floats, end: Floats) -> Excess:
            times = np.concatenate((begin, (begin + end) / 2.0, end))
            states = self.states(times)
            over = self.excess(states).reshape(3, -1)
            worst, rows = over.argmax(axis=0), np.arange(len(begin))
            return Excess(
                over[worst, rows],
                times.reshape(3, -1)[worst, rows],
                bound(begin, end, states.reshape(3, len(begin), *states.shape[1:])),
            )

        return prove_over_time(motion, excess)


def checks_of(quantities: Sequence[Quantity], motion: JudgedMotion, when: When) -> tuple[Check, ...]:
    return tuple(quantity.check(motion, when) for quantity in quantities)


@singledispatch
def quantities(requirement: Requirement, motion: JudgedMotion) -> tuple[Quantity, ...]:
    """Return the numbers that a requirement bounds, along a motion.

    A kind with only a check is judged by it at each moment.
    """
    kind = type(requirement)
    _load(kind)
    if has(quantities, kind) or not has(check_requirement, kind):
        return registered(quantities, kind, "check")(requirement, motion)
    check = check_requirement.dispatch(kind)

    def excess(times: Floats) -> Floats:
        moments = (motion.between(max(time - _MOMENT, 0.0), max(time, _MOMENT)) for time in times.tolist())
        return np.array([max(map(_excess, check(requirement, at, When.END)), default=0.0) for at in moments])

    return (
        Quantity(
            kind=kind.__name__,
            name="excess",
            subject=", ".join((*requirement.frames, *requirement.joints)),
            unit="",
            limit=0.0,
            states=lambda times: times,
            number=excess,
            bound=None,
        ),
    )


def _load(kind: type[Requirement]) -> None:
    if not (has(quantities, kind) or has(check_requirement, kind)):
        import_subject(kind, "trajopt.verify.checks")
    if not (has(quantities, kind) or has(check_requirement, kind)):
        import_installed()


def _excess(check: Check) -> float:
    if check.slack is None:
        return 0.0 if check.holds else np.inf
    return -check.slack


@singledispatch
def check_requirement(requirement: Requirement, motion: JudgedMotion, when: When) -> tuple[Check, ...]:
    """Check a requirement on a motion by its numbers, or by its kind's own check.

    Raises:
        ProblemError: If the kind registers neither numbers nor a check.
        NameNotFound: If the requirement names an unknown frame, joint or object.
    """
    kind = type(requirement)
    _load(kind)
    if has(check_requirement, kind):
        return check_requirement.dispatch(kind)(requirement, motion, when)
    return checks_of(quantities(requirement, motion), motion, when)
