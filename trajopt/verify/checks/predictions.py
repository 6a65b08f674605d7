"""Predictions: a motion ends before the prediction of an object ends."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf

from trajopt.scene.timing import Timing
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.criterion import Criterion
from trajopt.verify.kernel.motion import Motion


@dataclass(frozen=True, eq=False)
class PredictionCriterion(Criterion):
    """Whether every prediction that ends covers the motion.

    Attributes:
        motion: The motion.
        timings: Of the objects that change with time.
    """

    motion: Motion
    timings: Mapping[str, Timing]

    def measure(self) -> Iterator[Check]:
        """State, for each prediction that ends, until when it is known and how long it is needed."""
        motion, needed = self.motion, self.motion.duration
        for name, timing in self.timings.items():
            if timing.motion is None or timing.motion.until == inf:
                continue
            until = timing.motion.until - motion.clock
            slack = until - min(needed, timing.expires - motion.clock)
            yield Check(
                kind=CheckKind.PREDICTION,
                name="prediction",
                subject=name,
                value=needed,
                bound=until,
                unit="s",
                time=None,
                slack=slack,
                evidence=Evidence.PROVEN if slack >= 0.0 else Evidence.UNPROVEN,
                holds=slack >= 0.0,
                detail=f"where {name} is, is known until {until:g} s, {needed:.3f} s are needed",
            )
