"""Planning: MoveIt's motion plan request, or a problem in the words of the Python API."""

from dataclasses import replace
from pathlib import Path

from trajopt.io.document import Node
from trajopt.moveit.frames import world_names
from trajopt.moveit.motion_plan_request import request_of
from trajopt.moveit.planning_scene import SceneFile
from trajopt.planning.budget import Budget, Stop
from trajopt.planning.plan import plan
from trajopt.planning.result import Result, Status
from trajopt.problem import Problem
from trajopt.server.operation import Answer
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch


def planned(problem: Problem, watch: Watch, *, seconds: float | None = None) -> Result:
    """Plan, telling whoever listens.

    Args:
        problem: The problem.
        watch: Of the request.
        seconds: Time that is asked for [s]; when None, planning ends when its seeds are attempted.
    """
    result = plan(
        problem,
        budget=Budget(seconds),
        cancel=watch.cancel,
        progress=watch.progress if watch.heard else None,
        on_incumbent=watch.incumbent if watch.heard else None,
    )
    if result.status is Status.CANCELLED and watch.seconds_left <= 0.0:
        return replace(result, status=Status.OUT_OF_TIME, stopped=Stop.CLOCK)
    return result


def plan_request(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Plan what a `moveit_msgs/MotionPlanRequest` asks."""
    around = SceneFile(Path(), state.scene, state.named_positions, world_names(state.scene.robot), ())
    asked = request_of(arguments, around)
    result = planned(asked.problem(), watch, seconds=asked.allowed_planning_time)
    return Answer({**result.as_dict(), "notes": [*asked.notes, *result.remarks]})
