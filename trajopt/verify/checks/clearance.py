"""Clearance of every pair of bodies over the whole motion, as checks."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from trajopt.scene.clearances import ContactAllowance
from trajopt.values.arrays import Ints
from trajopt.verify.certificate import Check, CheckKind, Evidence, PairClearance, Unproven
from trajopt.verify.checks.criterion import Criterion
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.pair_distances import PairDistances
from trajopt.verify.kernel.required import rows
from trajopt.verify.search.clearance_search import Contact, Findings, Tally, search_clearance

_PROBES = 17
_FOLLOWED = 8
"""How many pairs in contact are followed to their deepest contact."""
_DEEPER = 5e-6
"""A contact has to be this much deeper to replace another: depths are not known better [m]."""


@dataclass(frozen=True)
class ClearanceFinding:
    """What the search for a proof of clearance has found.

    Attributes:
        search: The search.
        checks: One for every clearance that is required of some pair, by kind where the scene states what
            kinds keep, and one for every allowance of intended contact. Where the search ended early, those
            found broken or unproven.
        clearance: Proven lower bound, or the smallest measured if there is none [m].
        pairs: Pairs that came near each other, nearest first.
        unproven: First interval without proof, if there is one.
        worst: The deepest contact that is not accepted, if there is one.
    """

    search: Findings
    checks: tuple[Check, ...]
    clearance: float
    pairs: tuple[PairClearance, ...]
    unproven: Unproven | None
    worst: Contact | None


@dataclass(frozen=True, eq=False)
class ClearanceCriterion(Criterion):
    """Every pair keeps apart, or touches only where and as deep as that is allowed.

    Attributes:
        motion: The motion among what changes with time.
        distances: Workspace for the distances of its bodies.
    """

    motion: Motion
    distances: PairDistances

    def holds(self) -> bool:
        """Decide it: the search ends as soon as it is proven, or something is not."""
        return search_clearance(self.motion, self.distances, measured=False).proven

    def measure(self) -> tuple[Check, ...]:
        """State the tightest pair of each kind and clearance, and each intended contact."""
        return self.finding.checks

    @cached_property
    def finding(self) -> ClearanceFinding:
        """Everything that is found when it is measured."""
        return judge_clearance(self.motion, self.distances)


def judge_clearance(motion: Motion, distances: PairDistances) -> ClearanceFinding:
    """Search for a proof that every pair keeps apart, and state it, or where there is none, as checks.

    Args:
        motion: The motion.
        distances: Workspace for the distances of its bodies.
    """
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


def followed(motion: Motion, search: Findings, distances: PairDistances, pairs: Ints) -> tuple[Contact, ...]:
    """Follow contacts of some pairs, (m,), to where they are deepest, the first returned with more care."""
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


def _deepest(motion: Motion, search: Findings, distances: PairDistances, contact: Contact) -> Contact:
    """Look around a contact for the deepest one near it, in its own window if it is in one."""
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


def _broken_check(motion: Motion, distances: PairDistances, contact: Contact, required: float) -> Check:
    """State the pair that is deepest in contact, or nearest though it must keep a clearance."""
    name, over = distances.pair_name(contact.pair), motion.trajectory.duration
    after = f", {contact.time - over:.3f} s after the end" if contact.time > over else ""
    if contact.distance > 0.0:
        words = f"{name} come within {1000 * contact.distance:.2f} mm of each other at {contact.time:.3f} s"
        words += f"{after}, {1000 * required:g} mm are required"
    else:
        words = f"{name} are {-1000 * contact.distance:.2f} mm into each other at {contact.time:.3f} s{after}"
    return clearance_check(name, contact.distance, required, contact.time, Evidence.SAMPLED, words)


def _unproven_check(search: Findings, distances: PairDistances, pairs: Ints, unproven: Unproven) -> Check:
    """State where there is no proof, with the smallest distance measured."""
    tightest, time = tightest_of(search, pairs)
    required = float(search.windows.required[tightest])
    words = (
        f"no proof that {unproven.first} and {unproven.second} keep {_apart(required)} "
        f"from {unproven.begin:.5f} to {unproven.end:.5f} s"
    )
    value = float(search.free.measured[tightest])
    return clearance_check(distances.pair_name(tightest), value, required, time, Evidence.UNPROVEN, words)


def _proven_check(search: Findings, distances: PairDistances, pairs: Ints, *, alone: bool) -> Check:
    """State the clearance of the tightest of the pairs with the same required clearance."""
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
    """Return the nearest of some pairs, and when it was measured [s] if it was."""
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
    """State what is known of how near a pair comes.

    Args:
        subject: The pair.
        value: Its clearance [m].
        required: What it has to be at least [m].
        time: When it is so near [s].
        evidence: How that is known; it holds if it is proven.
        detail: In words.
    """
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


def _contact_checks(motion: Motion, search: Findings, *, proven: bool) -> tuple[Check, ...]:
    """State how deep every allowed contact is, unless the search ended for another reason."""
    checks: list[Check] = []
    by_allowance: dict[ContactAllowance, list[int]] = {}
    for pair, allowance in motion.reduced.pairs.allowances:
        by_allowance.setdefault(allowance, []).append(pair)
    for allowance, pairs in by_allowance.items():
        lowest = pairs[int(search.accepted.measured[pairs].argmin())]
        measured = float(search.accepted.measured[lowest])
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
    motion: Motion, search: Findings, distances: PairDistances, *, proven: bool
) -> tuple[PairClearance, ...]:
    """List the owner pairs that were measured near each other, nearest first."""
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
