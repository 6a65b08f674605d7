"""Picking: from where the arm is to the object in the hand, off what it stood on."""

from collections.abc import Iterator
from dataclasses import dataclass

from trajopt.arrays import Floats
from trajopt.grasping.grasp import Grasp
from trajopt.grasping.handling import Refusal, Segment, Stage
from trajopt.grasping.neighbours import hand_meets, touched
from trajopt.grasping.straight import follow, up, vector_of
from trajopt.grasping.task import Names, Step, Task, in_turn
from trajopt.infeasibility import reasons
from trajopt.kinematics.goal_candidates import goal_candidates
from trajopt.model.requirements import frame_placement
from trajopt.model.scene import Scene
from trajopt.query import Counts


@dataclass(frozen=True, eq=False)
class PickCandidate:
    """A grasp with configurations that passed the cheap checks; positions are those of all joints.

    Attributes:
        grasp: The grasp.
        before: Where the approach begins, fingers open.
        at: At the object, fingers open.
        lifted: Where the lift ends.
        lifting: The scene with the object in the hand, allowed to touch what it stands on.
        held: The same without that allowance.
    """

    grasp: Grasp
    before: Floats
    at: Floats
    lifted: Floats
    lifting: Scene
    held: Scene


def pick_candidates(task: Task, grasp: Grasp) -> Iterator[PickCandidate | Refusal]:
    """Yield configurations for a grasp, nearest to the start first, or why one does not do."""
    scene, gripper, names = task.scene, task.gripper, Names(grasp=grasp.name)
    if grasp.opening > gripper.widest or grasp.width < gripper.narrowest or grasp.force > gripper.force:
        yield names.refused(
            Stage.OPEN,
            f"asks for {grasp.opening * 1e3:.1f} mm, closing to {grasp.width * 1e3:.1f} mm with "
            f"{grasp.force:g} N; the gripper has {gripper.narrowest * 1e3:.1f} to "
            f"{gripper.widest * 1e3:.1f} mm and {gripper.force:g} N",
        )
        return
    start = task.opened(task.start, grasp.opening)
    reduced = task.reduced(scene, start)
    stands = scene.placement_of(task.name, start)
    meets = hand_meets(reduced, gripper, stands * grasp.placement)
    if meets:
        yield names.refused(Stage.APPROACH, f"{meets} at the object, wherever the arm is")
        return
    wanted = frame_placement(gripper.tool, stands * grasp.placement)
    found = goal_candidates(reduced, (wanted,), rng=task.rng, counts=Counts())
    if not found.free:
        yield names.refused(Stage.REACH, reasons.no_goal_configuration(found))
    supports = touched(scene, task.name, stands)
    for at in found.free[: task.options.configurations]:
        there = reduced.all_positions(at)
        turned = scene.placement_of(gripper.tool, there).rotation
        way = vector_of(grasp.approach, scene, there, turned @ gripper.approach)
        approach = follow(reduced, gripper.tool, at, -way)
        if approach.reason:
            yield names.refused(Stage.APPROACH, approach.reason)
            continue
        closed = task.opened(there, grasp.width)
        held = lifting = task.held(grasp)
        for support in supports:
            lifting = lifting.allow_contact(
                f"{task.name} stood on {support}", task.name, support, first=task.options.contact_time
            )
        carrying = task.reduced(held, closed)
        lift = follow(carrying, gripper.tool, at, vector_of(grasp.lift, scene, there, up(scene)))
        if lift.reason:
            yield names.refused(Stage.LIFT, lift.reason)
            continue
        before, lifted = reduced.all_positions(approach.end), carrying.all_positions(lift.end)
        yield PickCandidate(grasp, before, there, lifted, lifting, held)


def plan_pick(task: Task, candidate: PickCandidate) -> tuple[Segment, ...] | Refusal:
    """Plan the motions of a candidate, or say which of them cannot be."""
    names, grasp, scene = Names(grasp=candidate.grasp.name), candidate.grasp, task.scene
    steps: tuple[Step, ...] = (
        lambda at: task.fingers(Stage.OPEN, scene, at, grasp.opening, names),
        lambda at: task.move(Stage.REACH, scene, at, candidate.before, names),
        lambda at: task.straight(Stage.APPROACH, scene, at, candidate.at, names),
        lambda at: task.fingers(Stage.CLOSE, scene, at, grasp.width, names, rest=task.options.grip_time),
        lambda at: task.straight(Stage.LIFT, candidate.lifting, at, candidate.lifted, names),
    )
    return in_turn(steps, task.start)
