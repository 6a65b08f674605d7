"""Links that no joint of the group moves: what comes too near to one does so whatever the robot does.

So a motion has to be over before. Where none within the limits can be, that is proven: such a pair is as near
to each other in all configurations, and the judge measures it in one.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.planning.infeasibility.in_time import InTime
from trajopt.planning.infeasibility.occupied import Span
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_length


@dataclass(frozen=True, kw_only=True)
class FixedLinkMet:
    """Something that comes too near to a link that no joint of the group moves, before a motion is over.

    Attributes:
        span: What comes near to which link, when, and by how much too near.
        over: No motion is over before [s]: none within the limits where that is proven, else none found.
        dwell: For so long it stays at its end [s].
        proven: Whether it is proven.
    """

    span: Span
    over: float
    dwell: float
    proven: bool

    @property
    def words(self) -> str:
        """Say what is met, when, and that no motion changes it."""
        over = f"no motion within the limits is over before {self.over:.2f} s"
        if not self.proven:
            over = f"the motion without what changes takes {self.over:.2f} s"
        stays = f" and then stays for {self.dwell:g} s" if self.dwell > 0.0 else ""
        return f"{met_words(self.span)}, whatever the robot does, and {over}{stays}"


def met_words(span: Span) -> str:
    """Say that a link is met that no joint of the group moves, when, and how near."""
    return (
        f"{span.thing} meets {span.link}, which no joint of the group moves, {span.when} "
        f"({in_length(span.depth)} nearer than it may be at {span.worst:.2f} s)"
    )


@dataclass(eq=False)
class FixedLinks:
    """Looks at the links of one problem's robot that no joint of the group moves; one for each thread.

    Attributes:
        in_time: Looks for reasons in time.
    """

    in_time: InTime

    def met(self, takes: float | None = None) -> FixedLinkMet | None:
        """Find what meets such a link before a motion is over.

        Args:
            takes: How long the motion that was found without what changes takes [s]; when None only a proof
                counts.
        """
        dwell, least = self.in_time.problem.dwell, self.in_time.earliest
        over = least if takes is None else max(least, takes)
        if not self._too_near(over + dwell):
            return None
        proven = self._is_met(least + dwell)
        if takes is None and not proven:
            return None
        return FixedLinkMet(span=self.spans[0], over=least if proven else over, dwell=dwell, proven=proven)

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """What meets such a link, in order of time, as long as anything changes."""
        looks = self.in_time.looks
        return self.in_time.occupancy.met(self._start(len(looks)), looks, self.in_time.occupancy.fixed)

    def _too_near(self, until: float) -> list[float]:
        """Return the times up to another at which something is too near to such a link, the worst first."""
        looks, occupancy = self.in_time.looks, self.in_time.occupancy
        looks = looks[looks <= until]
        sample, _, depth = occupancy.too_near(self._start(len(looks)), looks, occupancy.fixed)
        return looks[sample[np.argsort(-depth, kind="stable")]].tolist()

    def _is_met(self, until: float) -> bool:
        """Prove that something is too near to such a link at a time up to another."""
        occupancy = self.in_time.occupancy
        return any(
            occupancy.is_met(self._start(1)[0], time, occupancy.fixed) for time in self._too_near(until)[:1]
        )

    def _start(self, count: int) -> Floats:
        """Return the start, which is as good as any configuration, so many times, (count, n) [rad | m]."""
        return np.tile(self.in_time.problem.reduced.start_positions, (count, 1))
