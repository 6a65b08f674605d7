"""Result of picking and placing."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from trajopt.planning.result import Result
from trajopt.simulation import SimulationOptions
from trajopt.tasks.grasping.grasp import Grasp, Place
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.tasks.sequence import MotionSequence, PlannedSegment
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import shown
from trajopt.values.errors.arguments import checked, checked_class

if TYPE_CHECKING:
    from trajopt.tasks.grasping.simulation import PickPlaceRollout


class Stage(Enum):
    """The stages of picking and placing, in order; each value describes its stage."""

    OPEN = "the fingers open"
    REACH = "the arm moves in front of the object"
    APPROACH = "the open fingers go straight to the object"
    CLOSE = "the fingers close on the object"
    LIFT = "the object is lifted straight off what it stands on"
    CARRY = "the object is carried"
    LOWER = "the object is lowered straight to where it will stand"
    RELEASE = "the fingers open and let go"
    RETREAT = "the open fingers go straight off the object"

    @property
    def holds(self) -> bool:
        """Whether the object is in the hand."""
        return self in {Stage.LIFT, Stage.CARRY, Stage.LOWER}


STAGES = tuple(Stage)
"""All stages, in order."""


@dataclass(frozen=True, eq=False)
class Segment(PlannedSegment):
    """One motion of a pick and place, of the arm or of the fingers.

    Attributes:
        rest: Rest at its end before the next motion [s].
    """

    stage: Stage
    result: Result
    rest: float = 0.0  # pyright: ignore[reportIncompatibleMethodOverride]

    @property
    def title(self) -> str:
        return self.stage.name


class Timeline:
    """All joints over the whole sequence: arm, fingers and the rests between.

    Attributes:
        begins: Start time of each, shape (number of segments,) [s].
    """

    def __init__(self, segments: Sequence[Segment]) -> None:
        self.segments = tuple(segments)
        ends = np.cumsum([0.0, *(segment.duration for segment in self.segments)])
        self.begins = readonly(ends[:-1])
        self.duration = float(ends[-1])

    @checked
    def segment_at(self, t: float) -> int:
        """Return the index of the motion that runs, or rests, at a time [s]; clipped to the duration."""
        return max(int(np.searchsorted(self.begins, t, side="right")) - 1, 0)

    def __call__(self, t: float) -> Floats:
        place = self.segment_at(t)
        return self.segments[place].positions(t - float(self.begins[place]))

    @property
    def gap(self) -> float:
        """Largest difference of any joint between the end of a motion and the start of the next [rad | m]."""
        pairs = zip(self.segments[:-1], self.segments[1:], strict=True)
        return max((float(np.abs(a.end - b.positions(0.0)).max()) for a, b in pairs), default=0.0)

    def __repr__(self) -> str:
        lines = (f"{t:7.2f} s  {s.stage.name}" for t, s in zip(self.begins, self.segments, strict=True))
        return "\n".join((f"Timeline of {self.duration:.2f} s", *lines))


@checked_class
@dataclass(frozen=True, eq=False, kw_only=True)
class PickPlaceResult(MotionSequence[Segment]):
    """A planned sequence of picking, placing or both; or why there is none.

    Attributes:
        grasp: The chosen grasp; None without one, or if the object was in the hand already.
        place: The chosen place; None without one.
    """

    gripper: Gripper
    grasp: Grasp | None
    place: Place | None
    segments: tuple[Segment, ...]

    @property
    def timeline(self) -> Timeline:
        """The whole motion, fingers included."""
        return Timeline(self.require())

    def segment(self, stage: Stage) -> Segment | None:
        return next((item for item in self.segments if item.stage is stage), None)

    def simulated(self, options: SimulationOptions | None = None) -> "PickPlaceRollout":
        from trajopt.tasks.grasping.simulation import simulate_handling

        return simulate_handling(self, options=options)

    @property
    def reason(self) -> str:
        how = f", by grasp {shown(self.grasp.name)}" if self.grasp else ""
        return super().reason + how + (f", put at {shown(self.place.name)}" if self.place else "")

    def as_dict(self) -> dict[str, object]:
        chosen = {"grasp": self.grasp, "place": self.place}
        return super().as_dict() | {key: None if item is None else item.name for key, item in chosen.items()}
