"""Certificate: the checks of a trajectory, with margins and evidence."""

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from enum import Enum
from math import isfinite
from typing import Any

from trajopt.values.errors.arguments import checked
from trajopt.values.printed import aligned, in_length, in_short, in_unit, shown_in


class Evidence(Enum):
    """Evidence for a check.

    PROVEN: at all times. SAMPLED: at samples only (one violation fails). UNPROVEN: neither proven nor
    refuted.
    """

    PROVEN = "proven"
    SAMPLED = "sampled"
    UNPROVEN = "unproven"


class CheckKind(Enum):
    """Subject of a check, independent of the names in it."""

    ENDS = "ends"
    DEADLINE = "deadline"
    LIMIT = "limit"
    TORQUE = "torque"
    CLEARANCE = "clearance"
    AT_FAULT = "clearance at fault"
    CONTACT = "contact"
    PREDICTION = "prediction"
    TOOL_SPEED = "tool speed"
    ROLLING = "rolling"
    CURVE_POSITION = "curve position"
    CURVE_ROTATION = "curve rotation"
    REQUIREMENT = "requirement"
    USER_CODE = "user code"


@dataclass(frozen=True, kw_only=True)
class Check:
    """One checked criterion.

    Attributes:
        name: Criterion: "clearance", "velocity", "goal: ...", ...
        subject: Tightest pair, joint or frame.
        value: Its value; None if not available.
        bound: Bound on the value; None for none.
        unit: Of both.
        time: Time of the tightest value [s]; None if it has none.
        slack: Distance from the value to the bound, negative in violation.
        required: Whether the verdict depends on it; False for information only.
    """

    name: str
    subject: str
    value: float | None
    bound: float | None
    unit: str
    time: float | None
    slack: float | None
    evidence: Evidence
    holds: bool
    detail: str
    required: bool = True
    kind: CheckKind = CheckKind.REQUIREMENT

    def as_dict(self) -> dict[str, Any]:
        """Return JSON data; non-finite numbers become None."""
        return _plain(self)

    @property
    def mark(self) -> str:
        """The outcome in a word: ok, FAIL, or info if the verdict does not depend on it."""
        return ("ok" if self.holds else "FAIL") if self.required else "info"

    def __repr__(self) -> str:
        value, bound = (
            "" if number is None else f"{word}{in_unit(number, self.unit)}"
            for word, number in (("", self.value), ("bound ", self.bound))
        )
        when = "" if self.time is None else f"at {self.time:.3f} s"
        parts = ", ".join(part for part in (value, bound, when, self.evidence.value) if part)
        return f"Check({self.mark}: {self.name} of {self.subject}, {parts})"

    def __str__(self) -> str:
        return f"{self.mark}: {self.name} of {self.subject}: {self.detail} ({self.evidence.value})"


@dataclass(frozen=True, kw_only=True)
class PairClearance:
    """Clearance of two links or objects that come close.

    Attributes:
        required: Required clearance [m].
        proven: Lower bound over all times without accepted contact [m]; None if unproven.
        measured: Smallest measured distance at these times, negative in penetration [m].
        time: Time of the measurement [s].
    """

    first: str
    second: str
    required: float
    proven: float | None
    measured: float
    time: float

    def __repr__(self) -> str:
        return f"PairClearance({self})"

    def __str__(self) -> str:
        proof = "not proven" if self.proven is None else f"proven {1000 * self.proven:.1f} mm"
        return (
            f"{self.first} - {self.second}: measured {1000 * self.measured:.1f} mm "
            f"at {self.time:.3f} s, {proof}, required {1000 * self.required:g} mm"
        )


@dataclass(frozen=True, kw_only=True)
class Unproven:
    """First interval without a proof of clearance, from `begin` to `end` [s]."""

    first: str
    second: str
    begin: float
    end: float

    def __repr__(self) -> str:
        return f"Unproven({self.first} - {self.second} from {self.begin:.4f} to {self.end:.4f} s)"


@dataclass(frozen=True, kw_only=True)
class Counts:
    """Work of the judge.

    Attributes:
        distances: Distances measured, or bounded over an interval.
        kinematics: Configurations with computed forward kinematics.
    """

    distances: int
    kinematics: int


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """Verdict on a trajectory.

    Attributes:
        clearance: Proven lower bound of all pair distances, at all times without accepted contact [m].
            Without a proof, the smallest measured distance. Infinite without pairs.
        at_fault: The clearance while the robot moves a body of the pair: an obstacle that approaches a link
            at rest is not its fault. Equals `clearance` in a static scene [m].
        unproven: First interval and pair without a proof of clearance, if any.
        required: Smallest and largest required clearance [m].
        margin: Smallest and largest clearance that the optimiser aimed at; not judged [m].
        notes: Assumptions and remarks.
    """

    checks: tuple[Check, ...]
    clearance: float
    at_fault: float
    pairs: tuple[PairClearance, ...]
    unproven: Unproven | None
    required: tuple[float, float]
    margin: tuple[float, float]
    counts: Counts
    notes: tuple[str, ...]

    @property
    def verified(self) -> bool:
        """Whether every required check holds."""
        return all(check.holds for check in self.checks if check.required)

    @property
    def failed(self) -> tuple[Check, ...]:
        """Required checks that do not hold."""
        return tuple(check for check in self.checks if check.required and not check.holds)

    def as_dict(self) -> dict[str, Any]:
        """Return JSON data; non-finite numbers become None."""
        result = {name.name: _plain(getattr(self, name.name)) for name in fields(self)}
        return {"verified": self.verified, **result}

    @checked
    def passing_time(self, waypoint: str) -> float | None:
        """Return when the motion passes a waypoint [s]; None if it holds at any moment."""
        begins = f"waypoint {waypoint}: "
        return next((check.time for check in self.checks if check.name.startswith(begins)), None)

    @property
    def verdict(self) -> str:
        """Summary of the outcome and the failed checks, in a sentence."""
        if self.verified:
            return f"verified: all {sum(check.required for check in self.checks)} checks hold"
        return "not verified: " + "; ".join(
            f"{check.name} ({check.detail.rstrip('.')})" for check in self.failed
        )

    @property
    def closest(self) -> str:
        """Description of the clearance."""
        if not isfinite(self.clearance):
            return "nothing to keep clear of"
        broken = any(check.kind is CheckKind.CLEARANCE for check in self.failed)
        known = "not proven" if self.unproven is not None else "measured" if broken else "proven"
        said = f"clearance {in_length(self.clearance)} {known}"
        return said if self.at_fault <= self.clearance else f"{said}, {_in_words(self.at_fault)} at fault"

    def __repr__(self) -> str:
        failed = ", ".join(check.name for check in self.failed)
        verdict = f"verified, {len(self.checks)} checks" if self.verified else f"not verified: {failed}"
        return in_short(f"Certificate({verdict}, {self.closest})")

    def __str__(self) -> str:
        return "\n".join((self.verdict, "", *_table(self.checks), *_remarks(self)))


def _in_words(clearance: float) -> str:
    return in_length(clearance) if isfinite(clearance) else "nothing"


def _table(checks: tuple[Check, ...]) -> list[str]:
    rows = [("", "check", "subject", "value", "bound", "unit", "at [s]", "slack", "evidence")]
    for check in checks:
        unit, size = shown_in(check.unit)
        value, bound, slack = (
            "" if number is None else f"{number * size + 0.0:.5g}"
            for number in (check.value, check.bound, check.slack)
        )
        if (
            check.kind in (CheckKind.CLEARANCE, CheckKind.AT_FAULT)
            and check.evidence is Evidence.PROVEN
            and value
        ):
            value = f">= {value}"  # a bound; the nearest distances that were measured stand below
        time = "" if check.time is None else f"{check.time:.3f}"
        rows.append(
            (check.mark, check.name, check.subject, value, bound, unit, time, slack, check.evidence.value)
        )
    return aligned(rows, right=frozenset((3, 4, 6, 7)))


def _remarks(certificate: Certificate) -> list[str]:
    lines = [""]
    if certificate.pairs:
        lines.append("nearest pairs:")
        lines.extend(f"  {pair}" for pair in certificate.pairs[:5])
    counts = certificate.counts
    lines.append(f"work: {counts.distances} distances, {counts.kinematics} configurations")
    lines.extend(f"note: {note}" for note in certificate.notes)
    return lines


def _plain(value: Any) -> Any:
    match value:
        case Enum():
            return value.value
        case bool() | int() | str() | None:
            return value
        case float():
            return value if isfinite(value) else None
        case tuple():
            return [_plain(item) for item in value]  # pyright: ignore[reportUnknownVariableType]
        case _:
            return {item.name: _plain(getattr(value, item.name)) for item in fields(value)}


def joined(parts: Iterable[tuple[str, float, Certificate]]) -> Certificate:
    """Return the certificate of several motions, in order.

    Args:
        parts: Name and begin [s] of each motion, and its certificate.
    """
    known = tuple(parts)
    each = [part for _, _, part in known]
    return Certificate(
        checks=tuple(
            replace(
                check,
                name=f"{name}: {check.name}",
                time=None if check.time is None else begin + check.time,
            )
            for name, begin, part in known
            for check in part.checks
        ),
        clearance=min(part.clearance for part in each),
        at_fault=min(part.at_fault for part in each),
        pairs=tuple(
            sorted(
                (replace(pair, time=begin + pair.time) for _, begin, part in known for pair in part.pairs),
                key=lambda pair: pair.measured,
            )
        ),
        unproven=next(
            (
                replace(part.unproven, begin=begin + part.unproven.begin, end=begin + part.unproven.end)
                for _, begin, part in known
                if part.unproven is not None
            ),
            None,
        ),
        required=(min(part.required[0] for part in each), max(part.required[1] for part in each)),
        margin=(min(part.margin[0] for part in each), max(part.margin[1] for part in each)),
        counts=Counts(
            distances=sum(part.counts.distances for part in each),
            kinematics=sum(part.counts.kinematics for part in each),
        ),
        notes=tuple(dict.fromkeys(note for part in each for note in part.notes)),
    )
