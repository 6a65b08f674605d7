"""Evidence about a pair of links: exact binomial bounds on its collision rate."""

from dataclasses import dataclass
from enum import Enum
from math import ceil, log, log1p

from trajopt.values.arrays import Floats, Value
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked


class Verdict(Enum):
    """Verdict on a pair of links; the value is its reason in an SRDF, if the pair is disabled."""

    ADJACENT = "Adjacent"
    ALWAYS = "Always"
    NEVER = "Never"
    DEFAULT = "Default"
    SOMETIMES = ""


@checked
@dataclass(frozen=True, kw_only=True)
class Confidence:
    """Required confidence that a pair never collides.

    All pairs without a collision share the risk equally (Bonferroni), so that the statement holds for all of
    them jointly: with this confidence none collides in a larger share of the configurations.

    Attributes:
        share: Share of the configurations, in (0, 1).
        level: The confidence, in (0, 1).
    """

    share: float = 1e-4
    level: float = 0.99

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("share", "level"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise ProblemError(f"Confidence.{name} must lie in (0, 1), is {getattr(self, name)}")

    @checked
    def samples(self, pairs: int) -> int:
        """Return the required number of samples without a collision.

        No collision in N has the probability (1 - share)^N, which must not exceed the risk of one pair,
        (1 - level) / pairs. One pair at 95 % is the rule of three: N = 3 / share.

        Args:
            pairs: Number of pairs, at least 1.
        """
        return ceil(log((1.0 - self.level) / pairs) / log1p(-self.share))

    @checked
    def upper(self, collisions: int, samples: int, *, pairs: int) -> float:
        """Bound the share of configurations in collision from above, for one of several pairs.

        Source: Clopper and Pearson, Biometrika 1934 (one-sided).

        Args:
            collisions: Configurations in collision.
            samples: Configurations examined.
            pairs: Pairs that share the risk.
        """
        from scipy.special import betaincinv

        if collisions == samples:
            return 1.0
        return float(betaincinv(collisions + 1, samples - collisions, 1.0 - (1.0 - self.level) / pairs))

    @checked
    def lower(self, collisions: int, samples: int, *, pairs: int) -> float:
        """Bound the share of configurations in collision from below; see `upper`."""
        from scipy.special import betaincinv

        if collisions == 0:
            return 0.0
        return float(betaincinv(collisions, samples - collisions + 1, (1.0 - self.level) / pairs))


DEFAULT_CONFIDENCE = Confidence()


@dataclass(frozen=True, kw_only=True, eq=False)
class PairEvidence(Value):
    """Evidence about two links.

    Attributes:
        first: One link.
        second: The other.
        verdict: The verdict on the pair.
        collisions: Number of sampled configurations in collision.
        samples: Number of sampled configurations; 0 for links that cannot move relative to each other.
        lower: Lower bound on the share of configurations in collision.
        upper: Upper bound on that share.
        nearest: Smallest signed distance, also of the descent [m]; NaN if not measured.
        at: Positions of all driven joints there [rad | m]; empty if not measured.
        descended: Whether the collision was only found by descent from the nearest sample.
    """

    first: str
    second: str
    verdict: Verdict
    collisions: int
    samples: int
    lower: float
    upper: float
    nearest: float
    at: Floats
    descended: bool

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
        """Summarise the evidence in a line."""
        name = f"{self.first} and {self.second}"
        if self.samples == 0:
            return f"{name}: fixed to each other"
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
