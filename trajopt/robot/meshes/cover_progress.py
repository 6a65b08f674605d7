"""A line now and then while the meshes of a robot are covered, where that takes long."""

import logging
from dataclasses import dataclass, field
from time import monotonic

FIRST = 1.0
"""What takes less long is not told [s]: nobody waits for it."""
_EVERY = 2.0  # between two lines [s]
_LOG = logging.getLogger("trajopt.robot")


@dataclass
class CoverProgress:
    """Says how many meshes are done, once covering them has taken a second of the clock, then every two.

    The lines go to the logger "trajopt.robot" as warnings, which Python shows on standard error where nobody
    has set up logging: they tell why a first load is slow, and that the next will not be.

    Attributes:
        total: How many meshes there are.
        done: How many are covered.
    """

    total: int
    done: int = 0
    _next: float = field(default_factory=lambda: monotonic() + FIRST)

    def step(self, link: str) -> None:
        """Count one mesh.

        Args:
            link: The link that has it.
        """
        self.done += 1
        if self.done < self.total and monotonic() >= self._next:
            self._next = monotonic() + _EVERY
            _LOG.warning(
                "covering collision meshes by convex pieces, kept for the next time: %d of %d done, last %s",
                self.done,
                self.total,
                link,
            )
