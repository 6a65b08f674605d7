"""Placing: from where the object is in the hand to where it stands, and the hand off it."""

from collections.abc import Iterator
from dataclasses import dataclass

from trajopt.arrays import Floats
from trajopt.grasping.grasp import Place
from trajopt.grasping.handling import Refusal, Segment, Stage
from trajopt.grasping.neighbours import touched
from trajopt.grasping.straight import follow, up, vector_of
from trajopt.grasping.task import Names, Step, Task, in_turn
from trajopt.infeasibility import reasons
from trajopt.kinematics.goal_candidates import goal_candidates
from trajopt.model.requirements import Requirement
from trajopt.model.scene import Scene
from trajopt.query import Counts


@dataclass(frozen=True, eq=False)
class PlaceCandidate:
    """A place with configurations that passed the cheap checks; positions are those of all joints.

    Attributes:
        above: Where the lowering begins.
        at: Where the object stands, fingers closed.
        away: Where the retreat ends.
        opening: Of the fingers that let go [m].
        held: The scene with the object in the hand.
        lowering: The same, allowed to touch what it will stand on.
        put: The scene with the object where it stands.
    """

    above: Floats
    at: Floats
    away: Floats
    opening: float
    held: Scene
    lowering: Scene
    put: Scene


def place_candidates(
    task: Task, held: Scene, start: Floats, place: Place, *, opening: float, names: Names
) -> Iterator[PlaceCandidate | Refusal]:
    """Yield configurations for a place, nearest to a start first, or why one does not do.

    Args:
        task: What is to be done.
        held: The scene with the object in the hand.
        start: Positions of all joints from which it is carried [rad | m].
        place: The place.
        opening: Of the fingers that let go [m].
        names: For refusals.
    """
    gripper, options = task.gripper, task.options
    lowering = held
    for support in touched(held, task.name, held.placement_of(place.frame, start) * place.placement):
        lowering = lowering.allow_contact(
            f"{task.name} stands on {support}", task.name, support, last=options.contact_time
        )
    reduced = task.reduced(lowering, start)
    kept = tuple(item for item in task.constraints if isinstance(item, Requirement))
    wanted = (place.requirement(task.name), *kept)
    found = goal_candidates(reduced, wanted, rng=task.rng, counts=Counts())
    if not found.free:
        yield names.refused(Stage.LOWER, reasons.no_goal_configuration(found))
    for at in found.free[: options.configurations]:
        there = reduced.all_positions(at)
        down = vector_of(place.lower, held, there, -up(held))
        lower = follow(task.reduced(held, start), gripper.tool, at, -down)
        if lower.reason:
            yield names.refused(Stage.LOWER, lower.reason)
            continue
        put = held.detach(task.name, at=there)
        opened = task.opened(there, opening)
        leaving = task.reduced(put, opened)
        usual = -(put.placement_of(gripper.tool, opened).rotation @ gripper.approach)
        retreat = follow(leaving, gripper.tool, at, vector_of(place.retreat, put, opened, usual))
        if retreat.reason:
            yield names.refused(Stage.RETREAT, retreat.reason)
            continue
        above, away = reduced.all_positions(lower.end), leaving.all_positions(retreat.end)
        yield PlaceCandidate(above, there, away, opening, held, lowering, put)


def plan_place(
    task: Task, candidate: PlaceCandidate, start: Floats, names: Names
) -> tuple[Segment, ...] | Refusal:
    """Plan the motions of a candidate from a start, or say which of them cannot be."""
    held, put, rest = candidate.held, candidate.put, task.options.release_time
    steps: tuple[Step, ...] = (
        lambda at: task.move(Stage.CARRY, held, at, candidate.above, names),
        lambda at: task.straight(Stage.LOWER, candidate.lowering, at, candidate.at, names, rest=rest),
        lambda at: task.fingers(Stage.RELEASE, put, at, candidate.opening, names),
        lambda at: task.straight(Stage.RETREAT, put, at, candidate.away, names),
    )
    return in_turn(steps, start)
