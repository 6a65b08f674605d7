"""Pick and place one object: a task that rests after each motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from threading import Event

import numpy as np

from trajopt.planning.budget import Budget, Progress
from trajopt.planning.plan import NO_BOUNDS
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import Constraint
from trajopt.robot.configuration import ConfigurationLike, stated_configuration
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import Grasp, GraspingOptions, Place
from trajopt.tasks.grasping.gripper import Gripper, arm_of
from trajopt.tasks.grasping.result import PickPlaceResult
from trajopt.tasks.grasping.stages import PickObject, PlaceObject, hand_of
from trajopt.tasks.search import held_objects
from trajopt.tasks.task import Task
from trajopt.values.errors.arguments import checked

Constraints = Sequence[Requirement | Constraint]
"""Path constraints while the object is in the hand."""


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
    """Plan to pick up an object and place it elsewhere, verified stage by stage.

    Grasps are tried in order, and for each the places. Inverse kinematics and the straight lines of all
    stages are checked first; then the motions are planned, each judged in its own scene. Among dynamic
    obstacles each motion starts at its time in the sequence, and stays clear while the fingers move.

    Args:
        scene: The object is at rest in it.
        group: Optional if the SRDF defines the parent of the hand.
        gripper: As in the robot's SRDF if None.
        constraints: Path constraints while the object is in the hand.
        rng: Draws starts of the search; a fixed seed if None.
        budget: Time and work for the whole sequence; its `attempts` are for each motion, 16 if None.
        cancel: Set it from another thread to stop.
        degrees: Whether angles in `start` are in degrees.

    Raises:
        ObjectNotFound: Without an object of that name.
        GripperError: If the robot has no gripper.
        ProblemError: If there is no grasp or no place, the object is already in the hand, it or its target
            support moves by itself, or the budget requests improvement.
    """
    job = _job(scene, name, start, group, gripper, options, degrees=degrees)
    stages = [
        PickObject(name, grasps, gripper, constraints, name=f"pick {name}"),
        PlaceObject(name, places, gripper, constraints, name=f"place {name}"),
    ]
    return _planned(scene, group, job, stages, rng, budget, cancel, progress)


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
    job = _job(scene, name, start, group, gripper, options, degrees=degrees)
    stage = PickObject(name, grasps, gripper, constraints, name=f"pick {name}")
    return _planned(scene, group, job, [stage], rng, budget, cancel, progress)


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
    """Plan to place an object in the hand; other arguments are as for `pick_and_place`.

    Args:
        opening: Of the fingers at release [m]; 2 cm more than at the start if None, or the largest possible.

    Raises:
        ProblemError: If the object is not attached.
    """
    job = _job(scene, name, start, group, gripper, options, degrees=degrees)
    stage = PlaceObject(name, places, gripper, constraints, name=f"place {name}", opening=opening)
    return _planned(scene, group, job, [stage], rng, budget, cancel, progress)


def _job(
    scene: Scene,
    name: str,
    start: ConfigurationLike,
    group: str,
    gripper: Gripper | None,
    options: GraspingOptions | None,
    *,
    degrees: bool,
) -> Callable[..., Task]:
    scene.object(name)
    arm = group or arm_of(scene.robot, hand_of(scene, gripper, ""))
    return partial(
        Task,
        scene=scene,
        name=name,
        start=stated_configuration(scene.robot, "start", start, group=arm, degrees=degrees),
        group=arm,
        options=options or GraspingOptions(),
        stops=True,
    )


def _planned(
    scene: Scene,
    group: str,
    job: Callable[..., Task],
    stages: Sequence[PickObject | PlaceObject],
    rng: np.random.Generator | None,
    budget: Budget,
    cancel: Event | None,
    progress: Progress | None,
) -> PickPlaceResult:
    held = held_objects(scene)
    for stage in stages:  # the task itself would add the name of the stage to each message
        held = stage.held_after(scene, group, held)
    task = job(stages=stages)
    name, gripper = task.name, stages[0].gripper
    found = task.planned(rng=rng, budget=budget, cancel=cancel, progress=progress)
    if found.verified:
        return replace(
            found.handling(name), refusals=found.refusals, counts=found.counts, cpu_seconds=found.cpu_seconds
        )
    return PickPlaceResult(
        name=name,
        scene=task.scene,
        final_scene=task.scene,
        start=found.start,
        group=task.group,
        gripper=hand_of(task.scene, gripper, task.group),
        status=found.status,
        grasp=None,
        place=None,
        segments=(),
        refusals=found.refusals,
        failed=found.failed,
        counts=found.counts,
        cpu_seconds=found.cpu_seconds,
        stopped=found.stopped,
    )
