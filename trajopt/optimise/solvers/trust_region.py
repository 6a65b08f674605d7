"""The trust region of a solver: a box, and the rule that sizes it."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class TrustRegion:
    """A box around the current point, in units of the program's scale, and the rule that sizes it.

    Attributes:
        radius: Half the edge now.
        smallest: Below this it has collapsed.
        largest: It never grows beyond this.
        accept: A step is taken when it brings at least this share of the predicted improvement.
        good: The box grows when it brings at least this share.
        grow: Factor on growth.
        shrink: Factor on rejection.
    """

    radius: float = 1.0
    smallest: float = 1e-4
    largest: float = 1.0
    accept: float = 0.1
    good: float = 0.5
    grow: float = 2.0
    shrink: float = 0.3

    def accepts(self, ratio: float) -> bool:
        """Say whether a step with this ratio of actual to predicted improvement is taken."""
        return ratio >= self.accept

    def after(self, ratio: float) -> "TrustRegion":
        """Return the region after a step with this ratio of actual to predicted improvement."""
        if not self.accepts(ratio):
            return self.smaller()
        if ratio >= self.good:
            return replace(self, radius=min(self.radius * self.grow, self.largest))
        return self

    def smaller(self) -> "TrustRegion":
        """Return the region after a step that is not taken."""
        return replace(self, radius=self.radius * self.shrink)

    @property
    def collapsed(self) -> bool:
        """Whether no step worth taking is left."""
        return self.radius < self.smallest
