"""Which pairs of links may be left out of collision checks, with the evidence for each."""

from dataclasses import dataclass, replace

import numpy as np

from trajopt.geometry import Query
from trajopt.lab.srdf.evidence import DEFAULT_CONFIDENCE, Confidence, PairEvidence, Verdict
from trajopt.lab.srdf.link_tree import LinkTree
from trajopt.lab.srdf.pair_counts import LinkPairs, PairCounts, count_pairs, descend
from trajopt.optimise.kinematics.sampling import Progress
from trajopt.robot.loading.groups import ALL_JOINTS, resolve_groups
from trajopt.robot.loading.srdf import Srdf
from trajopt.robot.robot import Robot
from trajopt.scene.collisions.allowed_collisions import AllowedCollisions
from trajopt.scene.reduced import ReducedModel, reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import MimicOutOfRange
from trajopt.values.errors.arguments import checked

ALWAYS_SHARE = 0.95
"""A pair that surely collides in a larger share than this can only be a fault of its shapes."""


def all_joints_free(robot: Robot) -> ReducedModel:
    """Return the robot with every driven joint free and no pair of links excused.

    Where no position of a joint keeps those that follow it within their limits, theirs are left out:
    `check_urdf` names them.
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
    """Return how many configurations `judge_pairs` examines."""
    return confidence.samples(max(len(LinkPairs.of(all_joints_free(robot)).names), 1))


@checked
def judge_pairs(
    robot: Robot,
    *,
    rng: np.random.Generator,
    confidence: Confidence = DEFAULT_CONFIDENCE,
    progress: Progress | None = None,
) -> tuple[PairEvidence, ...]:
    """Sample all pairs of links until those that never collide are known well enough.

    Pairs joined by a joint are adjacent, and so are those that cannot move relative to each other. Of others
    those are "never" that no sample has in collision and no descent from their nearest sample either;
    "always" that surely collide in 95 % of the configurations; "default" that collide where all joints are
    nearest to zero, but not always.

    Args:
        robot: The robot; what its SRDF says of pairs, if it has one, is not considered.
        rng: Draws the configurations.
        confidence: With what confidence "never" must be known; gives the number of samples.
        progress: Called with the number of samples done.

    Returns:
        One for each pair of links with collision bodies, in the order of the robot's links.
    """
    reduced = all_joints_free(robot)
    pairs, query = LinkPairs.of(reduced), Query(reduced)
    tree = LinkTree.of(robot)
    judge = _PairJudge(tree, frozenset(body.owner for body in robot.bodies), confidence, len(pairs.names))
    samples = confidence.samples(max(len(pairs.names), 1))
    counts = count_pairs(query, pairs, samples, rng=rng, progress=progress)
    unseen = [
        place
        for place, names in enumerate(pairs.names)
        if counts.collisions[place] == 0 and not judge.adjacent(names)
    ]
    descend(query, pairs, counts, unseen, rng=rng)
    at_zero = query.close_pairs(reduced.start_positions[None], np.full(len(pairs.of_body_pair), 1e-12))
    zero = {pairs.names[int(place)] for place in pairs.of_body_pair[at_zero.pair]}
    found = {
        frozenset(names): judge(names, counts, place, default=names in zero)
        for place, names in enumerate(pairs.names)
    }
    order = {name: place for place, name in enumerate(robot.links)}
    for pair in reduced.pairs.immobile:
        first, second = sorted(pair, key=order.__getitem__)
        found[pair] = _fixed(first, second)
    return tuple(sorted(found.values(), key=lambda item: (order[item.first], order[item.second])))


@dataclass(frozen=True, eq=False)
class _PairJudge:
    """Decides what becomes of a pair."""

    tree: LinkTree
    solid: frozenset[str]
    confidence: Confidence
    pairs: int

    def adjacent(self, names: tuple[str, str]) -> bool:
        return self.tree.joined(*names, self.solid)

    def __call__(
        self, names: tuple[str, str], counts: PairCounts, place: int, *, default: bool
    ) -> PairEvidence:
        collisions, samples = int(counts.collisions[place]), counts.samples
        lower = self.confidence.lower(collisions, samples, pairs=self.pairs)
        nearest = float(counts.nearest[place])
        if self.adjacent(names):
            verdict = Verdict.ADJACENT
        elif collisions == 0 and nearest > 0.0:
            verdict = Verdict.NEVER
        elif lower >= ALWAYS_SHARE:
            verdict = Verdict.ALWAYS
        else:
            verdict = Verdict.DEFAULT if default else Verdict.SOMETIMES
        return PairEvidence(
            first=names[0],
            second=names[1],
            verdict=verdict,
            collisions=collisions,
            samples=samples,
            lower=lower,
            upper=self.confidence.upper(collisions, samples, pairs=self.pairs),
            nearest=nearest,
            at=counts.at[place].copy(),
            descended=collisions == 0 and nearest <= 0.0,
        )


def _fixed(first: str, second: str) -> PairEvidence:
    nothing: Floats = np.zeros(0)
    return PairEvidence(
        first=first,
        second=second,
        verdict=Verdict.ADJACENT,
        collisions=0,
        samples=0,
        lower=0.0,
        upper=1.0,
        nearest=float("nan"),
        at=nothing,
        descended=False,
    )
