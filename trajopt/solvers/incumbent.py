"""The best point met so far, so that no solver returns worse than its first guess."""

from dataclasses import dataclass, field

import numpy as np

from trajopt.arrays import Floats
from trajopt.nlp import Linearisation, Nlp


def improves(at: Linearisation, on: Linearisation) -> bool:
    """Say whether a point is better than another: feasible first, then by cost, or else by violation."""
    if not finite(at) or not finite(on):
        return finite(at)
    if at.feasible != on.feasible:
        return at.feasible
    if at.feasible:
        return at.cost < on.cost
    return at.violation < on.violation


def finite(at: Linearisation) -> bool:
    """Say whether costs and violations of a point are numbers."""
    return bool(np.isfinite(at.cost + at.violation))


@dataclass(eq=False)
class Incumbent:
    """The best of the points that were offered; all of them on the same samples.

    Attributes:
        nlp: The program.
        seed: The first guess, within bounds, shape (N, n).
        best: The best point so far.
    """

    nlp: Nlp
    seed: Floats
    best: Linearisation = field(init=False)

    def __post_init__(self) -> None:
        """Begin with the first guess, on coarse samples."""
        self.best = self.nlp.linearise(self.seed, self.nlp.sampling(self.seed, fine=False))

    def offer(self, at: Linearisation) -> None:
        """Take a point if it is better."""
        if improves(at, self.best):
            self.best = at

    def refine(self) -> bool:
        """Look at the best point on as many samples as it needs; return whether these are new."""
        needed = np.maximum(self.best.sampling, self.nlp.sampling(self.best.x, fine=True))
        if (needed == self.best.sampling).all():
            return False
        self.best = self.nlp.linearise(self.best.x, needed)
        return True

    def settle(self) -> Linearisation:
        """Return the better of the best point and the first guess, compared on samples fine enough."""
        while True:
            self.refine()
            self.offer(self.nlp.linearise(self.seed, self.best.sampling))
            if not self.refine():
                return self.best
