"""Common part of the workers: read the problems, plan each, write one line of JSON a problem.

It needs numpy only, so that it runs in every planner's own environment. A worker calls `work` with
its planner; the driver starts it as

    python <name>_worker.py PROBLEMS.json RESULTS.jsonl FIRST [VARIANT]

where FIRST is the number of problems that are done already.
"""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

import numpy as np


@dataclass(frozen=True)
class Motion:
    """A timed motion: cubic between its points, or quintic where it has accelerations.

    Attributes:
        times: Shape (k,) [s].
        positions: Shape (k, n) [rad].
        velocities: Shape (k, n) [rad/s].
        accelerations: Shape (k, n) [rad/s^2], or None.
    """

    times: list[float]
    positions: list[list[float]]
    velocities: list[list[float]]
    accelerations: list[list[float]] | None = None


@dataclass(frozen=True)
class Planned:
    """What a planner made of one problem.

    Attributes:
        claimed: Whether it says that it has a solution.
        path: Points of the path, straight between them, shape (k, n) [rad].
        motion: The timed motion.
        path_cpu: Process time to the path [s].
        timing_cpu: Process time from the path to the timed motion [s].
        message: What it says beside.
    """

    claimed: bool
    path: list[list[float]] | None = None
    motion: Motion | None = None
    path_cpu: float = 0.0
    timing_cpu: float = 0.0
    message: str = ""


class Planner(Protocol):
    """A planner of one robot."""

    def prepare(self, problem: dict[str, Any]) -> Any:
        """Set the scene; this is timed on its own."""
        ...

    def plan(self, scene: Any, problem: dict[str, Any]) -> Planned:
        """Plan one problem in its scene."""
        ...


def cpu(function: Callable[..., Any], *arguments: Any) -> tuple[Any, float]:
    """Call a function; return its value and the process time it took [s]."""
    begin = time.process_time()
    value = function(*arguments)
    return value, time.process_time() - begin


def work(make: Callable[[dict[str, Any], str], Planner]) -> None:
    """Plan every problem that is not done yet.

    The first one is planned twice, the first time unmeasured: what is loaded or built on first use
    is no part of planning.

    Args:
        make: Makes the planner from the robot's description and the name of a variant.
    """
    source, target, first, *variant = sys.argv[1:]
    document = json.loads(Path(source).read_text())
    robot = {**document["robot"], "time_limit": document["time_limit"]}
    planner, loading = cpu(make, robot, *(variant or [""]))
    problems = document["problems"]
    with Path(target).open("a") as lines:
        planner.plan(planner.prepare(problems[0]), problems[0])
        for problem in problems[int(first) :]:
            scene, setting_up = cpu(planner.prepare, problem)
            planned = asdict(planner.plan(scene, problem))
            line = {"loading_cpu": loading, "setup_cpu": setting_up, **planned}
            lines.write(json.dumps(line) + "\n")
            lines.flush()


def denser(path: np.ndarray, spacing: float) -> np.ndarray:
    """Put points on the segments of a polyline so that none is longer than this [rad]."""
    rows = [path[:1]]
    for begin, end in pairwise(path):
        count = max(int(np.ceil(np.linalg.norm(end - begin) / spacing)), 1)
        rows.append(begin + (end - begin) * np.linspace(0.0, 1.0, count + 1)[1:, None])
    return np.vstack(rows)
