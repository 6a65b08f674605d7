"""Clearance of all pairs of bodies: at all times, and while the robot moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from trajopt.values.arrays import Bools, Floats, Ints, runs_of
from trajopt.verify.certificate import Check, CheckKind, Evidence, PairClearance, Unproven
from trajopt.verify.kernel.clearance_search import Contact, Findings, Tally, search_clearance
from trajopt.verify.kernel.motion import JudgedMotion, Polynomials
from trajopt.verify.kernel.pair_distances import PairDistances, rows
from trajopt.verify.specification import Criterion, FoundContact

if TYPE_CHECKING:
    from trajopt.scene.clearances import ContactAllowance

_PROBES = 17
_FOLLOWED = 8
"""Number of pairs in contact followed to their deepest contact."""
_DEEPER = 5e-6
"""Difference of depth at which one contact replaces another: the resolution of depths [m]."""


@dataclass(frozen=True)
class ClearanceFinding:
    """Result of the search for a proof of clearance.

    Attributes:
        checks: One for each required clearance, or kind of pairs, and one for each contact allowance. After
            an early end, only violated and unproven ones.
        clearance: Proven lower bound, or the smallest measured distance without a proof [m].
    """

    search: Findings
    checks: tuple[Check, ...]
    clearance: float
    pairs: tuple[PairClearance, ...]
    unproven: Unproven | None
    worst: Contact | None


@dataclass(frozen=True, eq=False)
class ClearanceCriterion(Criterion):
    """Clearance of every pair, and depth of accepted contacts."""

    motion: JudgedMotion
    distances: PairDistances

    def holds(self) -> bool:
        return self._decided.proven

    @property
    def contact(self) -> FoundContact | None:
        """The first contact found that is not accepted."""
        found = min(self._decided.contacts, key=lambda contact: contact.time, default=None)
        return None if found is None else FoundContact(*self.distances.owners(found.pair), found.time)

    @cached_property
    def _decided(self) -> Findings:
        return search_clearance(self.motion, self.distances, measured=False)

    def measure(self) -> tuple[Check, ...]:
        return self.finding.checks

    @cached_property
    def finding(self) -> ClearanceFinding:
        return judge_clearance(self.motion, self.distances)


def judge_clearance(motion: JudgedMotion, distances: PairDistances) -> ClearanceFinding:
    """Search for a proof of clearance of all pairs, and return the checks."""
    search = search_clearance(motion, distances)
    required, names = search.windows.required, rows(motion.reduced)
    contacts = [followed(motion, search, distances, pairs) for _, pairs in names]
    proven = not any(contacts) and search.gap is None
    unproven = None
    if search.gap is not None:
        first, second = distances.owners(search.gap.pair)
        unproven = Unproven(first=first, second=second, begin=search.gap.begin, end=search.gap.end)
    bound = float(search.free.proven.min(initial=np.inf)) if proven else search.free.best()
    found: list[Check] = []
    for (name, pairs), broken in zip(names, contacts, strict=True):
        if broken:
            check = _broken_check(motion, distances, broken[0], float(required[broken[0].pair]))
        elif search.gap is not None and not any(contacts) and search.gap.pair in pairs:
            assert unproven is not None
            check = _unproven_check(search, distances, pairs, unproven)
        elif proven:
            alone = [other for other, _ in names].count(name) == 1
            check = _proven_check(search, distances, pairs, alone=alone)
        else:
            continue
        found.append(replace(check, name=name))
    if not names:
        found.append(
            clearance_check("", None, 0.0, None, Evidence.PROVEN, "no pair of bodies has to keep apart")
        )
    checks = (*found, *_contact_checks(motion, search, proven=proven))
    worst = min((each[0] for each in contacts if each), key=lambda contact: contact.distance, default=None)
    pairs = _pairs(motion, search, distances, proven=proven)
    return ClearanceFinding(search, checks, bound, pairs, unproven, worst)


def followed(
    motion: JudgedMotion, search: Findings, distances: PairDistances, pairs: Ints
) -> tuple[Contact, ...]:
    """Follow contacts of m pairs, shape (m,), to their deepest; the deepest comes first, more precisely."""
    mine = [contact for contact in search.deepest() if contact.pair in pairs]
    found = [_deepest(motion, search, distances, contact) for contact in mine[:_FOLLOWED]]
    for contact in found:
        search.correct(contact)
    sure: set[int] = set()
    while found:
        found.sort(key=lambda contact: contact.distance)
        worst = found[0]
        if worst.pair in sure:
            break
        sure.add(worst.pair)
        poses = motion.poses(np.array([worst.time]))
        depth = distances.search_depths(poses, np.zeros(1, dtype=np.int64), np.array([worst.pair]))[0]
        most = 0.0 if search.excused(worst) else float(search.windows.required[worst.pair])
        found[0] = Contact(worst.pair, worst.time, min(max(worst.distance, float(depth)), most))
        search.correct(found[0])
    return tuple(found)


def _deepest(motion: JudgedMotion, search: Findings, distances: PairDistances, contact: Contact) -> Contact:
    best, excused = contact, search.excused(contact)
    reach = motion.duration / 16
    for _ in range(3):
        begin, end = max(best.time - reach, 0.0), min(best.time + reach, motion.duration)
        times = np.linspace(begin, end, _PROBES)
        pair = np.full(_PROBES, contact.pair, dtype=np.int64)
        found = distances.measure(motion.poses(times), np.arange(_PROBES), pair)
        for time, distance in zip(times.tolist(), found.tolist(), strict=True):
            probe = Contact(contact.pair, time, distance)
            if distance < best.distance - _DEEPER and search.excused(probe) == excused:
                best = probe
        reach /= _PROBES / 3
    return best


def _broken_check(motion: JudgedMotion, distances: PairDistances, contact: Contact, required: float) -> Check:
    name, over = distances.pair_name(contact.pair), motion.trajectory.duration
    after = f", {contact.time - over:.3f} s after the end" if contact.time > over else ""
    if contact.distance > 0.0:
        words = f"{name} come within {1000 * contact.distance:.2f} mm of each other at {contact.time:.3f} s"
        words += f"{after}, {1000 * required:g} mm are required"
    else:
        words = f"{name} are {-1000 * contact.distance:.2f} mm into each other at {contact.time:.3f} s{after}"
    return clearance_check(name, contact.distance, required, contact.time, Evidence.SAMPLED, words)


def _unproven_check(search: Findings, distances: PairDistances, pairs: Ints, unproven: Unproven) -> Check:
    tightest, time = tightest_of(search, pairs)
    required = float(search.windows.required[tightest])
    words = (
        f"no proof that {unproven.first} and {unproven.second} keep {_apart(required)} "
        f"from {unproven.begin:.5f} to {unproven.end:.5f} s"
    )
    value = float(search.free.measured[tightest])
    return clearance_check(distances.pair_name(tightest), value, required, time, Evidence.UNPROVEN, words)


def _proven_check(search: Findings, distances: PairDistances, pairs: Ints, *, alone: bool) -> Check:
    tightest, time = tightest_of(search, pairs)
    required, bound = float(search.windows.required[tightest]), float(search.free.proven[pairs].min())
    if not np.isfinite(bound):
        return clearance_check("", None, required, None, Evidence.PROVEN, "contact is accepted all the time")
    which = "every pair" if alone else f"every pair of which {1000 * required:g} mm are required"
    words = f"{which} keeps at least {1000 * bound:.2f} mm apart at all times"
    if alone and required > 0.0:
        words += f", {1000 * required:g} mm are required"
    # Where nothing came near enough to be measured, the bound is of all pairs, and no pair is the nearest.
    subject = "no pair is near" if time is None else distances.pair_name(tightest)
    return clearance_check(subject, bound, required, time, Evidence.PROVEN, words)


def tightest_of(search: Findings, pairs: Ints) -> tuple[int, float | None]:
    """Return the nearest of some pairs, and the time of its measurement [s], if any."""
    measured = search.free.measured[pairs]
    tightest = int(pairs[measured.argmin()])
    if np.isfinite(search.free.measured[tightest]):
        return tightest, float(search.free.time[tightest])
    return int(pairs[search.free.proven[pairs].argmin()]), None


def _apart(required: float) -> str:
    return f"{1000 * required:g} mm apart" if required > 0.0 else "apart"


def clearance_check(
    subject: str, value: float | None, required: float, time: float | None, evidence: Evidence, detail: str
) -> Check:
    """Return the check of a pair's clearance [m]; it holds if proven."""
    return Check(
        kind=CheckKind.CLEARANCE,
        name="clearance",
        subject=subject,
        value=value,
        bound=required,
        unit="m",
        time=time,
        slack=None if value is None else value - required,
        evidence=evidence,
        holds=evidence is Evidence.PROVEN,
        detail=detail,
    )


def _contact_checks(motion: JudgedMotion, search: Findings, *, proven: bool) -> tuple[Check, ...]:
    checks: list[Check] = []
    by_allowance: dict[ContactAllowance, list[int]] = {}
    for pair, allowance in motion.reduced.pairs.allowances:
        by_allowance.setdefault(allowance, []).append(pair)
    for allowance, pairs in by_allowance.items():
        lowest = pairs[int(search.accepted.measured[pairs].argmin())]
        measured = float(search.accepted.measured[lowest] + motion.reduced.pairs.error[lowest])
        depth = max(-measured, 0.0) if np.isfinite(measured) else None
        broken = any(contact.pair in pairs and search.excused(contact) for contact in search.contacts)
        if not (proven or broken):
            continue
        when = [f"the first {allowance.first:g} s"] * (allowance.first > 0.0)
        when += [f"the last {allowance.last:g} s"] * (allowance.last > 0.0)
        checks.append(
            Check(
                kind=CheckKind.CONTACT,
                name=f"contact: {allowance.name}",
                subject=f"{allowance.a} - {allowance.b}",
                value=depth,
                bound=allowance.depth,
                unit="m",
                time=None if depth is None else float(search.accepted.time[lowest]),
                slack=None if depth is None else allowance.depth - depth,
                evidence=Evidence.PROVEN if proven else Evidence.SAMPLED,
                holds=proven,
                detail=f"measured depth of the contact accepted in {' and '.join(when)}",
            )
        )
    return tuple(checks)


def _pairs(
    motion: JudgedMotion, search: Findings, distances: PairDistances, *, proven: bool
) -> tuple[PairClearance, ...]:
    tally: Tally = search.free
    near = np.flatnonzero(tally.measured <= motion.options.far)
    nearest = near[np.argsort(tally.measured[near], kind="stable")]
    code, nearest_of = distances.owner_pairs, dict[int, int]()
    for pair in nearest.tolist():
        nearest_of.setdefault(int(code[pair]), pair)
    found: list[PairClearance] = []
    for pair in nearest_of.values():
        first, second = distances.owners(pair)
        found.append(
            PairClearance(
                first=first,
                second=second,
                required=float(search.windows.required[pair]),
                proven=float(tally.proven[code == code[pair]].min()) if proven else None,
                measured=float(tally.measured[pair]),
                time=float(tally.time[pair]),
            )
        )
    return tuple(found)


NEVER = (inf, -inf)
"""Empty time span."""


@dataclass(frozen=True, eq=False)
class AtFaultCriterion(Criterion):
    """Clearance of the links and attached objects while they move; for information only."""

    clearance: ClearanceCriterion

    def holds(self) -> bool:
        return True

    def measure(self) -> Iterator[Check]:
        yield _judged(self.clearance.motion, self.clearance.distances, self.clearance.finding)


def _judged(motion: JudgedMotion, distances: PairDistances, found: ClearanceFinding) -> Check:
    search, rounds = found.search, moving_spans(motion, distances)
    required, worst = search.windows.required, found.worst
    if worst is not None and any(
        spans[worst.pair, 0] < worst.time < spans[worst.pair, 1] for spans in rounds
    ):
        return _broken(distances, worst, float(required[worst.pair]))
    searches = [search_clearance(motion, distances, present=spans) for spans in rounds]
    every = np.arange(len(distances.first))
    contacts = [contact for search in searches for contact in followed(motion, search, distances, every)]
    if contacts:
        worst = min(contacts, key=lambda contact: contact.distance)
        return _broken(distances, worst, float(required[worst.pair]))
    return _without_contact(distances, searches, found.clearance if search.proven else -inf)


def _broken(distances: PairDistances, worst: Contact, required: float) -> Check:
    name, away = distances.pair_name(worst.pair), 1000 * worst.distance
    how = f"{away:.2f} mm from" if away > 0.0 else f"{-away:.2f} mm into"
    words = f"{name} come {how} each other at {worst.time:.3f} s, while the robot's part of them moves"
    return _check(name, worst.distance, required, worst.time, Evidence.SAMPLED, words)


def _without_contact(distances: PairDistances, searches: Sequence[Findings], always: float) -> Check:
    """Return the clearance at fault if no contact is: proven at least as far as that at all times [m]."""
    gap = next((search.gap for search in searches if search.gap is not None), None)
    nearest = min(searches, key=_bound)
    bound = max(_bound(nearest), always)
    if gap is None and bound == inf:
        return _check("", None, 0.0, None, Evidence.PROVEN, "nothing comes near a moving link")
    pair, time = tightest_of(nearest, np.arange(len(distances.first)))
    required = float(nearest.windows.required[pair])
    if gap is not None:
        name = distances.pair_name(gap.pair)
        words = f"no proof for {name} from {gap.begin:.5f} to {gap.end:.5f} s"
        return _check(name, nearest.free.best(), required, time, Evidence.UNPROVEN, words)
    subject = "no pair is near" if time is None else distances.pair_name(pair)
    words = f"nothing comes nearer than {1000 * bound:.2f} mm to a link while it moves"
    return _check(subject, bound, required, time, Evidence.PROVEN, words)


def moving_spans(motion: JudgedMotion, distances: PairDistances) -> list[Floats]:
    """Return time spans in which pairs are examined, each of shape (p, 2) [s].

    A pair with a dynamic obstacle is examined while the robot moves its body and both are present. All other
    pairs are examined once, at all times.
    """
    rounds = [np.where(distances.changing[:, None], NEVER, (-inf, inf))]
    times, patterns = motion.trajectory.times, _moved(motion, distances)
    ends: Floats = np.concatenate(((-inf,), times[1:-1], (times[-1] if motion.staying > 0.0 else inf,)))
    for moved in np.unique(patterns[distances.changing], axis=0):
        pairs = np.flatnonzero(distances.changing & (patterns == moved).all(axis=1))
        for number, (begin, end) in enumerate(_spans(moved, ends)):
            if number == len(rounds):
                rounds.append(np.tile(NEVER, (len(patterns), 1)))
            rounds[number][pairs] = begin, end
    if (present := distances.present_since(motion.clock)) is not None:
        for spans in rounds:
            np.maximum(spans[:, 0], present[:, 0], out=spans[:, 0])
            np.minimum(spans[:, 1], present[:, 1], out=spans[:, 1])
    return rounds


def _moved(motion: JudgedMotion, distances: PairDistances) -> Bools:
    trajectory, reduced, kinematics = motion.trajectory, motion.reduced, motion.kinematics
    velocity = Polynomials(trajectory.times, trajectory.coefficients).derivative()
    low, high = velocity.range(trajectory.times[:-1], trajectory.times[1:])
    runs = np.maximum(high, -low) > motion.options.rest_speed
    own = np.abs(reduced.mimic_matrix[:, : runs.shape[1]]) @ runs.T > 0.0
    of_body = np.array(
        [own[[joint - 1 for joint in kinematics.chain(body.joint)]].any(axis=0) for body in reduced.bodies]
    )
    return of_body[distances.first] | of_body[distances.second]


def _spans(moved: Bools, ends: Floats) -> list[tuple[float, float]]:
    return [(float(ends[begin]), float(ends[end])) for begin, end in runs_of(moved).tolist()]


def _bound(search: Findings) -> float:
    return float(search.free.proven.min(initial=inf)) if search.proven else search.free.best()


def _check(
    subject: str, value: float | None, required: float, time: float | None, evidence: Evidence, detail: str
) -> Check:
    stated = clearance_check(subject, value, required, time, evidence, detail)
    return replace(stated, kind=CheckKind.AT_FAULT, name="clearance at fault", required=False)
