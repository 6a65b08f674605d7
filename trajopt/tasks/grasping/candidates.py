"""Candidates of a pick or a place: configurations that passed the cheap checks, then their motions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from trajopt.geometry.geometry import gap, supports
from trajopt.planning.status import Status
from trajopt.problem.requirements import Requirement, frame_placement
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import Grasp, Place
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.tasks.grasping.result import Refusal, Segment, Stage
from trajopt.tasks.grasping.straight import track_line, up, vector_of
from trajopt.tasks.grasping.task import CandidateNames, PickPlaceTask, Step, TimedConfiguration, in_turn
from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement


@dataclass(frozen=True, eq=False)
class PlannedStages:
    """Motions that end with the object taken, or put down.

    Attributes:
        scene: The scene after them: the object is exactly where they put it.
    """

    segments: tuple[Segment, ...]
    scene: Scene


@dataclass(frozen=True, eq=False)
class PickCandidate:
    """A grasp with configurations of all joints that passed the cheap checks.

    Attributes:
        before: Start of the approach, fingers open.
        at: At the object, fingers open.
        lifting: The scene with the object in the hand, allowed to touch its support.
    """

    grasp: Grasp
    before: Floats
    at: Floats
    lifted: Floats
    supports: tuple[str, ...]
    held: Scene


def pick_candidates(task: PickPlaceTask, grasp: Grasp) -> Iterator[PickCandidate | Refusal]:
    """Yield configurations for a grasp, nearest to the start first, or the reason why one fails."""
    scene, gripper, names = task.scene, task.gripper, CandidateNames(grasp=grasp.name)
    if grasp.opening > gripper.widest or grasp.width < gripper.narrowest or grasp.force > gripper.force:
        yield names.refusal(
            Stage.OPEN,
            Status.GRIPPER_CANNOT,
            f"needs {grasp.opening * 1e3:.1f} mm, closing to {grasp.width * 1e3:.1f} mm with "
            f"{grasp.force:g} N; the gripper has {gripper.narrowest * 1e3:.1f} to "
            f"{gripper.widest * 1e3:.1f} mm and {gripper.force:g} N",
        )
        return
    start = task.opened(task.start, grasp.opening)
    reduced = task.reduced(scene, start)
    stands = scene.placement_of(task.name, start)
    meets = hand_meets(reduced, gripper, stands * grasp.placement)
    if meets:
        yield names.refusal(
            Stage.APPROACH, Status.GOAL_IN_COLLISION, f"{meets} at the object, wherever the arm is"
        )
        return
    goal = frame_placement(gripper.tool, stands * grasp.placement)
    found = task.configurations(reduced, (goal,), Stage.REACH, names)
    if isinstance(found, Refusal):
        yield found
        return
    stood_on = supports(scene, task.name, stands)
    for at in found:
        there = reduced.all_positions(at)
        turned = scene.placement_of(gripper.tool, there).rotation
        way = vector_of(grasp.approach, scene, there, turned @ gripper.approach)
        approach = track_line(reduced, gripper.tool, at, -way, task.tracker)
        if approach.status is not None:
            yield names.refusal(Stage.APPROACH, approach.status, approach.reason)
            continue
        closed, held = task.opened(there, grasp.width), task.held(grasp)
        carrying = task.reduced(held, closed)
        lift = track_line(
            carrying, gripper.tool, at, vector_of(grasp.lift, scene, there, up(scene)), task.tracker
        )
        if lift.status is not None:
            yield names.refusal(Stage.LIFT, lift.status, lift.reason)
            continue
        before, lifted = reduced.all_positions(approach.end), carrying.all_positions(lift.end)
        yield PickCandidate(grasp, before, there, lifted, stood_on, held)


def plan_pick(task: PickPlaceTask, candidate: PickCandidate) -> PlannedStages | Refusal:
    """Plan the motions of a candidate, or return the reason why one fails."""
    names, grasp, scene = CandidateNames(grasp=candidate.grasp.name), candidate.grasp, task.scene
    start, gripper = TimedConfiguration(task.start), task.gripper
    steps: tuple[Step, ...] = (
        lambda at: task.fingers(Stage.OPEN, scene, at, grasp.opening, names),
        lambda at: task.move(Stage.REACH, scene, at, candidate.before, names),
        lambda at: task.straight(Stage.APPROACH, scene, at, candidate.at, names),
        lambda at: task.fingers(Stage.CLOSE, scene, at, grasp.width, names, rest=task.options.grip_time),
    )
    taken = in_turn(steps, start)
    if isinstance(taken, Refusal):
        return taken
    grasped = start.after(taken)
    held = scene.attach(task.name, gripper.tool, at=grasped.positions, touch_links=gripper.links)
    lifting = lifting_scene(held, task.name, candidate.supports, task.options.contact_time)
    lift = task.straight(Stage.LIFT, lifting, grasped, candidate.lifted, names)
    return lift if isinstance(lift, Refusal) else PlannedStages((*taken, lift), held)


def lifting_scene(held: Scene, name: str, supports: Sequence[str], seconds: float) -> Scene:
    """Return the scene in which an object in the hand may touch its supports at first.

    Args:
        held: The scene with the object in the hand.
        seconds: Duration of the contact since the beginning of the motion [s].
    """
    for support in supports:
        held = held.allow_contact(f"{name} stood on {support}", name, support, first=seconds)
    return held


@dataclass(frozen=True, eq=False)
class PlaceCandidate:
    """A place with configurations of all joints that passed the cheap checks.

    Attributes:
        at: At the place, fingers closed.
        opening: Of the fingers that release [m].
        held: The scene with the object in the hand.
        lowering: The scene in which it may touch its support.
        put: The scene with the object at its place.
    """

    above: Floats
    at: Floats
    away: Floats
    opening: float
    supports: tuple[str, ...]


def place_candidates(
    task: PickPlaceTask, held: Scene, start: Floats, place: Place, *, opening: float, names: CandidateNames
) -> Iterator[PlaceCandidate | Refusal]:
    """Yield configurations for a place, nearest to a start [rad | m] first, or the reason why one fails."""
    gripper = task.gripper
    stands_on = supports(held, task.name, held.placement_of(place.frame, start) * place.placement)
    reduced = task.reduced(lowering_scene(task, held, stands_on), start)
    kept = tuple(item for item in task.constraints if isinstance(item, Requirement))
    found = task.configurations(reduced, (place.requirement(task.name), *kept), Stage.LOWER, names)
    if isinstance(found, Refusal):
        yield found
        return
    for at in found:
        there = reduced.all_positions(at)
        down = vector_of(place.lower, held, there, -up(held))
        lower = track_line(task.reduced(held, start), gripper.tool, at, -down, task.tracker)
        if lower.status is not None:
            yield names.refusal(Stage.LOWER, lower.status, lower.reason)
            continue
        put = held.detach(task.name, at=there)
        opened = task.opened(there, opening)
        leaving = task.reduced(put, opened)
        usual = -(put.placement_of(gripper.tool, opened).rotation @ gripper.approach)
        retreat = track_line(
            leaving, gripper.tool, at, vector_of(place.retreat, put, opened, usual), task.tracker
        )
        if retreat.status is not None:
            yield names.refusal(Stage.RETREAT, retreat.status, retreat.reason)
            continue
        above, away = reduced.all_positions(lower.end), leaving.all_positions(retreat.end)
        yield PlaceCandidate(above, there, away, opening, stands_on)


def lowering_scene(task: PickPlaceTask, held: Scene, supports: tuple[str, ...]) -> Scene:
    for support in supports:
        name = f"{task.name} stands on {support}"
        held = held.allow_contact(name, task.name, support, last=task.options.contact_time)
    return held


def plan_place(
    task: PickPlaceTask,
    held: Scene,
    candidate: PlaceCandidate,
    start: TimedConfiguration,
    names: CandidateNames,
) -> PlannedStages | Refusal:
    """Plan the motions of a candidate from a start, or return the reason why one fails."""
    lowering, rest = lowering_scene(task, held, candidate.supports), task.options.release_time
    carrying: tuple[Step, ...] = (
        lambda at: task.move(Stage.CARRY, held, at, candidate.above, names),
        lambda at: task.straight(Stage.LOWER, lowering, at, candidate.at, names, rest=rest),
    )
    carried = in_turn(carrying, start)
    if isinstance(carried, Refusal):
        return carried
    lowered = start.after(carried)
    put = held.detach(task.name, at=lowered.positions)
    leaving: tuple[Step, ...] = (
        lambda at: task.fingers(Stage.RELEASE, put, at, candidate.opening, names),
        lambda at: task.straight(Stage.RETREAT, put, at, candidate.away, names),
    )
    left = in_turn(leaving, lowered)
    return left if isinstance(left, Refusal) else PlannedStages((*carried, *left), put)


def hand_meets(reduced: ReducedModel, gripper: Gripper, tool: Placement) -> str:
    """Return the link and the object that overlap for a tool placement, "" for none; arm ignored."""
    scene = reduced.scene
    joint, held = reduced.attachment(gripper.tool)
    hand = tool * held.inverse()
    links = [body for body in reduced.bodies if body.owner in gripper.links and body.joint == joint]
    for other in reduced.bodies:
        if other.joint != 0 or other.owner in scene.robot.links:
            continue
        for body in links:
            if scene.may_touch(body.owner, other.owner):
                continue
            if gap(hand * body.placement, body.shape, other.placement, other.shape) < 0.0:
                return f"{body.owner} is inside {other.owner}"
    return ""
