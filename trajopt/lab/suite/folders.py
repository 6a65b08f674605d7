"""Benchmark over folders of MoveIt scenes and requests: DIR/<set>/sceneNNNN.yaml, requestNNNN.yaml.

An optional motionsNNNN.yaml has the motions of the scene's objects.
"""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from trajopt.files.moveit import read_motions, read_request, read_scene
from trajopt.lab.suite.instance import Instance
from trajopt.lab.suite.outcome import Outcome
from trajopt.planning.status import Status
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.values.errors import FileFormatError, NameNotFound


def find_instances(
    folder: Path, robot: Robot, sets: Sequence[str] = (), *, limit: int | None = None
) -> tuple[Instance, ...]:
    """List the problems below a folder, named by set and number; files are read on demand.

    Args:
        folder: Contains one folder for each set.
        robot: The robot of the problems.
        sets: Names of the sets; all if empty.
        limit: Largest number of problems of each set, lowest numbers first.

    Raises:
        FileFormatError: If the folder does not exist or has no problem.
        NameNotFound: If a set does not exist.
    """
    if not folder.is_dir():
        raise FileFormatError(str(folder), "is not a folder")
    present = sorted(path.name for path in folder.iterdir() if any(path.glob("scene*.yaml")))
    for name in sets:
        if name not in present:
            raise NameNotFound("set", name, present)
    found: list[Instance] = []
    for name in sets or present:
        for scene in sorted((folder / name).glob("scene*.yaml"))[:limit]:
            found.append(_instance(name, scene, robot))
    if not found:
        raise FileFormatError(str(folder), "holds no <set>/sceneNNNN.yaml")
    return tuple(found)


def _instance(name: str, scene: Path, robot: Robot) -> Instance:
    """Return the problem of a scene in a set, with its request and motions.

    Raises:
        FileFormatError: If it has no request.
    """
    number = re.sub(r"\D", "", scene.stem)
    request, motions = (scene.with_name(f"{kind}{number}.yaml") for kind in ("request", "motions"))
    if not request.is_file():
        raise FileFormatError(str(scene), f"has no {request.name} beside it")
    moving = motions.is_file()

    def made() -> Problem:
        around = read_scene(scene, robot)
        if moving:
            around = replace(around, scene=read_motions(motions, around.scene))
        return read_request(request, around).problem()

    return Instance(f"{name}/{int(number)}", made, files=(scene, request, *((motions,) if moving else ())))


def row(outcome: Outcome) -> dict[str, object]:
    """Return an outcome as plain data that JSON can hold."""
    name, number = outcome.problem.rsplit("/", maxsplit=1)
    return {
        "set": name,
        "index": int(number),
        "status": outcome.status.name,
        "verified": outcome.verified,
        "message": outcome.message,
        "cpu_seconds": seconds(outcome),
        "counts": dict(outcome.counts),
        "path_length": outcome.path_length,
        "duration": outcome.duration,
        "clearance": outcome.clearance,
        "won_by": None if outcome.won_by is None else outcome.won_by.name,
        "tries": dict(outcome.attempts_by_kind),
        "stopped_by_clock": outcome.stopped_by_clock,
    }


def seconds(outcome: Outcome) -> dict[str, float]:
    """Return process time by stage [s]: "read" is the files', "total" all but that."""
    return {"read": outcome.setup_seconds, **outcome.stages, "total": outcome.cpu_seconds}


def cause(outcome: Outcome) -> str:
    """Return the cause of a failure without numbers, so that equal causes can be counted."""
    return cause_of(outcome.status, outcome.message)


def cause_of(status: Status, message: str) -> str:
    """Return the name of a status, and the main obstacle if a message names it."""
    blocked = re.search(r"worst is (.+?) by ", message)
    return status.name if blocked is None else f"{status.name}: {blocked[1]}"


def not_proven_unaskable(outcome: Outcome) -> bool:
    """Return whether a problem counts, as far as planning can decide."""
    return outcome.askable


def summary(
    outcomes: Sequence[Outcome], askable: Callable[[Outcome], bool] = not_proven_unaskable
) -> dict[str, object]:
    """Summarise success over all valid problems, CPU time, counts, and causes of failures.

    CPU time as medians and 90th percentiles, in total and for each stage ("stages").

    Args:
        outcomes: The outcomes.
        askable: Returns whether a problem is valid.
    """
    asked = [outcome for outcome in outcomes if askable(outcome)]
    solved = [outcome for outcome in asked if outcome.verified]

    def middle(values: Sequence[float | None], share: float) -> float | None:
        known = [value for value in values if value is not None]
        return float(np.percentile(known, share)) if known else None

    totals = [outcome.cpu_seconds for outcome in asked]
    times = [seconds(outcome) for outcome in asked]
    stages = dict.fromkeys(stage for time in times for stage in time)
    first = [outcome for outcome in solved if outcome.attempts == 1]
    return {
        "problems": len(outcomes),
        "left_out": len(outcomes) - len(asked),
        "verified": len(solved),
        "success": len(solved) / len(asked) if asked else None,
        "first_try": len(first) / len(asked) if asked else None,
        "cpu_seconds_median": middle(totals, 50),
        "cpu_seconds_p90": middle(totals, 90),
        "stages": {
            stage: [middle([time.get(stage, 0.0) for time in times], share) for share in (50, 90)]
            for stage in stages
        },
        "distance_calls_median": middle([float(item.counts.get("distance_calls", 0)) for item in asked], 50),
        "path_length_median": middle([outcome.path_length for outcome in solved], 50),
        "duration_median": middle([outcome.duration for outcome in solved], 50),
        "clearance_smallest": min(
            (item.clearance for item in solved if item.clearance is not None), default=None
        ),
        "won_by": dict(Counter(item.won_by.name for item in outcomes if item.won_by).most_common()),
        "stopped_by_clock": sum(outcome.stopped_by_clock for outcome in outcomes),
        "statuses": dict(Counter(outcome.status.name for outcome in outcomes)),
        "causes": dict(Counter(cause(outcome) for outcome in outcomes if not outcome.verified).most_common()),
    }


def by_set(
    outcomes: Sequence[Outcome], askable: Callable[[Outcome], bool] = not_proven_unaskable
) -> dict[str, dict[str, object]]:
    """Return the summary of each set, in the order met."""
    names = dict.fromkeys(outcome.set_name for outcome in outcomes)
    return {name: summary([item for item in outcomes if item.set_name == name], askable) for name in names}
