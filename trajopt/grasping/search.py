"""The search for a sequence: grasps in order, places in order, the cheap checks of all stages first."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, partial

from trajopt.arrays import Floats
from trajopt.grasping.candidates import (
    PickCandidate,
    PlaceCandidate,
    pick_candidates,
    place_candidates,
    plan_pick,
    plan_place,
)
from trajopt.grasping.grasp import Grasp, Place
from trajopt.grasping.result import PickPlaceResult, Refusal, Segment
from trajopt.grasping.task import CandidateNames, Task
from trajopt.model.scene import Scene

Before = Callable[[], tuple[Segment, ...] | None]
"""Plans what comes before; None where it cannot be."""
Remembered = tuple[list[PlaceCandidate], Iterator[PlaceCandidate | Refusal]]
"""Candidates of a place that were found, and where more come from."""


@dataclass(frozen=True, eq=False)
class Found:
    """A sequence that was found.

    Attributes:
        segments: Its motions.
        final_scene: The scene after it.
        place: Where the object was put; None for nowhere.
    """

    segments: tuple[Segment, ...]
    final_scene: Scene
    place: Place | None


@dataclass(eq=False)
class Search:
    """A search for a sequence: what it was asked, and what it has given up.

    Attributes:
        task: What is to be done.
        places: Where the object may be put; none to keep it in the hand.
        refusals: What was given up, in order.
        began: Process time at its beginning [s].
    """

    task: Task
    places: tuple[Place, ...]
    refusals: list[Refusal] = field(default_factory=list[Refusal])
    began: float = field(default_factory=time.process_time)
    _candidates: dict[tuple[Grasp | None, Place], Remembered] = field(
        default_factory=dict[tuple[Grasp | None, Place], Remembered]
    )

    def take(self, grasps: Sequence[Grasp]) -> PickPlaceResult:
        """Try grasps in order, each with all places."""
        for grasp in grasps:
            for candidate in pick_candidates(self.task, grasp):
                if isinstance(candidate, Refusal):
                    self.refusals.append(candidate)
                    continue
                found = self._from(candidate)
                if found is not None:
                    return self.ended(found, grasp)
        return self.ended(None, None)

    def put(
        self, held: Scene, start: Floats, opening: float, *, grasp: Grasp | None, before: Before | None = None
    ) -> Found | None:
        """Try places in order for an object in the hand.

        Args:
            held: The scene with the object in the hand.
            start: Positions of all joints from which it is carried, nearly [rad | m].
            opening: Of the fingers that let go [m].
            grasp: How it is held; None where that is not known.
            before: Plans what comes before, when first needed; None if it cannot be.
        """
        name = "" if grasp is None else grasp.name
        for place in self.places:
            names = CandidateNames(grasp=name, place=place.name)
            make = partial(place_candidates, self.task, held, start, place, opening=opening, names=names)
            for candidate in self._remembered((grasp, place), make):
                first = () if before is None else before()
                if first is None:
                    return None
                then = plan_place(self.task, candidate, first[-1].end if first else start, names)
                if not isinstance(then, Refusal):
                    return Found((*first, *then), candidate.put, place)
                self.refusals.append(then)
        return None

    def ended(self, found: Found | None, grasp: Grasp | None) -> PickPlaceResult:
        """Return what the search has come to."""
        task = self.task
        return PickPlaceResult(
            name=task.name,
            scene=task.scene,
            final_scene=task.scene if found is None else found.final_scene,
            start=task.start,
            group=task.group,
            gripper=task.gripper,
            grasp=None if found is None else grasp,
            place=None if found is None else found.place,
            segments=() if found is None else found.segments,
            refusals=tuple(self.refusals),
            counts=dict(task.counts),
            cpu_seconds=time.process_time() - self.began,
        )

    def _remembered(
        self, key: tuple[Grasp | None, Place], make: Callable[[], Iterator[PlaceCandidate | Refusal]]
    ) -> Iterator[PlaceCandidate]:
        """Yield the candidates of a place, looked for once a grasp: the arm's posture in it is no matter."""
        known, others = self._candidates.setdefault(key, ([], make()))
        yield from tuple(known)
        for candidate in others:
            if isinstance(candidate, Refusal):
                self.refusals.append(candidate)
            else:
                known.append(candidate)
                yield candidate

    def _from(self, candidate: PickCandidate) -> Found | None:
        """Plan a grasp that passed the cheap checks, and all that follows."""

        @cache
        def picked() -> tuple[Segment, ...] | None:
            planned = plan_pick(self.task, candidate)
            if isinstance(planned, Refusal):
                self.refusals.append(planned)
                return None
            return planned

        if self.places:
            opening = candidate.grasp.opening
            return self.put(candidate.held, candidate.lifted, opening, grasp=candidate.grasp, before=picked)
        segments = picked()
        return None if segments is None else Found(segments, candidate.held, None)
