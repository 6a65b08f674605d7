"""Pairs of bodies that must keep apart: a list that grows with the bodies, not with their square.

Only what a joint of the robot carries, and its own links, are paired with everything. How two objects come
near each other that stand in the world, or move by themselves, is not up to the robot: they are not checked.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from trajopt.robot.bodies import FixedBody
from trajopt.scene.collisions.allowed_collisions import AllowedCollisions, ContactAllowance
from trajopt.scene.collisions.clearances import ROOM, Clearances, PairKind, Part, kept
from trajopt.values.arrays import Bools, Floats, Ints, readonly
from trajopt.values.placement import WORLD


@dataclass(frozen=True, eq=False)
class BodyPairs:
    """Pairs of bodies that must keep apart and can move relative to each other.

    Attributes:
        first: Index of the first body of each pair, shape (p,), read-only.
        second: Index of the second, larger than the first, shape (p,), read-only.
        margin: Clearance that the optimiser aims at, more than is required, shape (p,) [m], read-only.
        required: Clearance that is required, shape (p,) [m], read-only.
        allowances: Allowances of intended contact, each with the index of its pair.
        immobile: Owner pairs with a link or a carried object in them that cannot move relative to each
            other and are left out.
    """

    first: Ints
    second: Ints
    margin: Floats
    required: Floats
    allowances: tuple[tuple[int, ContactAllowance], ...]
    immobile: frozenset[frozenset[str]]


@dataclass(frozen=True)
class ContactRules:
    """What a scene says of contact.

    Attributes:
        allowed: Pairs that may touch.
        touch_links: Links that may touch an object, by object; those without any may be left out.
        margin: Clearance that the optimiser keeps where it can [m].
        pair_margins: The same of single pairs, where it differs [m].
        kind_margins: The same of kinds of pairs, where it differs [m].
        clearances: What is required.
        carriers: The link that carries each object, by object; those that stand in the world have none.
        parts: What each link and object is to the robot; may be left out where no kind of pairs differs.
        allowances: Intended contacts, for a time.
        robot_joints: How many joints are the robot's, the world included; time drives the others.
    """

    allowed: AllowedCollisions
    touch_links: Mapping[str, frozenset[str]]
    margin: float
    pair_margins: Mapping[frozenset[str], float]
    kind_margins: Mapping[PairKind, float]
    clearances: Clearances
    carriers: Mapping[str, str]
    parts: Mapping[str, Part]
    allowances: tuple[ContactAllowance, ...]
    robot_joints: int


def body_pairs(bodies: Sequence[FixedBody], links: Iterable[str], rules: ContactRules) -> BodyPairs:
    """List the pairs that must keep apart, ordered by their second body, then by the first.

    Args:
        bodies: All bodies; those of one owner are carried by the same joint.
        links: Names of the robot's links: what does not move relative to them is noted as immobile.
        rules: What the scene says of contact.
    """
    owners = _Owners(bodies, frozenset(links), rules)
    part = owners.of_body
    rows = np.flatnonzero(owners.row[part] >= 0)
    own = owners.row[part[rows]]
    apart = ~owners.fixed & ~owners.excused
    # Between two owners that both have a row, each pair is met twice: it counts where it is in order.
    once = (owners.row[part] < 0)[None, :] | (rows[:, None] < np.arange(len(bodies)))
    at, other = np.nonzero(apart[own][:, part] & once)
    one = rows[at]
    first, second = np.minimum(one, other), np.maximum(one, other)
    order = np.argsort(second * len(bodies) + first)
    required, margin = (
        values[own[at], part[other]][order] for values in (owners.required(rules), owners.margins(rules))
    )
    margin = np.where(required > 0.0, np.maximum(margin, required + ROOM), margin)
    first, second = first[order], second[order]
    for array in (first, second):
        array.flags.writeable = False
    return BodyPairs(
        first,
        second,
        readonly(margin),
        readonly(required),
        owners.allowances(rules.allowances, part[first], part[second]),
        owners.immobile(),
    )


class _Owners:
    """Links and objects that own bodies; a row for each that is held against all of them.

    Attributes:
        names: Names of the owners, o of them.
        of_body: Owner of each body.
        row: Row of each owner, shape (o,); -1 for objects that stand in the world.
        excused: Whether two owners may touch, shape (rows, o).
        fixed: Whether they cannot move relative to each other, shape (rows, o).
    """

    def __init__(self, bodies: Sequence[FixedBody], links: frozenset[str], rules: ContactRules) -> None:
        self._links = links
        joints = {body.owner: body.joint for body in bodies}
        self.names = tuple(joints)
        self._index = {name: place for place, name in enumerate(self.names)}
        self.of_body = np.array([self._index[body.owner] for body in bodies], dtype=np.int64)
        joint = np.array(list(joints.values()), dtype=np.int64)
        carried = (joint != 0) & (joint < rules.robot_joints)
        active = carried | np.array([name in links for name in self.names], dtype=np.bool_)
        self._of_row: Ints = np.flatnonzero(active)
        self.row: Ints = np.where(active, np.cumsum(active) - 1, -1)
        self.fixed: Bools = joint[self._of_row][:, None] == joint
        self.excused = self._excused(rules)

    def margins(self, rules: ContactRules) -> Floats:
        """Return the margin of any two owners, shape (rows, o) [m]."""
        return self._entered(self._by_kind(rules.margin, rules.kind_margins, rules), rules.pair_margins)

    def _by_kind(self, every: float, kinds: Mapping[PairKind, float], rules: ContactRules) -> Floats:
        """Return a value of any two owners that differs for kinds of pairs, shape (rows, o)."""
        if not kinds:
            return np.full(self.excused.shape, every)
        order = tuple(Part)
        table = np.array([[kept(every, kinds, one, other) for other in order] for one in order])
        code = np.array([order.index(rules.parts[name]) for name in self.names], dtype=np.int64)
        return table[code[self._of_row]][:, code]

    def required(self, rules: ContactRules) -> Floats:
        """Return the clearance that is required of any two owners, shape (rows, o) [m]."""
        clearances = rules.clearances
        values = self._by_kind(clearances.everywhere, clearances.kinds, rules)
        holders = [name if name in self._links else rules.carriers.get(name, WORLD) for name in self.names]
        least = np.array([clearances.links.get(holder, 0.0) for holder in holders])
        standing = np.array([holder == WORLD for holder in holders], dtype=np.bool_)
        values[:, standing] = np.maximum(values[:, standing], least[self._of_row][:, None])
        return self._entered(values, clearances.pairs)

    def allowances(
        self, allowances: tuple[ContactAllowance, ...], first: Ints, second: Ints
    ) -> tuple[tuple[int, ContactAllowance], ...]:
        """Return the allowances of pairs of owners, shape (p,) both, each with the index of its pair."""
        found: list[tuple[int, ContactAllowance]] = []
        for item in allowances:
            a, b = self._index.get(item.a, -1), self._index.get(item.b, -1)
            meant = ((first == a) & (second == b)) | ((first == b) & (second == a))
            found.extend((int(place), item) for place in np.flatnonzero(meant))
        return tuple(sorted(found, key=lambda entry: entry[0]))

    def immobile(self) -> frozenset[frozenset[str]]:
        """Return the pairs that would have to keep apart, but cannot move relative to each other."""
        rows, others = np.nonzero(self.fixed & ~self.excused)
        mine, theirs = map(int, self._of_row[rows]), map(int, others)
        names = self.names
        return frozenset(frozenset((names[a], names[b])) for a, b in zip(mine, theirs, strict=True) if a != b)

    def _excused(self, rules: ContactRules) -> Bools:
        defaults = rules.allowed.defaults
        stated = np.array([name in defaults for name in self.names], dtype=np.bool_)
        granted = np.array([defaults.get(name, True) for name in self.names], dtype=np.bool_)
        rows = self._of_row
        excused = (stated[rows][:, None] | stated) & granted[rows][:, None] & granted
        for name in [self.names[int(place)] for place in rows]:
            for other, allowed in rules.allowed.entries_of(name).items():
                self._enter(excused, name, other, allowed)
                self._enter(excused, other, name, allowed)
        for name, links in rules.touch_links.items():
            for link in links:
                self._enter(excused, name, link, True)
                self._enter(excused, link, name, True)
        return excused

    def _entered(self, values: Floats, single: Mapping[frozenset[str], float]) -> Floats:
        for pair, value in single.items():
            for one, other in permutations(pair, 2):
                self._enter(values, one, other, value)
        return values

    def _enter(self, matrix: Bools | Floats, one: str, other: str, value: float) -> None:
        """Enter a value for two names, if both own bodies and the first has a row."""
        place, column = self._index.get(one), self._index.get(other)
        if place is not None and column is not None and self.row[place] >= 0:
            matrix[self.row[place], column] = value
