"""Result of picking and placing."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.simulation import SimulationOptions
from trajopt.tasks.grasping.grasp import Grasp, Place
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.tasks.sequence import MotionSequence, PlannedSegment
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import shown
from trajopt.values.errors.arguments import checked

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
    rest: float = 0.0

    @property
    def title(self) -> str:
        return self.stage.name

    @property
    def duration(self) -> float:
        return self.trajectory.duration + self.rest


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


@dataclass(frozen=True, eq=False)
class Refusal:
    """The reason why a grasp or a place was rejected.

    Attributes:
        grasp: Name of the grasp; empty if the object was in the hand from the beginning.
        place: Name of the place; empty if the grasp alone failed.
        result: The planning result; None if there was no configuration.
    """

    grasp: str
    place: str
    stage: Stage
    status: Status
    reason: str
    result: Result | None = None

    def __str__(self) -> str:
        which = [f"grasp {shown(self.grasp)}"] * bool(self.grasp) + [f"place {shown(self.place)}"] * bool(
            self.place
        )
        return f"{', '.join(which)}: {self.stage.name}: {self.reason}"


@dataclass(frozen=True, eq=False, kw_only=True)
class PickPlaceResult(MotionSequence[Segment]):
    """A planned sequence of picking, placing or both; or why there is none.

    Attributes:
        final_scene: The scene after: the object attached to the hand, or at its place, with the clock at 0 at
            the end of the sequence; the scene before without a sequence.
        start: Positions of all joints before, shape (number of joints,) [rad | m].
        status: If all candidates failed, of the one that got farthest.
        grasp: The chosen grasp; None without one, or if the object was in the hand already.
        place: The chosen place; None without one.
        segments: The motions, in order; empty without a solution.
        refusals: The rejected candidates with reasons, in the order of the search.
        cpu_seconds: Process time of each stage of planning [s].
        stopped: The cause of an early end of planning; None without one.
    """

    gripper: Gripper
    grasp: Grasp | None
    place: Place | None
    segments: tuple[Segment, ...]
    refusals: tuple[Refusal, ...]

    @property
    def failed(self) -> Stage | None:
        """The last stage that any candidate reached; None if there is a sequence."""
        if self.segments or not self.refusals:
            return None
        return max((refusal.stage for refusal in self.refusals), key=STAGES.index)

    @property
    def timeline(self) -> Timeline:
        """The whole motion, fingers included."""
        return Timeline(self.require())

    @checked
    def segment(self, stage: Stage) -> Segment | None:
        return next((item for item in self.segments if item.stage is stage), None)

    @checked
    def simulated(self, options: SimulationOptions | None = None) -> "PickPlaceRollout":
        """Execute the sequence as `simulate_handling` does; `trajopt.simulate(result)` calls this."""
        from trajopt.tasks.grasping.simulation import simulate_handling

        return simulate_handling(self, options=options)

    @property
    def reason(self) -> str:
        """The outcome in a sentence: the planned sequence, or the failed stage."""
        if self.segments:
            how = f" by grasp {shown(self.grasp.name)}" if self.grasp else ""
            where = f", put at {shown(self.place.name)}" if self.place else ""
            steps = ", ".join(f"{item.stage.name} {item.duration:.2f} s" for item in self.segments)
            return f"{shown(self.name)} is taken{how}{where}: {steps}"
        stage = "" if self.failed is None else f"; the farthest candidate failed in {self.failed.name}"
        return f"{self.status.name}: {self.status.value} (no sequence for {shown(self.name)}{stage})"

    def _details(self) -> tuple[str, tuple[str, ...]]:
        return f"{len(self.refusals)} candidates", () if self.verified else self.causes

    @property
    def causes(self) -> tuple[str, ...]:
        return tuple(map(str, self.refusals))

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data: the motions with their times, and the rejected candidates."""
        begins: list[float] = list(self.timeline.begins) if self.segments else []
        return {
            "status": self.status.name,
            "verified": self.verified,
            "message": str(self.explain()),
            "object": self.name,
            "grasp": None if self.grasp is None else self.grasp.name,
            "place": None if self.place is None else self.place.name,
            "segments": [
                {"stage": item.stage.name, "begin": float(begin), "rest": item.rest, **item.result.as_dict()}
                for begin, item in zip(begins, self.segments, strict=True)
            ],
            "refusals": [
                {
                    "grasp": item.grasp,
                    "place": item.place,
                    "stage": item.stage.name,
                    "status": item.status.name,
                    "reason": item.reason,
                }
                for item in self.refusals
            ],
            "counts": dict(self.counts),
            "cpu_seconds": {**self.cpu_seconds, "total": sum(self.cpu_seconds.values())},
            "stopped": None if self.stopped is None else self.stopped.name,
        }
