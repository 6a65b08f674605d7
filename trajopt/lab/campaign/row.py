"""One row of the results."""

import os
import socket
import time
from collections import Counter
from collections.abc import Mapping
from enum import Enum
from math import isfinite
from typing import Any

from trajopt.lab.campaign.campaign import CampaignTask, Options
from trajopt.lab.campaign.recipes import Workshop, read
from trajopt.lab.suite.instance import cause_of
from trajopt.planning.result import Result
from trajopt.values.errors import TrajoptError, shown


class Fate(Enum):
    """Statuses of rows whose planning did not end normally; each value describes itself."""

    INVALID = "the problem is malformed, or needs something that its robot or scene does not have"
    FAILED = "trajopt raised an error of its own"
    CRASHED = "its worker ended, each time"
    RAN_OVER = "it took more wall-clock time than any problem may"


def row_of(task: CampaignTask, options: Options, shop: Workshop) -> dict[str, Any]:
    """Make and plan a problem, and return its row; an exception affects this row only."""
    wall, begin = time.perf_counter(), time.process_time()
    try:
        problem = read(task.recipe).problem(shop)
        made = time.process_time()
        result = options.plan(problem, task.seed)
        told = _told(result)
        stages = {"make": made - begin, **result.cpu_seconds, "total": time.process_time() - begin}
    except TrajoptError as error:
        told, stages = fate_columns(Fate.INVALID, f"{type(error).__name__}: {error}"), {}
    except Exception as error:
        told, stages = fate_columns(Fate.FAILED, f"{type(error).__name__}: {shown(str(error))}"), {}
    stages.setdefault("total", time.process_time() - begin)
    spent = {"cpu_seconds": stages, "wall_seconds": time.perf_counter() - wall}
    return {**known(task), **told, **spent, "process": f"{socket.gethostname()}:{os.getpid()}"}


def known(task: CampaignTask) -> dict[str, Any]:
    return {name: value for name, value in vars(task).items() if name != "recipe"}


def fate_columns(fate: Fate, why: str) -> dict[str, Any]:
    first = why.partition(":")[0] if fate in (Fate.INVALID, Fate.FAILED) else ""
    return {
        "status": fate.name,
        "verified": False,
        "cause": f"{fate.name}: {first}" if first else fate.name,
        "message": f"{fate.name}: {fate.value} ({why})",
    }


def lost_row(task: CampaignTask, fate: Fate, why: str, wall: float) -> dict[str, Any]:
    return {**known(task), **fate_columns(fate, why), "wall_seconds": wall}


def _told(result: Result) -> dict[str, Any]:
    certificate, motion, path = result.certificate, result.trajectory, result.path
    clearance = None if certificate is None else certificate.clearance
    told: dict[str, Any] = {
        "robot": result.problem.scene.robot.name,
        "group": result.problem.group,
        "method": result.method,
        "status": result.status.name,
        "verified": result.verified,
        "certainty": result.certainty.name,
        "cause": cause_of(result.status, result.message),
        "message": result.reason,
        "stopped": None if result.stopped is None else result.stopped.name,
        "clearance": clearance if clearance is not None and isfinite(clearance) else None,
        "duration": None if motion is None else motion.duration,
        "path_length": None if path is None else path.length,
        "counts": dict(result.counts),
        "attempts": dict(Counter(item.kind.name for item in result.attempts)),
        "won_by": None if result.won is None else result.won.kind.name,
        "goal_name": result.goal_name,
        "joint_names": list(result.problem.reduced.joint_names),
    }
    return {**told, **_motion(result)} if result.verified else told


def _motion(result: Result) -> Mapping[str, Any]:
    motion = result.trajectory
    if motion is None:
        return {}
    arrays = {name: getattr(motion, name) for name in ("positions", "velocities", "accelerations")}
    flat = {name: None if each is None else each.ravel() for name, each in arrays.items()}
    return {"times": motion.times, **flat}
