"""Benchmark over folders of MoveIt scenes and requests: DIR/<set>/sceneNNNN.yaml, requestNNNN.yaml."""

import re
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trajopt.benchmark.definition import Definition
from trajopt.errors import FileFormatError, NameNotFound
from trajopt.model.robot import Robot
from trajopt.moveit import read_request, read_scene
from trajopt.planning.budget import Budget
from trajopt.planning.plan import NO_BOUNDS, plan
from trajopt.planning.result import Result
from trajopt.planning.seeds import SeedKind
from trajopt.planning.status import UNASKABLE, Status
from trajopt.problem import Problem


@dataclass(frozen=True)
class Instance:
    """One problem of a set.

    Attributes:
        set_name: Name of its folder.
        index: Its number.
        scene: The scene file.
        request: The request file.
    """

    set_name: str
    index: int
    scene: Path
    request: Path


@dataclass(frozen=True)
class Record:
    """What became of one problem.

    Attributes:
        instance: The problem.
        status: How planning ended.
        message: The particulars.
        cpu_seconds: Process time of each stage [s]; "read" is the files'.
        counts: Exact numbers of the work done.
        path_length: Length of the path in joint space [rad], if there is one.
        duration: Duration of the motion [s], if there is one.
        clearance: Smallest clearance of the motion that is proven [m], if there is one.
        won_by: The kind of first guess that the motion came from, if there is one.
        attempts: Number of attempts by kind of seed.
        stopped_by_clock: Whether time ran out: another run may end otherwise.
    """

    instance: Instance
    status: Status
    message: str
    cpu_seconds: dict[str, float]
    counts: dict[str, int]
    path_length: float | None
    duration: float | None
    clearance: float | None
    won_by: SeedKind | None
    attempts: dict[str, int]
    stopped_by_clock: bool

    @property
    def verified(self) -> bool:
        """Whether the judge verified the motion."""
        return self.status is Status.SOLVED

    @property
    def cause(self) -> str:
        """Why there is no plan, without numbers, so that equal causes can be counted."""
        blocked = re.search(r"worst is (.+?) by ", self.message)
        return self.status.name if blocked is None else f"{self.status.name}: {blocked[1]}"

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold."""
        return {
            "set": self.instance.set_name,
            "index": self.instance.index,
            "status": self.status.name,
            "verified": self.verified,
            "message": self.message,
            "cpu_seconds": self.cpu_seconds,
            "counts": self.counts,
            "path_length": self.path_length,
            "duration": self.duration,
            "clearance": self.clearance,
            "won_by": None if self.won_by is None else self.won_by.name,
            "tries": self.attempts,
            "stopped_by_clock": self.stopped_by_clock,
        }


def find_instances(folder: Path, sets: Sequence[str] = (), *, limit: int | None = None) -> list[Instance]:
    """List the problems below a folder.

    Args:
        folder: Holds one folder for each set.
        sets: Names of the sets to take; all when empty.
        limit: How many of each set to take at most, lowest numbers first.

    Raises:
        FileFormatError: If the folder does not exist or holds no problem.
        NameNotFound: If a set is not there.
    """
    if not folder.is_dir():
        raise FileFormatError(str(folder), "is no folder")
    present = sorted(path.name for path in folder.iterdir() if any(path.glob("scene*.yaml")))
    for name in sets:
        if name not in present:
            raise NameNotFound("set", name, present)
    found: list[Instance] = []
    for name in sets or present:
        scenes = sorted((folder / name).glob("scene*.yaml"))
        for scene in scenes[:limit]:
            number = re.sub(r"\D", "", scene.stem)
            request = scene.with_name(f"request{number}.yaml")
            if not request.is_file():
                raise FileFormatError(str(scene), f"has no {request.name} beside it")
            found.append(Instance(name, int(number), scene, request))
    if not found:
        raise FileFormatError(str(folder), "holds no <set>/sceneNNNN.yaml")
    return found


def file_definitions(folder: Path, robot: Robot, *, limit: int | None = None) -> tuple[Definition, ...]:
    """Return the MoveIt problems of a folder, named by set and number; files are read when their turn comes.

    Args:
        folder: Laid out as <set>/sceneNNNN.yaml, requestNNNN.yaml.
        robot: The robot they are for.
        limit: How many of each set at most.

    Raises:
        FileFormatError: If the folder holds no problem.
    """

    def maker(scene: Path, request: Path) -> Callable[[], Problem]:
        return lambda: read_request(request, read_scene(scene, robot)).problem()

    return tuple(
        Definition(f"{item.set_name}/{item.index}", maker(item.scene, item.request))
        for item in find_instances(folder, limit=limit)
    )


def run_instance(robot: Robot, instance: Instance, budget: Budget = NO_BOUNDS) -> Record:
    """Read and plan one problem within a budget."""
    begin = time.process_time()
    problem = read_request(instance.request, read_scene(instance.scene, robot)).problem()
    reading = time.process_time() - begin
    result = plan(problem, budget=budget)
    planning = dict(result.cpu_seconds)
    return Record(
        instance,
        result.status,
        result.message,
        {"read": reading, **planning, "total": sum(planning.values())},
        dict(result.counts),
        None if result.path is None else result.path.length,
        None if result.trajectory is None else result.trajectory.duration,
        _clearance(result),
        None if result.won is None else result.won.kind,
        dict(Counter(item.kind.name for item in result.attempts)),
        result.stopped_by_clock,
    )


def _clearance(result: Result) -> float | None:
    clearance = None if result.certificate is None else result.certificate.clearance
    return clearance if clearance is not None and np.isfinite(clearance) else None


def run(
    robot: Robot,
    instances: Sequence[Instance],
    *,
    budget: Budget = NO_BOUNDS,
    progress: Callable[[int, Record], None] | None = None,
) -> Iterator[Record]:
    """Plan problems one after the other.

    Args:
        robot: The robot they are for.
        instances: The problems.
        budget: For each of them.
        progress: Called with the count and the record after each.
    """
    for count, instance in enumerate(instances, 1):
        record = run_instance(robot, instance, budget)
        if progress is not None:
            progress(count, record)
        yield record


def summary(records: Sequence[Record]) -> dict[str, object]:
    """Sum up: success over all problems that can be asked, CPU time, counts, and why others failed.

    Of CPU time, medians and ninetieth percentiles, in all and of each stage ("stages").
    """
    asked = [record for record in records if record.status not in UNASKABLE]
    solved = [record for record in asked if record.verified]

    def middle(values: Sequence[float | None], share: float) -> float | None:
        known = [value for value in values if value is not None]
        return float(np.percentile(known, share)) if known else None

    totals = [record.cpu_seconds["total"] for record in asked]
    stages = dict.fromkeys(stage for record in asked for stage in record.cpu_seconds)
    first = [record for record in solved if record.counts.get("attempts") == 1]
    return {
        "problems": len(records),
        "left_out": len(records) - len(asked),
        "verified": len(solved),
        "success": len(solved) / len(asked) if asked else None,
        "first_try": len(first) / len(asked) if asked else None,
        "cpu_seconds_median": middle(totals, 50),
        "cpu_seconds_p90": middle(totals, 90),
        "stages": {
            stage: [
                middle([record.cpu_seconds.get(stage, 0.0) for record in asked], share) for share in (50, 90)
            ]
            for stage in stages
        },
        "distance_calls_median": middle([float(r.counts.get("distance_calls", 0)) for r in asked], 50),
        "path_length_median": middle([record.path_length for record in solved], 50),
        "duration_median": middle([record.duration for record in solved], 50),
        "clearance_smallest": min((r.clearance for r in solved if r.clearance is not None), default=None),
        "won_by": dict(Counter(r.won_by.name for r in records if r.won_by is not None).most_common()),
        "stopped_by_clock": sum(record.stopped_by_clock for record in records),
        "statuses": dict(Counter(record.status.name for record in records)),
        "causes": dict(Counter(r.cause for r in records if not r.verified).most_common()),
    }


def by_set(records: Sequence[Record]) -> dict[str, dict[str, object]]:
    """Return the summary of each set, in the order met."""
    names = list(dict.fromkeys(record.instance.set_name for record in records))
    return {
        name: summary([record for record in records if record.instance.set_name == name]) for name in names
    }
