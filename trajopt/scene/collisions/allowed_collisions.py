"""Which pairs of links and objects may touch: MoveIt's allowed-collision matrix as a value."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import permutations

from trajopt.values.arrays import Value, number, one_of
from trajopt.values.errors import ModelError, ShapeError, shown


@dataclass(frozen=True)
class AllowedCollisions(Value):
    """Allowed-collision matrix.

    An entry for a pair decides; without one the default of a name that has one, and where both
    have one the pair is allowed if both allow it; without any the pair is checked.

    Attributes:
        entries: Pair of names -> whether contact is allowed.
        defaults: Name -> whether contact with anything is allowed.
    """

    entries: Mapping[frozenset[str], bool] = field(default_factory=dict[frozenset[str], bool])
    defaults: Mapping[str, bool] = field(default_factory=dict[str, bool])

    def allowed(self, a: str, b: str) -> bool:
        """Say whether contact between two named things is allowed."""
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
    """Intended contact, for a time: the part lifted off its table touches it at the start.

    Attributes:
        name: What it is for, shown in the certificate.
        a: One link or object.
        b: The other.
        depth: Deepest penetration accepted [m].
        first: Contact is accepted during the first seconds of the motion [s].
        last: Contact is accepted during the last seconds of the motion [s].
    """

    name: str
    a: str
    b: str
    depth: float
    first: float
    last: float

    def __post_init__(self) -> None:
        """Check that the numbers are not negative, and that the allowance has a time."""
        one_of("name", self.name, str)
        for label in ("depth", "first", "last"):
            value = number(label, getattr(self, label))
            if value < 0.0:
                raise ShapeError(label, f"is negative: {value:g}")
            object.__setattr__(self, label, value)
        if self.first == 0.0 and self.last == 0.0:
            raise ModelError(f"allowance {shown(self.name)}: say for how long, `first` or `last` seconds")

    @property
    def pair(self) -> frozenset[str]:
        """The two names."""
        return frozenset((self.a, self.b))
