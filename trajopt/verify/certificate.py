"""The judge's verdict on a trajectory: what holds, by how much, and how well that is known."""

from dataclasses import dataclass, fields
from enum import Enum
from math import isfinite
from typing import Any

from trajopt.values.printed import aligned, in_length, in_short, in_unit, shown_in


class Evidence(Enum):
    """How a verdict is known.

    PROVEN for every time; SAMPLED at samples only (one is enough to break a check); UNPROVEN when
    neither a proof nor a violation was found, which does not pass.
    """

    PROVEN = "proven"
    SAMPLED = "sampled"
    UNPROVEN = "unproven"


class CheckKind(Enum):
    """What a check is about, independent of the particulars in its name."""

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
    """One thing that was judged.

    Attributes:
        name: What was judged: "clearance", "velocity", "goal: ...", ...
        subject: The pair, joint or frame where it is tightest.
        value: The value there; None if none can be stated.
        bound: What the value must not pass; None for none.
        unit: Unit of both.
        time: When it is tightest [s]; None if at no particular time.
        slack: Distance from the value to the bound, negative when it is passed.
        evidence: How this is known.
        holds: Whether the check is passed.
        detail: A sentence.
        required: Whether the verdict depends on it; False for information only.
        kind: What it is about.
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
        """Return plain data that JSON can hold; numbers that are not finite become None."""
        return _plain(self)

    @property
    def mark(self) -> str:
        """Whether it holds, in a word: ok, FAIL, or info where the verdict does not depend on it."""
        return ("ok" if self.holds else "FAIL") if self.required else "info"

    def __repr__(self) -> str:
        """Say in one line what was judged, where and when it is tightest, and how that is known."""
        value, bound = (
            "" if number is None else f"{word}{in_unit(number, self.unit)}"
            for word, number in (("", self.value), ("bound ", self.bound))
        )
        when = "" if self.time is None else f"at {self.time:.3f} s"
        parts = ", ".join(part for part in (value, bound, when, self.evidence.value) if part)
        return f"Check({self.mark}: {self.name} of {self.subject}, {parts})"

    def __str__(self) -> str:
        """Return the verdict with its sentence."""
        return f"{self.mark}: {self.name} of {self.subject}: {self.detail} ({self.evidence.value})"


@dataclass(frozen=True, kw_only=True)
class PairClearance:
    """Clearance of two links or objects that came near each other.

    Attributes:
        first: One link or object.
        second: The other.
        required: Clearance that was required [m].
        proven: Lower bound over all time at which contact is not accepted [m]; None if unproven.
        measured: Smallest measured clearance at such times, negative in penetration [m].
        time: When that was measured [s].
    """

    first: str
    second: str
    required: float
    proven: float | None
    measured: float
    time: float

    def __repr__(self) -> str:
        """Say the pair and its clearances in millimetres."""
        return f"PairClearance({self})"

    def __str__(self) -> str:
        """Return the pair and its clearances in millimetres."""
        proof = "not proven" if self.proven is None else f"proven {1000 * self.proven:.1f} mm"
        return (
            f"{self.first} - {self.second}: measured {1000 * self.measured:.1f} mm "
            f"at {self.time:.3f} s, {proof}, required {1000 * self.required:g} mm"
        )


@dataclass(frozen=True, kw_only=True)
class Unproven:
    """The first interval over which a pair could not be proven to keep apart.

    Attributes:
        first: One link or object.
        second: The other.
        begin: Start of the interval [s].
        end: Its end [s].
    """

    first: str
    second: str
    begin: float
    end: float

    def __repr__(self) -> str:
        """Say the pair and the interval."""
        return f"Unproven({self.first} - {self.second} from {self.begin:.4f} to {self.end:.4f} s)"


@dataclass(frozen=True, kw_only=True)
class Counts:
    """The work that judging took.

    Attributes:
        distances: Distances measured, or proven to be large enough over an interval.
        kinematics: Configurations at which forward kinematics was computed.
    """

    distances: int
    kinematics: int


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """The judge's verdict on a trajectory.

    Attributes:
        checks: Everything that was judged.
        clearance: Proven lower bound of the distance between any two bodies that must keep apart,
            at all times at which their contact is not accepted [m]. If there is no proof it is
            the smallest measured one. Infinite where no pair has to keep apart.
        at_fault: The same of the times at which a link of the pair, or what it carries, moves: what comes
            near a link at rest is not the robot's fault. The motion is verified only if it is clear at
            all times. Where nothing changes with time, the clearance itself [m].
        pairs: Pairs that came near each other, nearest first.
        unproven: First interval and pair without proof of clearance, if there is one.
        required: Smallest and largest clearance that was required, and is proven of a verified motion [m].
        margin: Smallest and largest clearance that the optimiser aimed at, which is not judged [m].
        counts: The work that judging took.
        notes: What a reader should know besides.
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
        """The required checks that do not hold."""
        return tuple(check for check in self.checks if check.required and not check.holds)

    def as_dict(self) -> dict[str, Any]:
        """Return plain data that JSON can hold; numbers that are not finite become None."""
        result = {name.name: _plain(getattr(self, name.name)) for name in fields(self)}
        return {"verified": self.verified, **result}

    @property
    def verdict(self) -> str:
        """Whether the motion is verified, and which checks fail and why, in a sentence."""
        if self.verified:
            return f"verified: all {sum(check.required for check in self.checks)} checks hold"
        return "not verified: " + "; ".join(
            f"{check.name} ({check.detail.rstrip('.')})" for check in self.failed
        )

    @property
    def closest(self) -> str:
        """How far everything keeps apart, in words."""
        if not isfinite(self.clearance):
            return "nothing to keep clear of"
        broken = any(check.kind is CheckKind.CLEARANCE for check in self.failed)
        known = "not proven" if self.unproven is not None else "measured" if broken else "proven"
        said = f"clearance {in_length(self.clearance)} {known}"
        return said if self.at_fault <= self.clearance else f"{said}, {_in_words(self.at_fault)} at fault"

    def __repr__(self) -> str:
        """Say the verdict and the clearance."""
        failed = ", ".join(check.name for check in self.failed)
        verdict = f"verified, {len(self.checks)} checks" if self.verified else f"not verified: {failed}"
        return in_short(f"Certificate({verdict}, {self.closest})")

    def __str__(self) -> str:
        """Return the verdict, an aligned table of the checks, and the notes."""
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
