"""Planning settings of a group, and planning functions of values alone, which any process can run."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from threading import Event
from typing import TypeAlias

import numpy as np

from trajopt.optimise.methods import METHODS, Method, method_named
from trajopt.planning.budget import Budget, Progress
from trajopt.planning.judgement import decide
from trajopt.planning.plan import NO_BOUNDS, plan
from trajopt.planning.result import Result, Status
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import (
    POSITION_TOLERANCE,
    ROTATION_TOLERANCE,
    Requirement,
    frame_placement,
    joint_positions,
)
from trajopt.problem.requirements.joints import JOINT_TOLERANCE
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.scene.scene import Scene
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.tasks import grasping
from trajopt.tasks.cartesian import Followed, FollowOptions, follow, follows_curve, polyline
from trajopt.tasks.cartesian.result import StopReason
from trajopt.tasks.grasping import Grasp, GraspingOptions, Gripper, PickPlaceResult, Place
from trajopt.values.arrays import Floats, floats
from trajopt.values.placement import Placement
from trajopt.verify import Judge

PIPELINE = "trajopt"
PLANNERS = tuple(METHODS)
"""Planner ids: the planning methods, the default first."""

PerAxis: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Settings:
    """Settings of a script; the defaults are MoveIt's.

    Attributes:
        position_tolerance: Of a pose, along each of its axes [m]; inf frees an axis.
        orientation_tolerance: Of a pose, about each of its axes [rad].
        acceleration_scaling: Factor in (0, 1], as `velocity_scaling`.
        tool_speed: Largest speed of a link; None for no limit.
        workspace: Smallest and largest corner of a box: x, y, z of each [m].
        replanning: Whether `go` plans again after a change of the scene.
    """

    joint_tolerance: float = JOINT_TOLERANCE
    position_tolerance: PerAxis = (POSITION_TOLERANCE, POSITION_TOLERANCE, POSITION_TOLERANCE)
    orientation_tolerance: PerAxis = (ROTATION_TOLERANCE, ROTATION_TOLERANCE, ROTATION_TOLERANCE)
    planning_time: float = 5.0
    attempts: int = 1
    planner: str = PLANNERS[0]
    velocity_scaling: float = 0.1
    acceleration_scaling: float = 0.1
    tool_speed: ToolSpeed | None = None
    workspace: tuple[float, ...] = (0.0,) * 6
    replanning: bool = False


def per_axis(name: str, value: float | Sequence[float]) -> PerAxis:
    """Return a tolerance for each of three axes, from one number or three; inf frees an axis."""
    given = [value] * 3 if isinstance(value, int | float) else value
    x, y, z = floats(name, given, (3,), infinite=True).tolist()
    if min(x, y, z) < 0.0:
        raise MoveItCommanderException(f"{name} is negative: {[x, y, z]}")
    return x, y, z


def held_pose(link: str, pose: Placement) -> Requirement:
    """Return the requirement of inverse kinematics that a link is at a pose."""
    return frame_placement(
        link, pose, position_tolerance=INVERSE_TOLERANCE, rotation_tolerance=INVERSE_TOLERANCE
    )


def one_or_three(tolerance: PerAxis) -> float | list[float]:
    """Return a tolerance in MoveIt's form: one number if all axes have the same."""
    return tolerance[0] if len(set(tolerance)) == 1 else list(tolerance)


def scaling(name: str, value: float) -> float:
    """Return a factor on limits, in (0, 1]."""
    if not 0.0 < value <= 1.0:
        raise MoveItCommanderException(f"{name} must lie in (0, 1], is {value}")
    return float(value)


INVERSE_TOLERANCE = 1e-5
"""Largest error of a link's pose after inverse kinematics [m | rad]: that of KDL in MoveIt."""
SHORTEST = 1e-3
"""Planning time of the first attempt at least [s]."""
SAME = 1e-6
"""Poses closer than this are equal [m | rad]: scripts often start with the present pose."""


def solved(
    problem: Problem, settings: Settings, *, budget: Budget = NO_BOUNDS, cancel: Event | None = None
) -> Result:
    """Plan with a script's settings: of several attempts within the time, the motion of least duration."""
    seconds = min(settings.planning_time, inf if budget.seconds is None else budget.seconds)
    attempts = attempted(problem, method_named(settings.planner), settings.attempts, seconds, cancel=cancel)
    return min(attempts, key=cost_of)


def attempted(
    problem: Problem,
    method: Method | None,
    most: int,
    seconds: float,
    *,
    cancel: Event | None,
    progress: Progress | None = None,
    on_incumbent: Callable[[Result], None] | None = None,
) -> list[Result]:
    """Return the results of several attempts, at least one, within a time [s]."""
    until = time.monotonic() + seconds
    results = list[Result]()
    for attempt in range(most):
        left = until - time.monotonic()
        if results and (left <= 0.0 or (cancel is not None and cancel.is_set())):
            break
        results.append(
            plan(
                problem,
                method=method,
                rng=np.random.default_rng(attempt),
                budget=Budget(seconds=max(left, SHORTEST)),
                cancel=cancel,
                progress=progress,
                on_incumbent=on_incumbent,
            )
        )
    return results


def cost_of(result: Result) -> float:
    """Return the duration of a result's motion [s]; infinite without one."""
    if result.status is not Status.SOLVED or result.trajectory is None:
        return inf
    return result.trajectory.duration


def followed_through(
    scene: Scene,
    poses: Sequence[Placement],
    *,
    link: str,
    group: str,
    start: Floats,
    settings: Settings,
    constraints: Sequence[Requirement] = (),
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
) -> Followed | Result:
    """Follow straight lines from a link's present pose through poses in the world, as far as possible.

    Returns:
        The followed part, or the plan of a rest if all poses are the present one.
    """
    if not poses:
        raise MoveItCommanderException("compute_cartesian_path: give at least one waypoint")
    stops = [scene.placement_of(link, start)]
    for pose in poses:
        if np.abs(pose.homogeneous - stops[-1].homogeneous).max() > SAME:
            stops.append(pose)
    if len(stops) == 1:
        present = dict(zip(scene.robot.joint_names, start.tolist(), strict=True))
        rest = joint_positions({joint: present[joint] for joint in scene.robot.group(group).joints})
        problem = Problem(scene=scene, group=group, start=start, goal=rest, constraints=constraints)
        return plan(problem, budget=budget, cancel=cancel)
    options = FollowOptions(
        velocity_scaling=settings.velocity_scaling,
        acceleration_scaling=settings.acceleration_scaling,
        tool_speed=() if settings.tool_speed is None else (settings.tool_speed,),
    )
    lines, ends = polyline(stops), time.monotonic() + (inf if budget.seconds is None else budget.seconds)

    def until(length: float | None) -> Followed:
        left = ends - time.monotonic()
        return follow(
            scene,
            follows_curve(link, lines, until=length),
            start=start,
            group=group,
            options=options,
            budget=budget if left == inf else replace(budget, seconds=max(left, SHORTEST)),
            cancel=cancel,
        )

    return as_far_as_kept(until(None), constraints, until)


def picked(
    scene: Scene,
    name: str,
    *,
    start: Floats,
    grasps: Sequence[Grasp],
    group: str,
    gripper: Gripper,
    constraints: Sequence[Requirement],
    settings: Settings,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
) -> PickPlaceResult:
    """Plan to pick up an object, the best grasp first; constraints hold once it is in the hand."""
    return grasping.pick(
        scene,
        name,
        start=start,
        grasps=grasps,
        group=group,
        gripper=gripper,
        constraints=constraints,
        options=_options(settings),
        budget=budget,
        cancel=cancel,
    )


def put_down(
    scene: Scene,
    name: str,
    *,
    start: Floats,
    places: Sequence[Place],
    group: str,
    constraints: Sequence[Requirement],
    settings: Settings,
    opening: float | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
) -> PickPlaceResult:
    """Plan to place an object, the best place first; constraints hold while it is in the hand."""
    return grasping.place(
        scene,
        name,
        start=start,
        places=places,
        opening=opening,
        group=group,
        constraints=constraints,
        options=_options(settings),
        budget=budget,
        cancel=cancel,
    )


def fraction_of(followed: Followed | Result) -> float:
    """Return the followed share of a path of lines; a path without length is followed by a rest."""
    return followed.fraction if isinstance(followed, Followed) else float(followed.verified)


def _options(settings: Settings) -> GraspingOptions:
    return GraspingOptions(
        velocity_scaling=settings.velocity_scaling,
        acceleration_scaling=settings.acceleration_scaling,
        method=method_named(settings.planner),
    )


FUNCTIONS: Mapping[str, Callable[..., Result | Followed | PickPlaceResult]] = {
    function.__name__: function for function in (solved, followed_through, picked, put_down)
}


HALVINGS = 6
"""Bisections of the part of a line on which constraints hold: to 1/64."""


def as_far_as_kept(
    followed: Followed, constraints: Sequence[Requirement], until: Callable[[float], Followed]
) -> Followed:
    """Return the longest motion found along a line that satisfies path constraints."""
    if not constraints or not followed.verified:
        return followed
    best, refused = None, _judged(followed, constraints)
    if refused.verified:
        return refused
    kept, broken = 0.0, followed.fraction * followed.required.until
    for _ in range(HALVINGS):
        middle = 0.5 * (kept + broken)
        part = until(middle)
        judged = _judged(part, constraints) if part.complete else part
        if judged.complete:
            best, kept = judged, middle
        else:
            broken, refused = middle, judged
    verdict = refused.certificate
    words = refused.reason if verdict is None else verdict.verdict
    whole = followed.required
    stop = StopReason(
        status=Status.NOT_VERIFIED,
        at=kept,
        pose=whole.curve.pose_before(kept),
        message=f"the path constraints are not kept beyond: {words}",
    )
    if best is None:
        result = replace(refused.result, status=Status.NOT_VERIFIED, message=stop.message)
        return replace(refused, required=whole, fraction=0.0, stop=stop, result=result)
    return replace(best, required=whole, fraction=kept / whole.until, stop=stop)


def _judged(followed: Followed, constraints: Sequence[Requirement]) -> Followed:
    trajectory = followed.trajectory
    assert trajectory is not None
    problem = replace(followed.problem, constraints=(*followed.problem.constraints, *constraints))
    verdict, _ = decide(problem, trajectory, Judge(problem.reduced))
    status = Status.SOLVED if verdict.verified else Status.NOT_VERIFIED
    return replace(followed, result=replace(followed.result, status=status, problem=problem, judged=verdict))
