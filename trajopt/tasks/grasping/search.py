"""The search for a sequence: grasps in order, places in order, the cheap checks of all stages first."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, partial

from trajopt.planning.budget import Stop, Stopped
from trajopt.planning.search import ENDED
from trajopt.planning.status import Status
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.candidates import (
    PickCandidate,
    PlaceCandidate,
    PlannedStages,
    pick_candidates,
    place_candidates,
    plan_pick,
    plan_place,
)
from trajopt.tasks.grasping.grasp import Grasp, Place
from trajopt.tasks.grasping.result import STAGES, PickPlaceResult, Refusal, Segment
from trajopt.tasks.grasping.task import CandidateNames, Moment, Task, later
from trajopt.values.arrays import Floats

Before = Callable[[], PlannedStages | None]
"""Plans the preceding motions; None if that fails."""
Remembered = tuple[list[PlaceCandidate], Iterator[PlaceCandidate | Refusal]]
"""Known candidates of a place, and the source of further ones."""


@dataclass(frozen=True, eq=False)
class PlannedSequence:
    """A planned sequence.

    Attributes:
        segments: Its motions.
        final_scene: The scene after it.
        grasp: The grasp; None if the object was in the hand already.
        place: The place; None if the object stays in the hand.
    """

    segments: tuple[Segment, ...]
    final_scene: Scene
    grasp: Grasp | None
    place: Place | None


@dataclass(eq=False)
class Search:
    """A search for a sequence, and the rejected candidates.

    Attributes:
        task: The task.
        places: Places of the object; empty to keep it in the hand.
        refusals: The rejected candidates with reasons, in order.
    """

    task: Task
    places: tuple[Place, ...]
    refusals: list[Refusal] = field(default_factory=list[Refusal])
    _candidates: dict[tuple[Grasp | None, Place], Remembered] = field(
        default_factory=dict[tuple[Grasp | None, Place], Remembered]
    )

    def take(self, grasps: Sequence[Grasp]) -> PickPlaceResult:
        """Try grasps in order, each with all places."""
        return self._result(lambda: self._take(grasps))

    def place(self, opening: float) -> PickPlaceResult:
        """Try places in order for the object that is in the hand at the start.

        Args:
            opening: Of the fingers at release [m].
        """
        return self._result(lambda: self._put(self.task.scene, self.task.start, opening, grasp=None))

    def _take(self, grasps: Sequence[Grasp]) -> PlannedSequence | None:
        for grasp in grasps:
            for candidate in pick_candidates(self.task, grasp):
                if isinstance(candidate, Refusal):
                    self.refusals.append(candidate)
                    continue
                sequence = self._from(candidate)
                if sequence is not None:
                    return sequence
        return None

    def _put(
        self, held: Scene, start: Floats, opening: float, *, grasp: Grasp | None, before: Before | None = None
    ) -> PlannedSequence | None:
        """Try places in order for an object in the hand.

        Args:
            held: The scene with the object in the hand.
            start: Approximate positions of all joints before the transfer [rad | m].
            opening: Of the fingers at release [m].
            grasp: The grasp; None if unknown.
            before: Plans the preceding motions, when first needed; None if that fails.
        """
        name = "" if grasp is None else grasp.name
        for place in self.places:
            names = CandidateNames(grasp=name, place=place.name)
            make = partial(place_candidates, self.task, held, start, place, opening=opening, names=names)
            for candidate in self._remembered((grasp, place), make):
                first = PlannedStages((), held) if before is None else before()
                if first is None:
                    return None
                moment = Moment(self.task.start).after(first.segments)
                then = plan_place(self.task, first.scene, candidate, moment, names)
                if not isinstance(then, Refusal):
                    return PlannedSequence((*first.segments, *then.segments), then.scene, grasp, place)
                self.refusals.append(then)
        return None

    def _result(self, search: Callable[[], PlannedSequence | None]) -> PickPlaceResult:
        """Search until the budget ends, and return the sequence, or the reason why there is none."""
        task, stopped = self.task, None
        try:
            sequence = search()
        except Stopped as ended:
            sequence, stopped = None, ended.stop
        final = task.scene
        if sequence is not None:
            final = later(sequence.final_scene, Moment(task.start).after(sequence.segments).time)
        return PickPlaceResult(
            name=task.name,
            scene=task.scene,
            final_scene=final,
            start=task.start,
            group=task.group,
            gripper=task.gripper,
            status=Status.SOLVED if sequence is not None else self._failure(stopped),
            grasp=None if sequence is None else sequence.grasp,
            place=None if sequence is None else sequence.place,
            segments=() if sequence is None else sequence.segments,
            refusals=tuple(self.refusals),
            counts=dict(task.tracker.counts),
            cpu_seconds=dict(task.tracker.seconds),
            stopped=stopped,
        )

    def _failure(self, stopped: Stop | None) -> Status:
        """Return the cause of the search's end, or the status of the candidate that got farthest."""
        if stopped is not None:
            return ENDED[stopped]
        return max(self.refusals, key=lambda refusal: STAGES.index(refusal.stage)).status

    def _remembered(
        self, key: tuple[Grasp | None, Place], make: Callable[[], Iterator[PlaceCandidate | Refusal]]
    ) -> Iterator[PlaceCandidate]:
        """Yield the candidates of a place, searched once for each grasp, independent of the arm's posture."""
        known, others = self._candidates.setdefault(key, ([], make()))
        yield from tuple(known)
        for candidate in others:
            if isinstance(candidate, Refusal):
                self.refusals.append(candidate)
            else:
                known.append(candidate)
                yield candidate

    def _from(self, candidate: PickCandidate) -> PlannedSequence | None:
        """Plan a grasp that passed the cheap checks, and the following motions."""

        @cache
        def picked() -> PlannedStages | None:
            planned = plan_pick(self.task, candidate)
            if isinstance(planned, Refusal):
                self.refusals.append(planned)
                return None
            return planned

        if self.places:
            opening = candidate.grasp.opening
            return self._put(candidate.held, candidate.lifted, opening, grasp=candidate.grasp, before=picked)
        taken = picked()
        return None if taken is None else PlannedSequence(taken.segments, taken.scene, candidate.grasp, None)
