"""Timeline: the motions of a handling one after the other."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from trajopt.arrays import Floats, readonly

if TYPE_CHECKING:
    from trajopt.grasping.handling import Segment


class Timeline:
    """All joints over the time of a whole handling: arm, fingers and the rests between.

    Attributes:
        segments: The motions, in order.
        begins: When each begins, shape (number of segments,) [s].
        duration: Of all [s].
    """

    def __init__(self, segments: "Sequence[Segment]") -> None:
        """Lay the motions behind each other."""
        self.segments = tuple(segments)
        ends = np.cumsum([0.0, *(segment.duration for segment in self.segments)])
        self.begins = readonly(ends[:-1])
        self.duration = float(ends[-1])

    def segment_at(self, t: float) -> int:
        """Return the place of the motion that runs, or rests, at a time [s]; clipped to the duration."""
        return max(int(np.searchsorted(self.begins, t, side="right")) - 1, 0)

    def __call__(self, t: float) -> Floats:
        """Return positions of all joints at a time [s], clipped to the duration; shape (joints,)."""
        place = self.segment_at(t)
        return self.segments[place].positions(t - float(self.begins[place]))

    @property
    def gap(self) -> float:
        """Largest difference of any joint between the end of a motion and the start of the next [rad | m]."""
        pairs = zip(self.segments[:-1], self.segments[1:], strict=True)
        return max((float(np.abs(a.end - b.positions(0.0)).max()) for a, b in pairs), default=0.0)

    def __repr__(self) -> str:
        """List the stages with their beginnings."""
        lines = (f"{t:7.2f} s  {s.stage.name}" for t, s in zip(self.begins, self.segments, strict=True))
        return "\n".join((f"Timeline of {self.duration:.2f} s", *lines))
