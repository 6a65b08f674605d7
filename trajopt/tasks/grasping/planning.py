"""Picking and placing as one sequence: candidates in order, the cheap checks of all stages first."""

from __future__ import annotations

from collections.abc import Sequence
from threading import Event

import numpy as np

from trajopt.planning.budget import Budget, BudgetTracker, Progress
from trajopt.planning.plan import NO_BOUNDS
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import Constraint
from trajopt.robot.configuration import ConfigurationLike, stated_configuration
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import Grasp, GraspingOptions, Place
from trajopt.tasks.grasping.gripper import Gripper, arm_of, gripper_of
from trajopt.tasks.grasping.result import PickPlaceResult
from trajopt.tasks.grasping.search import Search
from trajopt.tasks.grasping.task import Task
from trajopt.values.arrays import one_of, sequence, several, unless_none
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD

Constraints = Sequence[Requirement | Constraint]
"""What must hold while the object is in the hand."""
LET_GO = 0.02
"""By default, how much wider the fingers open to let go [m]."""
MET = "only what stands is picked and placed: meet it by plan, with a goal whose reference it is"
"""What to do with what moves."""


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
    """Plan to take an object and put it down elsewhere, as one sequence that is verified stage by stage.

    Grasps are tried in the order given, and for each the places in theirs. Inverse kinematics and the
    straight lines of all stages are checked before any motion is planned; then the motions are planned
    in order, each with the judge's verdict, in a scene of its own: the object is an obstacle, then it
    is carried, then it is an obstacle again. Among what moves, each motion begins at its time in the
    sequence, and stays clear while the fingers press or let go.

    Args:
        scene: Robot and objects; the object stands in it.
        name: The object.
        start: Where the robot is.
        grasps: Ways to take hold of it, the best first.
        places: Where it may be put, the best first.
        group: The arm's planning group; may be left out where the SRDF says what the hand is mounted on.
        gripper: The gripper; the one of the robot's SRDF when None.
        constraints: What must hold while the object is in the hand, such as that it stays upright.
        options: Speeds, tolerances, times.
        rng: Draws starts of the search; a fixed seed when None, so that the answer is the same every time.
        budget: Time and work for the whole sequence; its `attempts` are for each motion, 16 when None.
        cancel: Set it from another thread to stop.
        progress: Called at every stage and every step of the solver.
        degrees: Whether angles in `start` are in degrees.

    Returns:
        The sequence with the grasp and place that were chosen, or why there is none.

    Raises:
        ObjectNotFound: If there is no object of that name.
        GripperError: If the robot has no gripper.
        ProblemError: If there is no grasp or no place, the object is in the hand already, it or what it is
            put on moves by itself, or the budget is to improve a motion.
    """
    tracker = _tracker(budget, cancel, progress)
    task = _task(scene, name, start, group, gripper, constraints, options, rng, tracker, degrees=degrees)
    return Search(task, _places(task.scene, places)).take(_graspable(task, grasps))


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
    """Plan to take an object and lift it; see `pick_and_place`.

    `final_scene` of what is returned has the object attached to the hand.
    """
    tracker = _tracker(budget, cancel, progress)
    task = _task(scene, name, start, group, gripper, constraints, options, rng, tracker, degrees=degrees)
    return Search(task, ()).take(_graspable(task, grasps))


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
    """Plan to put down an object that is in the hand; see `pick_and_place`.

    Args:
        scene: Robot and objects; the object is attached to the hand.
        name: The object.
        start: Where the robot is, its fingers at the object.
        places: Where it may be put, the best first.
        opening: To which the fingers let go [m]; 2 cm more than at the start when None, or all they can.
        group: As in `pick_and_place`.
        gripper: As in `pick_and_place`.
        constraints: As in `pick_and_place`.
        options: As in `pick_and_place`.
        rng: As in `pick_and_place`.
        budget: As in `pick_and_place`.
        cancel: As in `pick_and_place`.
        progress: As in `pick_and_place`.
        degrees: As in `pick_and_place`.

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
    return Search(task, _places(task.scene, places)).place(opening)


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
) -> Task:
    """Check the arguments and fill in defaults."""
    robot = one_of("scene", scene, Scene).robot
    scene.object(one_of("name", name, str))
    hand = gripper_of(robot) if gripper is None else one_of("gripper", gripper, Gripper)
    arm = one_of("group", group, str) or arm_of(robot, hand)
    robot.group(arm)
    return Task(
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
    """Check the places: that there are some, and that their frames are known and at rest."""
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


def _graspable(task: Task, grasps: Sequence[Grasp]) -> tuple[Grasp, ...]:
    """Check the grasps: that there are some, that their frames are known, and that the object stands."""
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
