"""Required clearances (proven), margins (aimed at by the optimiser) and allowed collisions."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from itertools import chain, permutations

from trajopt.values.arrays import Value, number, one_of
from trajopt.values.errors import ModelError, ShapeError, shown

ROOM = 5e-3
"""Added to a required clearance by the optimiser, for samples, tolerances and timing [m]."""


class PairKind(Enum):
    """Kinds of pairs of bodies; each kind may have its own clearance and margin.

    Attached objects keep the larger of the world's and the carried clearance from the world.
    """

    WORLD = "world"
    """The robot or an attached object, and an object in the world."""
    CARRIED = "carried"
    """An attached object, and a link or another attached object."""
    ROBOT = "robot"
    """Two of the robot's links."""


class Part(Enum):
    """Role of a link or object: robot, carried or world."""

    LINK = "a link"
    CARRIED = "carried"
    WORLD = "part of the world"


def kept(every: float, kinds: Mapping[PairKind, float], one: Part, other: Part) -> float:
    """Return the largest distance stated for a pair of this kind [m]."""
    both = {one, other}
    stated = [PairKind.WORLD] if Part.WORLD in both else []
    if Part.CARRIED in both:
        stated.append(PairKind.CARRIED)
    return max((kinds[kind] for kind in stated or [PairKind.ROBOT] if kind in kinds), default=every)


def in_kinds(every: float, kinds: Mapping[PairKind, float]) -> str:
    apart = ", ".join(f"{kind.value} {1000 * kinds[kind]:g} mm" for kind in PairKind if kind in kinds)
    return f"{1000 * every:g} mm" + f" ({apart})" * bool(apart)


PAIRS_DIFFER = " (single pairs differ)"
"""Added to the printed clearance if single pairs differ."""


def how_near(first: str, second: str, distance: float, required: float) -> str:
    """Print that two bodies penetrate or are nearer than required [m]."""
    if distance <= 0.0:
        depth = f"{-distance:.4g} m" if distance < -1.0 else f"{-1e3 * distance:.1f} mm"
        return f"{first} is {depth} inside {second}" if distance <= -5e-5 else f"{first} touches {second}"
    return f"{first} is {distance * 1000:.1f} mm from {second}, {required * 1000:g} mm are required"


@dataclass(frozen=True)
class Clearances:
    """Required clearances between links and objects; none by default.

    Attributes:
        everywhere: Between any two bodies [m].
        pairs: Between single pairs that differ [m].
        links: Between a link, with its attached objects, and the world, if larger [m].
        kinds: Between pairs of a kind that differs [m].
    """

    everywhere: float = 0.0
    pairs: Mapping[frozenset[str], float] = field(default_factory=dict[frozenset[str], float])
    links: Mapping[str, float] = field(default_factory=dict[str, float])
    kinds: Mapping[PairKind, float] = field(default_factory=dict[PairKind, float])

    def __post_init__(self) -> None:
        stated = (self.pairs.values(), self.links.values(), self.kinds.values())
        for value in (self.everywhere, *chain(*stated)):
            if number("required clearance", value) < 0.0:
                raise ShapeError("required clearance", f"is negative: {value:g} m")

    def having(self, value: float, pair: frozenset[str] | None) -> "Clearances":
        """Return a copy with another clearance for all pairs of every kind, or for one pair [m]."""
        if pair is None:
            return replace(self, everywhere=value, kinds={})
        return replace(self, pairs={**self.pairs, pair: value})

    def without(self, name: str) -> "Clearances":
        """Return a copy without the pairs of a name."""
        return replace(self, pairs={pair: value for pair, value in self.pairs.items() if name not in pair})

    def __str__(self) -> str:
        differ = PAIRS_DIFFER * bool(self.pairs or self.links)
        return f"clearance {in_kinds(self.everywhere, self.kinds)} required{differ}"


@dataclass(frozen=True)
class AllowedCollisions(Value):
    """Allowed-collision matrix, with the rules of MoveIt.

    An entry for a pair decides; without one the default of either name decides, and if both have a default,
    both must allow the contact; without any the pair is checked.

    Attributes:
        entries: Pair of names -> whether contact is allowed.
        defaults: Name -> whether contact with anything is allowed.
    """

    entries: Mapping[frozenset[str], bool] = field(default_factory=dict[frozenset[str], bool])
    defaults: Mapping[str, bool] = field(default_factory=dict[str, bool])

    def allowed(self, a: str, b: str) -> bool:
        """Return whether contact between two names is allowed."""
        entry = self.entries.get(frozenset((a, b)))
        if entry is not None:
            return entry
        stated = [self.defaults[name] for name in (a, b) if name in self.defaults]
        return bool(stated) and all(stated)

    def entries_of(self, name: str) -> Mapping[str, bool]:
        """Return the entries of one name, by the other name of each."""
        return self._by_name.get(name, {})

    @cached_property
    def _by_name(self) -> Mapping[str, Mapping[str, bool]]:
        found: dict[str, dict[str, bool]] = {}
        for pair, allowed in self.entries.items():
            for one, other in permutations(pair, 2):
                found.setdefault(one, {})[other] = allowed
        return found

    def with_entry(self, a: str, b: str, allowed: bool) -> "AllowedCollisions":
        """Return the matrix with one entry set."""
        return AllowedCollisions({**self.entries, frozenset((a, b)): allowed}, self.defaults)

    def without(self, name: str) -> "AllowedCollisions":
        """Return the matrix without the entries and the default of one name."""
        return AllowedCollisions(
            {pair: allowed for pair, allowed in self.entries.items() if name not in pair},
            {other: allowed for other, allowed in self.defaults.items() if other != name},
        )

    def with_default(self, name: str, allowed: bool) -> "AllowedCollisions":
        """Return the matrix with the default of one name set."""
        return AllowedCollisions(self.entries, {**self.defaults, name: allowed})


@dataclass(frozen=True)
class ContactAllowance:
    """A temporary intended contact: a part that is lifted off its table touches it at the start.

    `Scene.allow_contact` describes the fields.
    """

    name: str
    a: str
    b: str
    depth: float
    first: float
    last: float

    def __post_init__(self) -> None:
        one_of("name", self.name, str)
        for label in ("depth", "first", "last"):
            value = number(label, getattr(self, label))
            if value < 0.0:
                raise ShapeError(label, f"is negative: {value:g}")
            object.__setattr__(self, label, value)
        if self.first == 0.0 and self.last == 0.0:
            raise ModelError(f"allowance {shown(self.name)}: give its duration, `first` or `last` seconds")

    @property
    def pair(self) -> frozenset[str]:
        """The two names."""
        return frozenset((self.a, self.b))
