"""Picking and placing as one sequence: candidates in order, the cheap checks of all stages first."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from threading import Event

import numpy as np

from trajopt.planning.budget import Budget, BudgetTracker, Progress, Stop, Stopped
from trajopt.planning.plan import NO_BOUNDS
from trajopt.planning.search import ENDED
from trajopt.planning.status import Status
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import Constraint
from trajopt.robot.configuration import ConfigurationLike, stated_configuration
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
from trajopt.tasks.grasping.grasp import Grasp, GraspingOptions, Place
from trajopt.tasks.grasping.gripper import Gripper, arm_of, gripper_of
from trajopt.tasks.grasping.result import STAGES, PickPlaceResult, Refusal, Segment
from trajopt.tasks.grasping.task import CandidateNames, PickPlaceTask, TimedConfiguration, later
from trajopt.values.arrays import Floats, one_of, sequence, several, unless_none
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD

Constraints = Sequence[Requirement | Constraint]
"""Path constraints while the object is in the hand."""
LET_GO = 0.02
"""Default opening of the fingers at release, in addition to the grasp [m]."""
MET = "only what stands is picked and placed: meet it by plan, with a goal whose reference it is"
"""Remedy for dynamic obstacles."""


@checked
def pick_and_place(
    scene: Scene,
    name: str,
    *,
    start: ConfigurationLike,
    grasps: Sequence[Grasp],
    places: Place | Sequence[Place],
    group: str = "",
    gripper: Gripper | None = None,
    constraints: Constraints = (),
    options: GraspingOptions | None = None,
    rng: np.random.Generator | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
    progress: Progress | None = None,
    degrees: bool = False,
) -> PickPlaceResult:
    """Plan to pick up an object and place it elsewhere, as one sequence that is verified stage by stage.

    Grasps are tried in order, and for each the places in order. Inverse kinematics and the straight lines of
    all stages are checked first; then the motions are planned in order, each judged in its own scene: the
    object is an obstacle, then attached, then an obstacle again. Among dynamic obstacles each motion starts
    at its time in the sequence, and stays clear while the fingers close or open.

    Args:
        scene: Robot and objects; the object is at rest in it.
        start: Configuration of the robot.
        grasps: In order of preference.
        places: In order of preference.
        group: May be omitted if the SRDF defines the parent of the hand.
        gripper: The gripper; that of the robot's SRDF if None.
        constraints: Path constraints while the object is in the hand, such as keeping it upright.
        options: Speeds, tolerances, times.
        rng: Draws starts of the search; a fixed seed if None, for reproducible results.
        budget: Time and work for the whole sequence; its `attempts` are for each motion, 16 if None.
        cancel: Set it from another thread to stop.
        progress: Called at every stage and every step of the solver.
        degrees: Whether angles in `start` are in degrees.

    Raises:
        ObjectNotFound: If there is no object of that name.
        GripperError: If the robot has no gripper.
        ProblemError: If there is no grasp or no place, the object is already in the hand, it or its target
            support moves by itself, or the budget requests improvement.
    """
    tracker = _tracker(budget, cancel, progress)
    task = _task(scene, name, start, group, gripper, constraints, options, rng, tracker, degrees=degrees)
    return PickPlaceSearch(task, _places(task.scene, places)).take(_graspable(task, grasps))


@checked
def pick(
    scene: Scene,
    name: str,
    *,
    start: ConfigurationLike,
    grasps: Sequence[Grasp],
    group: str = "",
    gripper: Gripper | None = None,
    constraints: Constraints = (),
    options: GraspingOptions | None = None,
    rng: np.random.Generator | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
    progress: Progress | None = None,
    degrees: bool = False,
) -> PickPlaceResult:
    """Plan to pick up an object and lift it; see `pick_and_place`.

    In `final_scene` the object is attached to the hand.
    """
    tracker = _tracker(budget, cancel, progress)
    task = _task(scene, name, start, group, gripper, constraints, options, rng, tracker, degrees=degrees)
    return PickPlaceSearch(task, ()).take(_graspable(task, grasps))


@checked
def place(
    scene: Scene,
    name: str,
    *,
    start: ConfigurationLike,
    places: Place | Sequence[Place],
    opening: float | None = None,
    group: str = "",
    gripper: Gripper | None = None,
    constraints: Constraints = (),
    options: GraspingOptions | None = None,
    rng: np.random.Generator | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
    progress: Progress | None = None,
    degrees: bool = False,
) -> PickPlaceResult:
    """Plan to place an object that is in the hand; other arguments are as for `pick_and_place`.

    Args:
        scene: Robot and objects; the object is attached to the hand.
        start: Configuration of the robot, with its fingers at the object.
        opening: Of the fingers at release [m]; 2 cm more than at the start if None, or the largest possible.

    Raises:
        ProblemError: If the object is not attached.
    """
    tracker = _tracker(budget, cancel, progress)
    task = _task(scene, name, start, group, gripper, constraints, options, rng, tracker, degrees=degrees)
    if scene.holder(name).link == WORLD:
        raise ProblemError(f"object {shown(name)} is not in a hand; pick it first, or attach it")
    if opening is None:
        opening = task.gripper.opening_at(scene.robot, task.start) + LET_GO
    opening = min(opening, task.gripper.widest)
    return PickPlaceSearch(task, _places(task.scene, places)).place(opening)


def _task(
    scene: Scene,
    name: str,
    start: ConfigurationLike,
    group: str,
    gripper: Gripper | None,
    constraints: Constraints,
    options: GraspingOptions | None,
    rng: np.random.Generator | None,
    tracker: BudgetTracker,
    *,
    degrees: bool,
) -> PickPlaceTask:
    robot = one_of("scene", scene, Scene).robot
    scene.object(one_of("name", name, str))
    hand = gripper_of(robot) if gripper is None else one_of("gripper", gripper, Gripper)
    arm = one_of("group", group, str) or arm_of(robot, hand)
    robot.group(arm)
    return PickPlaceTask(
        scene=scene,
        name=name,
        start=stated_configuration(robot, "start", start, group=arm, degrees=degrees),
        group=arm,
        gripper=hand,
        constraints=sequence("constraints", constraints),
        options=unless_none("options", options, GraspingOptions) or GraspingOptions(),
        rng=unless_none("rng", rng, np.random.Generator) or np.random.default_rng(0),
        tracker=tracker,
    )


def _tracker(budget: Budget, cancel: Event | None, progress: Progress | None) -> BudgetTracker:
    if one_of("budget", budget, Budget).improve:
        raise ProblemError("the first verified sequence is taken: a budget that improves is for plan")
    return BudgetTracker(budget, cancel, progress)


def _places(scene: Scene, places: Place | Sequence[Place]) -> tuple[Place, ...]:
    listed = several("places", (places,) if isinstance(places, Place) else places, Place)
    if not listed:
        raise ProblemError("name at least one place to put the object")
    for each in listed:
        for frame in (each.frame, each.lower.frame, each.retreat.frame):
            scene.holder(frame)
        if (carrier := scene.carrier(each.frame)) is not None:
            raise ProblemError(
                f"place {shown(each.name)} is on {shown(carrier)}, which moves by itself; {MET}"
            )
    return listed


def _graspable(task: PickPlaceTask, grasps: Sequence[Grasp]) -> tuple[Grasp, ...]:
    listed = several("grasps", grasps, Grasp)
    if not listed:
        raise ProblemError(f"name at least one grasp of {shown(task.name)}")
    for each in listed:
        for frame in (each.approach.frame, each.lift.frame):
            task.scene.holder(frame)
    if task.scene.holder(task.name).link != WORLD:
        raise ProblemError(f"object {shown(task.name)} is in a hand already; place it, or detach it first")
    if task.name in task.scene.changing:
        raise ProblemError(f"object {shown(task.name)} moves by itself, or is there for a time only; {MET}")
    return listed


Before = Callable[[], PlannedStages | None]
"""Plans the preceding motions; None if that fails."""
Remembered = tuple[list[PlaceCandidate], Iterator[PlaceCandidate | Refusal]]
"""Known candidates of a place, and the source of further ones."""


@dataclass(frozen=True, eq=False)
class PlannedSequence:
    """A planned sequence.

    Attributes:
        grasp: The grasp; None if the object was in the hand already.
        place: The place; None if the object stays in the hand.
    """

    segments: tuple[Segment, ...]
    final_scene: Scene
    grasp: Grasp | None
    place: Place | None


@dataclass(eq=False)
class PickPlaceSearch:
    """A search for a sequence, and the rejected candidates.

    Attributes:
        places: Places of the object; empty to keep it in the hand.
        refusals: The rejected candidates with reasons, in order.
    """

    task: PickPlaceTask
    places: tuple[Place, ...]
    refusals: list[Refusal] = field(default_factory=list[Refusal])
    _candidates: dict[tuple[Grasp | None, Place], Remembered] = field(
        default_factory=dict[tuple[Grasp | None, Place], Remembered]
    )

    def take(self, grasps: Sequence[Grasp]) -> PickPlaceResult:
        return self._result(lambda: self._take(grasps))

    def place(self, opening: float) -> PickPlaceResult:
        """Try places in order for an object that is in the hand; fingers open to `opening` [m]."""
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
                moment = TimedConfiguration(self.task.start).after(first.segments)
                then = plan_place(self.task, first.scene, candidate, moment, names)
                if not isinstance(then, Refusal):
                    return PlannedSequence((*first.segments, *then.segments), then.scene, grasp, place)
                self.refusals.append(then)
        return None

    def _result(self, search: Callable[[], PlannedSequence | None]) -> PickPlaceResult:
        task, stopped = self.task, None
        try:
            sequence = search()
        except Stopped as ended:
            sequence, stopped = None, ended.stop
        final = task.scene
        if sequence is not None:
            final = later(sequence.final_scene, TimedConfiguration(task.start).after(sequence.segments).time)
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
        if stopped is not None:
            return ENDED[stopped]
        return max(self.refusals, key=lambda refusal: STAGES.index(refusal.stage)).status

    def _remembered(
        self, key: tuple[Grasp | None, Place], make: Callable[[], Iterator[PlaceCandidate | Refusal]]
    ) -> Iterator[PlaceCandidate]:
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
