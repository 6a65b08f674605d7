"""Pairs of links that collision checks may skip, with the evidence for each."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from math import ceil, log, log1p, nan

import numpy as np

from trajopt.geometry import Contacts, Evaluator, evaluator
from trajopt.lab.srdf.groups import LinkTree
from trajopt.optimise.kinematics.sampling import Progress
from trajopt.robot.joints import draw_positions
from trajopt.robot.loading.groups import ALL_JOINTS, resolve_groups
from trajopt.robot.loading.srdf import Srdf
from trajopt.robot.robot import Robot
from trajopt.scene.clearances import AllowedCollisions
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Bools, Floats, Ints, Value
from trajopt.values.errors import MimicOutOfRange, ProblemError
from trajopt.values.errors.arguments import checked, checked_class


class PairVerdict(Enum):
    """Verdict on a pair of links; the value is its reason in an SRDF, if the pair is disabled."""

    ADJACENT = "Adjacent"
    ALWAYS = "Always"
    NEVER = "Never"
    DEFAULT = "Default"
    SOMETIMES = ""


@checked_class
@dataclass(frozen=True, kw_only=True)
class Confidence:
    """Required confidence that a pair never collides.

    All pairs without a collision share the risk equally (Bonferroni): with this confidence none of them
    collides in a larger share of the configurations.

    Attributes:
        share: Of the configurations, in (0, 1), as `level`.
    """

    share: float = 1e-4
    level: float = 0.99

    def __post_init__(self) -> None:
        for name in ("share", "level"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise ProblemError(f"Confidence.{name} must lie in (0, 1), is {getattr(self, name)}")

    def samples(self, pairs: int) -> int:
        """Return the required number of samples without a collision.

        No collision in N has the probability (1 - share)^N, which must not exceed the risk of one pair,
        (1 - level) / pairs. One pair at 95 % is the rule of three: N = 3 / share.
        """
        return ceil(log((1.0 - self.level) / pairs) / log1p(-self.share))

    def upper(self, collisions: int, samples: int, *, pairs: int) -> float:
        """Bound the share of configurations in collision from above, for one of several pairs.

        Source: Clopper and Pearson, Biometrika 1934 (one-sided).
        """
        from scipy.special import betaincinv

        if collisions == samples:
            return 1.0
        return float(betaincinv(collisions + 1, samples - collisions, 1.0 - (1.0 - self.level) / pairs))

    def lower(self, collisions: int, samples: int, *, pairs: int) -> float:
        from scipy.special import betaincinv

        if collisions == 0:
            return 0.0
        return float(betaincinv(collisions, samples - collisions + 1, (1.0 - self.level) / pairs))


DEFAULT_CONFIDENCE = Confidence()


@dataclass(frozen=True, kw_only=True, eq=False)
class PairEvidence(Value):
    """Evidence about two links.

    Attributes:
        samples: Sampled configurations; 0 for adjacent links.
        lower: Lower bound on the share of configurations in collision.
        nearest: Smallest signed distance, also of the descent [m]; NaN if not measured.
        at: Positions of all driven joints there [rad | m]; empty if not measured.
        descended: Whether the collision was only found by descent from the nearest sample.
    """

    first: str
    second: str
    verdict: PairVerdict
    collisions: int = 0
    samples: int = 0
    lower: float = 0.0
    upper: float = 1.0
    nearest: float = nan
    at: Floats = field(default_factory=lambda: np.zeros(0))
    descended: bool = False

    @property
    def pair(self) -> frozenset[str]:
        """The two names."""
        return frozenset((self.first, self.second))

    def as_dict(self) -> dict[str, object]:
        """Return plain data."""
        return {
            "links": [self.first, self.second],
            "verdict": self.verdict.name,
            "collisions": self.collisions,
            "samples": self.samples,
            "share_of_configurations": [self.lower, self.upper],
            "nearest": None if self.samples == 0 else self.nearest,
            "at": self.at.tolist(),
            "found_by_descent": self.descended,
        }

    def __str__(self) -> str:
        name = f"{self.first} and {self.second}"
        if self.samples == 0:
            return f"{name}: adjacent, not measured"
        if self.descended:
            deep = f"{max(0.0, -1000.0 * self.nearest):.1f} mm deep where descent led from the nearest"
            return f"{name}: no collision in {self.samples} samples, but {deep}"
        if self.collisions == 0:
            rarely, nearest = 100.0 * self.upper, 1000.0 * self.nearest
            return (
                f"{name}: no collision in {self.samples} samples (< {rarely:.2g} %), nearest {nearest:.1f} mm"
            )
        share = 100.0 * self.collisions / self.samples
        said = f"{share:.0f}" if share >= 99.5 else f"{share:.2g}"  # two digits of it would be 1e+02
        return f"{name}: in collision in {said} % of {self.samples} samples"


FIRST_BATCH = 64
"""Configurations at which every distance is measured; later ones only search smaller distances."""
BATCH = 2048

STARTS = 8
"""Number of starts of each descent."""
AROUND = 0.3
"""Standard deviation of those around the nearest sample [rad | m]."""
STEP = 0.2
"""First step of the joint that moves most [rad | m]."""
STEPS = 30


@dataclass(frozen=True, eq=False)
class LinkPairs:
    """Pairs of links that can move relative to each other, and their pairs of bodies.

    Attributes:
        of_body_pair: Index of the link pair of each pair of bodies, shape (p,).
    """

    names: tuple[tuple[str, str], ...]
    of_body_pair: Ints

    @staticmethod
    def of(reduced: ReducedModel) -> "LinkPairs":
        order = {name: place for place, name in enumerate(reduced.scene.robot.links)}
        owners = [
            tuple(sorted(reduced.owners(pair), key=order.__getitem__))
            for pair in range(len(reduced.pairs.first))
        ]
        names = sorted(set(owners), key=lambda pair: (order[pair[0]], order[pair[1]]))
        index = {pair: place for place, pair in enumerate(names)}
        of_body_pair = np.array([index[pair] for pair in owners], dtype=np.int64)
        return LinkPairs(tuple((first, second) for first, second in names), of_body_pair)


@dataclass(eq=False)
class PairCounts:
    """Evidence about m pairs of links, extended by each batch."""

    samples: int
    collisions: Ints
    nearest: Floats
    at: Floats

    def take(self, pairs: LinkPairs, positions: Floats, contacts: Contacts) -> None:
        link_pair = pairs.of_body_pair[contacts.pair]
        touching = contacts.distance <= 0.0
        met = np.unique(link_pair[touching] * len(positions) + contacts.sample[touching]) // len(positions)
        self.collisions += np.bincount(met, minlength=len(self.collisions))
        self.samples += len(positions)
        # Nearest last: it is the one that stays where several contacts of a pair are written.
        order = np.argsort(-contacts.distance, kind="stable")
        nearer = order[contacts.distance[order] < self.nearest[link_pair[order]]]
        self.nearest[link_pair[nearer]] = contacts.distance[nearer]
        self.at[link_pair[nearer]] = positions[contacts.sample[nearer]]

    def reach(self, pairs: LinkPairs) -> Floats:
        """Return the largest relevant distance of each pair of bodies, shape (p,) [m]."""
        return np.maximum(self.nearest, 1e-12)[pairs.of_body_pair]

    def judged(
        self, names: tuple[str, str], place: int, confidence: Confidence, *, default: bool
    ) -> PairEvidence:
        """Judge a pair; `default` is whether it collides with all joints nearest to zero."""
        collisions, pairs = int(self.collisions[place]), len(self.collisions)
        nearest = float(self.nearest[place])
        lower = confidence.lower(collisions, self.samples, pairs=pairs)
        if collisions == 0 and nearest > 0.0:
            verdict = PairVerdict.NEVER
        elif lower >= ALWAYS_SHARE:
            verdict = PairVerdict.ALWAYS
        else:
            verdict = PairVerdict.DEFAULT if default else PairVerdict.SOMETIMES
        return PairEvidence(
            first=names[0],
            second=names[1],
            verdict=verdict,
            collisions=collisions,
            samples=self.samples,
            lower=lower,
            upper=confidence.upper(collisions, self.samples, pairs=pairs),
            nearest=nearest,
            at=self.at[place].copy(),
            descended=collisions == 0 and nearest <= 0.0,
        )


def count_pairs(
    query: Evaluator,
    pairs: LinkPairs,
    samples: int,
    adjacent: Bools,
    *,
    rng: np.random.Generator,
    progress: Progress | None = None,
) -> PairCounts:
    """Sample random configurations within limits, and measure the pairs of links that are not adjacent."""
    joints = len(query.reduced.joint_names)
    count = len(pairs.names)
    counts = PairCounts(0, np.zeros(count, dtype=np.int64), np.full(count, np.inf), np.zeros((count, joints)))
    while counts.samples < samples:
        size = min(BATCH if counts.samples else FIRST_BATCH, samples - counts.samples)
        positions = draw_positions(query.reduced.limits, size, rng=rng)
        reach = np.where(adjacent[pairs.of_body_pair], -np.inf, counts.reach(pairs))
        counts.take(pairs, positions, query.close_pairs(positions, reach))
        if progress is not None:
            progress(counts.samples)
    return counts


def descend(
    query: Evaluator, pairs: LinkPairs, counts: PairCounts, chosen: Sequence[int], *, rng: np.random.Generator
) -> None:
    """Search smaller distances of pairs by gradient descent from the nearest samples and around them.

    A step that does not reduce the distance is halved. The minima in the counts are updated.
    """
    limits = query.reduced.limits
    for pair in chosen:
        start = np.repeat(counts.at[pair][None], STARTS, axis=0)
        start[1:] += rng.normal(scale=AROUND, size=start[1:].shape)
        here = np.clip(start, limits.lower, limits.upper)
        reach = np.where(pairs.of_body_pair == pair, np.inf, -np.inf)
        distance, slope = _nearest(query, here, reach)
        size = np.full(STARTS, STEP)
        for _ in range(STEPS):
            length = np.maximum(np.abs(slope).max(axis=1, keepdims=True), 1e-12)
            there = np.clip(here - size[:, None] * slope / length, limits.lower, limits.upper)
            ahead, slope_ahead = _nearest(query, there, reach)
            better = ahead < distance
            here, slope = (
                np.where(better[:, None], there, here),
                np.where(better[:, None], slope_ahead, slope),
            )
            distance, size = np.where(better, ahead, distance), np.where(better, size, 0.5 * size)
            if distance.min() <= 0.0:
                break
        best = int(np.argmin(distance))
        if distance[best] < counts.nearest[pair]:
            counts.nearest[pair], counts.at[pair] = distance[best], here[best]


def _nearest(query: Evaluator, positions: Floats, reach: Floats) -> tuple[Floats, Floats]:
    contacts = query.close_pairs(positions, reach)
    order = np.argsort(-contacts.distance, kind="stable")
    distance, slope = np.full(len(positions), np.inf), np.zeros(positions.shape)
    distance[contacts.sample[order]] = contacts.distance[order]
    slope[contacts.sample[order]] = contacts.jacobian[order]
    return distance, slope


ALWAYS_SHARE = 0.95
"""A pair that surely collides in a larger share than this can only be a fault of its shapes."""


def all_joints_free(robot: Robot) -> ReducedModel:
    """Return the robot with every driven joint free and all pairs of links checked.

    If no position of a joint keeps its mimics within their limits, their limits are ignored: `check_urdf`
    reports them.
    """
    groups, *_ = resolve_groups(robot.model, Srdf(), frozenset(robot.mimics))
    bare = replace(robot, groups=groups, disabled_pairs=frozenset(), passive_joints=frozenset())
    try:
        return _reduced(bare)
    except MimicOutOfRange:
        follows = np.array([joint in bare.mimics for joint in bare.joint_names])
        lower, upper = (
            np.where(follows, -np.inf, bare.limits.lower),
            np.where(follows, np.inf, bare.limits.upper),
        )
        return _reduced(replace(bare, limits=replace(bare.limits, lower=lower, upper=upper)))


def _reduced(bare: Robot) -> ReducedModel:
    return reduce_model(Scene(bare, allowed=AllowedCollisions(), margin=0.0), ALL_JOINTS, bare.positions())


def samples_needed(robot: Robot, confidence: Confidence) -> int:
    """Return the number of configurations of `judge_pairs`."""
    return confidence.samples(max(len(LinkPairs.of(all_joints_free(robot)).names), 1))


@checked
def judge_pairs(
    robot: Robot,
    *,
    rng: np.random.Generator,
    confidence: Confidence = DEFAULT_CONFIDENCE,
    progress: Progress | None = None,
) -> tuple[PairEvidence, ...]:
    """Sample all pairs of links until the pairs that never collide are known with the required confidence.

    Pairs joined by a joint are adjacent, and so are pairs that cannot move relative to each other. Of the
    others, a pair is "never" if no sample and no descent from its nearest sample is in collision; "always" if
    it certainly collides in 95 % of the configurations; "default" if it collides with all joints nearest to
    zero, but not always.
    """
    reduced = all_joints_free(robot)
    pairs, query = LinkPairs.of(reduced), evaluator(reduced)
    tree, solid = LinkTree.of(robot), frozenset(body.owner for body in robot.bodies)
    adjacent = np.array([tree.joined(*names, solid) for names in pairs.names], dtype=np.bool_)
    samples = confidence.samples(max(len(pairs.names), 1))
    counts = count_pairs(query, pairs, samples, adjacent, rng=rng, progress=progress)
    unseen = np.flatnonzero(~adjacent & (counts.collisions == 0))
    descend(query, pairs, counts, unseen.tolist(), rng=rng)
    at_zero = query.close_pairs(reduced.start_positions[None], np.full(len(pairs.of_body_pair), 1e-12))
    zero = {pairs.names[int(place)] for place in pairs.of_body_pair[at_zero.pair]}
    found = {
        frozenset(names): _adjacent(*names)
        if adjacent[place]
        else counts.judged(names, place, confidence, default=names in zero)
        for place, names in enumerate(pairs.names)
    }
    order = {name: place for place, name in enumerate(robot.links)}
    for pair in reduced.pairs.immobile:
        first, second = sorted(pair, key=order.__getitem__)
        found[pair] = _adjacent(first, second)
    return tuple(sorted(found.values(), key=lambda item: (order[item.first], order[item.second])))


def _adjacent(first: str, second: str) -> PairEvidence:
    return PairEvidence(first=first, second=second, verdict=PairVerdict.ADJACENT)
