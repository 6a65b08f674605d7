"""Proofs that every configuration of a box collides, or violates a requirement."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.geometry import WorkCounts, evaluator
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.terms.joint_positions import without_followers
from trajopt.planning.infeasibility.exclusion import between, distance, largest_turn
from trajopt.planning.infeasibility.joint_bounds import Chain
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import (
    AxisAlignment,
    CoupledJoints,
    FramePlacement,
    JointPositions,
    PositionInRegion,
    Requirement,
)
from trajopt.robot.joints import EXCESS
from trajopt.scene.bounds import largest_gravity_slopes
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.shapes.mesh import Mesh

ACCURACY = 1e-4
"""Largest error of measured depths [m]."""


@dataclass(frozen=True)
class Closed:
    """A box of configurations that are all in collision, or violate a required clearance.

    Attributes:
        pairs: Links and objects that close it, most frequent first.
        farthest: Largest distance of the nearest pair at the middles of these [m].
    """

    pairs: tuple[tuple[str, str], ...]
    boxes: int
    farthest: float


class ConfigurationCover:
    """Covers boxes with smaller ones, up to a number of boxes."""

    def __init__(
        self, reduced: ReducedModel, most: int, apart: Floats | None = None, counts: WorkCounts | None = None
    ) -> None:
        """Bound the travel of bodies.

        Args:
            most: Boxes to examine, in all calls together, before a question is left undecided.
            apart: Distance below which pairs count as in collision, shape (p,) [m], -inf for pairs that
                never do; the required clearance when None.
        """
        self._reduced, self._query = reduced, evaluator(reduced, counts)
        self._levers = pair_levers(reduced)
        self._required = reduced.pairs.required if apart is None else apart
        self._reach = np.where(np.isfinite(self._levers).all(axis=1), self._required, -np.inf)
        self.left = most

    def close(self, middle: Floats, half: Floats) -> Closed | None:
        """Halve a box until all parts are closed; None once one is open, or there are too many.

        Args:
            middle: Shape (n,) [rad | m].
            half: Half its widths, shape (n,) [rad | m].
        """
        middle, half = middle[None], half[None]
        closing: dict[tuple[str, str], int] = {}
        seen, farthest = 0, -np.inf
        while len(middle) <= self.left:
            if len(middle) == 0:
                return Closed(tuple(sorted(closing, key=lambda names: -closing[names])), seen, farthest)
            seen += len(middle)
            self.left -= len(middle)
            contacts = self._query.close_pairs(middle, self._reach)
            nearest = np.full(len(middle), np.inf)
            np.minimum.at(nearest, contacts.sample, contacts.distance)
            farthest = max(farthest, float(nearest.max()))
            travel = np.einsum("mn,mn->m", self._levers[contacts.pair], half[contacts.sample])
            spare = self._required[contacts.pair] - contacts.distance - ACCURACY - travel
            order = np.argsort(-spare, kind="stable")
            samples, first = np.unique(contacts.sample[order], return_index=True)
            if len(samples) < len(middle):
                return None
            best = order[first]
            for row in best[spare[best] > 0.0].tolist():
                names = self._reduced.owners(int(contacts.pair[row]))
                closing[names] = closing.get(names, 0) + 1
            undecided: Bools = spare[best] <= 0.0
            share = (self._levers[contacts.pair[best]] * half)[undecided]
            middle, half = halved(middle[undecided], half[undecided], share.argmax(axis=1))
        return None


def pair_levers(reduced: ReducedModel) -> Floats:
    """Bound the motion of each pair's bodies towards each other by joint, (p, n); inf for no proof."""
    chain, pairs = Chain(reduced), reduced.pairs
    levers = np.zeros((len(reduced.bodies), len(reduced.joint_names)))
    for body in range(len(levers)):
        levers[body] = chain.levers(body)
    total = levers[pairs.first] + levers[pairs.second]
    meant = [pair for pair, _ in pairs.allowances]
    hollow = np.array([isinstance(body.shape, Mesh) for body in reduced.bodies], dtype=np.bool_)
    total[hollow[pairs.first] | hollow[pairs.second]] = np.inf
    total[meant] = np.inf
    return total


def halved(middle: Floats, half: Floats, axis: Ints) -> tuple[Floats, Floats]:
    """Halve each box along an axis of its own: return the middles and half widths of twice as many."""
    rows = np.arange(len(middle))
    narrow, step = half.copy(), np.zeros_like(half)
    narrow[rows, axis] /= 2.0
    step[rows, axis] = narrow[rows, axis]
    return np.concatenate((middle - step, middle + step)), np.concatenate((narrow, narrow))


def whole_range(reduced: ReducedModel) -> tuple[Floats, Floats]:
    """Return middle and half width of the box of all configurations, shape (n,) each."""
    limits, limited = reduced.limits, _limited(reduced)
    lower, upper = np.where(limited, limits.lower, -np.pi), np.where(limited, limits.upper, np.pi)
    middle, half = (lower + upper) / 2.0, (upper - lower) / 2.0
    return middle, np.where(_periodic(reduced), np.minimum(half, np.pi), half)


def endless(reduced: ReducedModel) -> Bools:
    """Return which joints no box of finite size can cover, shape (n,)."""
    return ~_limited(reduced) & ~_periodic(reduced)


def _limited(reduced: ReducedModel) -> Bools:
    return np.isfinite(reduced.limits.lower) & np.isfinite(reduced.limits.upper)


def _periodic(reduced: ReducedModel) -> Bools:
    """Return which joints of the group have the same placements after one turn, shape (n,)."""
    names = [reduced.model.joints[reduced.model.getJointId(name)].shortname() for name in reduced.joint_names]
    turns = np.array(["JointModelR" in name for name in names], dtype=np.bool_)
    mimicked = (reduced.mimic_matrix != 0.0).sum(axis=0) > 1
    return turns & ~mimicked


SHARES = (0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875)
"""Shares of the way from start to goal at which each joint is cut."""
CUT_BOXES = 30000
"""Boxes examined, of all cuts together, before the question is left undecided."""


@dataclass(frozen=True, kw_only=True)
class ClosedCut:
    """A value of a joint that every motion to the goal has to pass, and none can.

    Attributes:
        position: The value [rad | m].
        pairs: Links and objects that close the cut, most frequent first.
    """

    joint: str
    position: float
    pairs: tuple[tuple[str, str], ...]
    boxes: int


def closed_cut(
    problem: Problem, *, apart: Floats | None = None, shares: Sequence[float] = SHARES
) -> ClosedCut | None:
    """Return the first proven cut between the start and a goal of joints; None proves nothing.

    Args:
        apart: Distance of pairs, shape (p,) [m], as for `ConfigurationCover`.
    """
    if endless(problem.reduced).any():
        return None
    cover = ConfigurationCover(problem.reduced, CUT_BOXES, apart)
    for joint, (start, goal) in _must_move(problem).items():
        for share in shares:
            value = start + share * (goal - start)
            closed = cover.close(*_whole(problem.reduced, joint, value))
            if closed is not None:
                name = problem.reduced.joint_names[joint]
                return ClosedCut(joint=name, position=value, pairs=closed.pairs, boxes=closed.boxes)
    return None


def _must_move(problem: Problem) -> dict[int, tuple[float, float]]:
    reduced, found = problem.reduced, dict[int, tuple[float, float]]()
    for goal in without_followers(problem.goals, reduced):
        if isinstance(goal, JointPositions):
            for joint, wanted in goal.positions.items():
                if joint in reduced.joint_names:
                    place = reduced.joint_names.index(joint)
                    begin = float(reduced.start_positions[place])
                    end = float(np.clip(begin, wanted - goal.below[joint], wanted + goal.above[joint]))
                    if end != begin:
                        found[place] = (begin, end)
    return dict(sorted(found.items()))


def _whole(reduced: ReducedModel, joint: int, value: float) -> tuple[Floats, Floats]:
    middle, half = whole_range(reduced)
    middle[joint], half[joint] = value, 0.0
    return middle, half


PAIR_BOXES = 60000
"""Boxes to examine, of all pairs together, before the rest is left undecided: some tenths of a second, if the
start is too near already.
"""
CLOSER = 0.1
"""Share of the lack by which the farthest distance is rounded up, to need fewer boxes."""


@dataclass(frozen=True, kw_only=True)
class NeverApart:
    """Two links or objects nearer than required in every configuration.

    Attributes:
        distance: The required distance [m].
        most: Bound of their distance in all configurations [m].
        farthest: The largest distance that was measured [m].
    """

    first: str
    second: str
    distance: float
    most: float
    farthest: float

    def words(self, lead: str) -> str:
        """Return a phrase with their largest distance, and the required one.

        Args:
            lead: Leads from the distance to the two: "are required of".
        """
        apart = "touch"
        if self.most >= self.distance:
            measured = f"{abs(1000 * self.farthest):.1f} mm"
            apart = f"are nearer ({measured} in the farthest measured)"
            if self.farthest < 0.0:
                apart = f"overlap (by {measured} in the farthest measured)"
        elif self.most > 0.0:
            apart = f"are at most {1000 * self.most:.1f} mm apart"
        pair = f"{self.first} and {self.second}"
        return f"{1000 * self.distance:g} mm {lead} {pair}, which {apart} in every configuration"


def never_apart(
    reduced: ReducedModel, distances: Mapping[tuple[str, str], float], counts: WorkCounts
) -> tuple[NeverApart, ...]:
    """Return the pairs that are proven nearer than required in every configuration.

    Args:
        reduced: Joints outside the group do not move.
    """
    owners = [frozenset(reduced.owners(pair)) for pair in range(len(reduced.pairs.first))]
    left, found = PAIR_BOXES, list[NeverApart]()
    for (first, second), required in distances.items():
        mine = np.array([pair == frozenset((first, second)) for pair in owners], dtype=np.bool_)
        box = _between(reduced, mine)
        if box is None:
            continue
        cover = ConfigurationCover(reduced, left, np.where(mine, required, -np.inf), counts)
        closed = cover.close(*box)
        left = cover.left
        if closed is None:
            continue
        less = closed.farthest + CLOSER * (required - closed.farthest)
        tighter = ConfigurationCover(reduced, left, np.where(mine, less, -np.inf), counts)
        most = required if tighter.close(*box) is None else less
        left = tighter.left
        farthest = closed.farthest
        found.append(NeverApart(first=first, second=second, distance=required, most=most, farthest=farthest))
    return tuple(found)


def _between(reduced: ReducedModel, pairs: Bools) -> tuple[Floats, Floats] | None:
    """Return the box of all configurations of the joints between the bodies of pairs, middle and half, (n,).

    None if one of these joints slides without end, or nothing moves.
    """
    middle, half = whole_range(reduced)
    between = joints_between(reduced, np.flatnonzero(pairs).tolist())
    if not between.any() or (endless(reduced) & between).any():
        return None
    return middle, np.where(between, half, 0.0)


def joints_between(reduced: ReducedModel, pairs: Iterable[int]) -> Bools:
    """Return which joints change the distance of one of some pairs, shape (n,)."""
    between = np.zeros(len(reduced.joint_names), dtype=np.bool_)
    for pair in pairs:
        bodies = (reduced.bodies[int(each[pair])] for each in (reduced.pairs.first, reduced.pairs.second))
        one, other = (set(map(int, reduced.model.supports[body.joint])) for body in bodies)
        rows = [joint - 1 for joint in one ^ other if joint > 0]
        between |= (reduced.mimic_matrix[rows] != 0.0).any(axis=0)
    return between


MOST_BOXES = 2000
"""Boxes examined before it is left undecided whether all of a goal collides."""
PROVEN_EXCESS = 1e-6
"""A smaller excess proves nothing [m | rad]."""


def box_collides(reduced: ReducedModel, lower: Floats, upper: Floats) -> bool:
    """Return whether every configuration of a box, shape (n,) [rad | m] and finite, is proven to collide."""
    return (
        ConfigurationCover(reduced, MOST_BOXES).close(0.5 * (lower + upper), 0.5 * (upper - lower))
        is not None
    )


def box_breaks(required: Requirement, reduced: ReducedModel, lower: Floats, upper: Floats) -> bool:
    """Return whether every configuration of a box is proven to violate a requirement.

    Distances and residuals differ from those at its middle by at most the travel that its joints cause.

    Args:
        lower: Shape (n,) [rad | m]; finite.
        upper: Shape (n,) [rad | m]; finite.
    """
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    match required:
        case JointPositions():
            return _joints_break(required, reduced, middle, half)
        case CoupledJoints():
            place, reach = _each(reduced, tuple(required.weights), middle, half)
            factors = np.array(list(required.weights.values()))
            off = abs(float(factors @ place) - required.value) - required.tolerance
            return off - float(np.abs(factors) @ reach) > EXCESS
        case AxisAlignment() | FramePlacement() | PositionInRegion():
            return _frame_breaks(required, reduced, middle, half)
        case _:
            return False


def _each(
    reduced: ReducedModel, joints: tuple[str, ...], middle: Floats, half: Floats
) -> tuple[Floats, Floats]:
    moved = tuple(reduced.model.names[1:])
    place = reduced.all_positions(middle)[reduced.scene.robot.index(joints)]
    carried = np.abs(reduced.mimic_matrix)
    rows = [carried[moved.index(name)] if name in moved else 0.0 * half for name in joints]
    return place, np.array(rows) @ half


def _joints_break(required: JointPositions, reduced: ReducedModel, middle: Floats, half: Floats) -> bool:
    names = tuple(required.positions)
    place, reach = _each(reduced, names, middle, half)
    off = place - np.array(list(required.positions.values()))
    above = np.array([required.above[name] for name in names])
    below = np.array([required.below[name] for name in names])
    return bool((np.maximum(off - above, -off - below) - reach > EXCESS).any())


def _frame_breaks(
    required: AxisAlignment | FramePlacement | PositionInRegion,
    reduced: ReducedModel,
    middle: Floats,
    half: Floats,
) -> bool:
    place = reduced.all_positions(middle)
    frame = reduced.scene.placement_of(required.frame, place)
    base = reduced.scene.placement_of(required.reference, place)
    chain = Chain(reduced)
    carrier, within = reduced.attachment(required.frame)
    reference, _ = reduced.attachment(required.reference)
    turning = float((chain.turns(carrier) + chain.turns(reference)) @ half)
    if isinstance(required, AxisAlignment):
        tilt = between(frame.rotation @ required.axis, base.rotation @ required.direction)
        return tilt - required.tolerance - turning > PROVEN_EXCESS
    point = base.inverse() * (frame * required.offset)
    # Seen from a reference that moves, a point moves in more ways than are bounded here.
    moving = float(chain.point_levers(carrier, within * required.offset) @ half) if reference == 0 else np.inf
    if isinstance(required, PositionInRegion):
        off = min(distance(shape, where.inverse() * point) for shape, where in required.members)
        return off - moving > PROVEN_EXCESS
    goal = required.placement
    off = np.abs((point - goal.translation) @ goal.rotation) - required.position_tolerance
    if float(off.max()) - moving > PROVEN_EXCESS:
        return True
    turned = goal.rotation.T @ base.rotation.T @ frame.rotation
    angle = float(np.arccos(np.clip((np.trace(turned) - 1.0) / 2.0, -1.0, 1.0)))
    return angle - largest_turn(required) - turning > PROVEN_EXCESS


def box_overloads(problem: Problem, lower: Floats, upper: Floats) -> bool:
    """Return whether a joint is proven too weak to hold still at every configuration of a box."""
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    torque = DynamicsQuery.loaded(problem.reduced).gravity(middle[None]).torque[0]
    excess = np.abs(torque) - problem.limits.effort
    return bool((excess > largest_gravity_slopes(problem.reduced) @ half).any())
