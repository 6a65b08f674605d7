"""From a motion plan request to a result: MoveIt's message, read as its files are."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from trajopt.arrays import Floats
from trajopt.commander.moveit_msgs.msg import MotionPlanRequest
from trajopt.commander.settings import Settings
from trajopt.messages import document_of
from trajopt.methods import method_named
from trajopt.model.scene import Scene
from trajopt.moveit.frames import Reading, world_names
from trajopt.moveit.motion_plan_request import request_of
from trajopt.moveit.planning_scene import SceneFile
from trajopt.planning.budget import Budget
from trajopt.planning.plan import plan
from trajopt.planning.result import Result, Status
from trajopt.problem import Problem

SHORTEST = 1e-3
"""Planning time of the first attempt at least [s]."""


def reading_in(scene: Scene, positions: Floats) -> Reading:
    """Return what names and frames in a message mean while the robot stands at positions."""
    return Reading(world_names(scene.robot), positions)


def problem_of(request: MotionPlanRequest, scene: Scene, positions: Floats) -> Problem:
    """Return the problem that a request asks for.

    Args:
        request: The message.
        scene: What is around the robot.
        positions: Where its joints are now, which counts where the start state leaves one out [rad | m].

    Raises:
        FileFormatError: If the request does not say what it must.
        NameNotFound: If it names a joint, link, frame or object that does not exist.
    """
    robot = scene.robot
    now = dict(zip(robot.joint_names, positions.tolist(), strict=True))
    around = SceneFile(Path(), scene, now, world_names(robot), ())
    return replace(
        request_of(document_of(request, "motion plan request"), around).problem(), name=request.group_name
    )


def solved(problem: Problem, settings: Settings) -> Result:
    """Plan as a script has set it: of several attempts within the time, the motion of least duration."""
    begin, results = time.monotonic(), list[Result]()
    for attempt in range(settings.attempts):
        left = settings.planning_time - (time.monotonic() - begin)
        if results and left <= 0.0:
            break
        results.append(
            plan(
                problem,
                method=method_named(settings.planner),
                rng=np.random.default_rng(attempt),
                budget=Budget(seconds=max(left, SHORTEST)),
            )
        )
    return min(results, key=_duration)


def _duration(result: Result) -> float:
    if result.status is not Status.SOLVED or result.trajectory is None:
        return np.inf
    return result.trajectory.duration
