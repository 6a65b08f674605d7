"""Clearance at fault: how near things come to links that move; at rest these may be touched."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from trajopt.values.arrays import Bools, Floats
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.clearance import (
    ClearanceCriterion,
    ClearanceFinding,
    clearance_check,
    followed,
    tightest_of,
)
from trajopt.verify.checks.criterion import Criterion
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.pair_distances import PairDistances
from trajopt.verify.kernel.polynomials import Polynomials
from trajopt.verify.search.clearance_search import Contact, Findings, search_clearance

NEVER = (inf, -inf)
"""A time span without any time."""


@dataclass(frozen=True, eq=False)
class AtFaultCriterion(Criterion):
    """How near things come to the links, and to what they carry, while these move; for information only.

    Attributes:
        clearance: The clearance at all times.
    """

    clearance: ClearanceCriterion

    def holds(self) -> bool:
        """Nothing depends on it."""
        return True

    def measure(self) -> Iterator[Check]:
        """State the clearance at fault."""
        yield _judged(self.clearance.motion, self.clearance.distances, self.clearance.finding)


def _judged(motion: Motion, distances: PairDistances, found: ClearanceFinding) -> Check:
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
    """State the clearance at fault, of which so much is proven as of that at all times [m]."""
    gap = next((search.gap for search in searches if search.gap is not None), None)
    nearest = min(searches, key=_bound)
    bound = max(_bound(nearest), always)
    if gap is None and bound == inf:
        return _check("", None, 0.0, None, Evidence.PROVEN, "nothing comes near what moves of the robot")
    pair, time = tightest_of(nearest, np.arange(len(distances.first)))
    required = float(nearest.windows.required[pair])
    if gap is not None:
        name = distances.pair_name(gap.pair)
        words = f"no proof for {name} from {gap.begin:.5f} to {gap.end:.5f} s"
        return _check(name, nearest.free.best(), required, time, Evidence.UNPROVEN, words)
    subject = "no pair is near" if time is None else distances.pair_name(pair)
    words = f"nothing comes nearer than {1000 * bound:.2f} mm to a link while it moves"
    return _check(subject, bound, required, time, Evidence.PROVEN, words)


def moving_spans(motion: Motion, distances: PairDistances) -> list[Floats]:
    """Return when pairs are looked at, from and to, each of shape (p, 2) [s]; together they cover all times.

    Of a pair with something that changes that is while the robot's part of it moves, and both are there.
    All other pairs keep their distance while nothing moves them; they are looked at once, for all times.
    """
    present = distances.present_since(motion.clock)
    assert present is not None
    rounds = [np.where(distances.changing[:, None], NEVER, (-inf, inf))]
    times, patterns = motion.trajectory.times, _moved(motion, distances)
    ends: Floats = np.concatenate(((-inf,), times[1:-1], (times[-1] if motion.staying > 0.0 else inf,)))
    for moved in np.unique(patterns[distances.changing], axis=0):
        pairs = np.flatnonzero(distances.changing & (patterns == moved).all(axis=1))
        for number, (begin, end) in enumerate(_spans(moved, ends)):
            if number == len(rounds):
                rounds.append(np.tile(NEVER, (len(patterns), 1)))
            rounds[number][pairs, 0] = np.maximum(present[pairs, 0], begin)
            rounds[number][pairs, 1] = np.minimum(present[pairs, 1], end)
    return rounds


def _moved(motion: Motion, distances: PairDistances) -> Bools:
    """Say whether the robot moves one of each pair, in each piece of the trajectory, shape (p, k - 1)."""
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
    """Return the spans of time of neighbouring pieces that are marked, given the ends of all pieces."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], moved, [False])).astype(np.int8)))
    return [(float(ends[begin]), float(ends[end])) for begin, end in edges.reshape(-1, 2).tolist()]


def _bound(search: Findings) -> float:
    return float(search.free.proven.min(initial=inf)) if search.proven else search.free.best()


def _check(
    subject: str, value: float | None, required: float, time: float | None, evidence: Evidence, detail: str
) -> Check:
    stated = clearance_check(subject, value, required, time, evidence, detail)
    return replace(stated, kind=CheckKind.AT_FAULT, name="clearance at fault", required=False)
