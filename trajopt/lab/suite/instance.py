"""Instances of problems with their expected outcomes, drawn by seeds or read from folders."""

import re
import zlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from inspect import signature
from pathlib import Path

import numpy as np

from trajopt.files.moveit import read_motions, read_request, read_scene
from trajopt.lab.suite.outcome import RunOutcome
from trajopt.planning.result import Status
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.values.arrays import one_of, sequence
from trajopt.values.errors import FileFormatError, NameNotFound, ProblemError, ProblemNotFound, shown
from trajopt.values.errors.arguments import checked

GROUP = "trajopt.problems"
"""The entry-point group that names problems, so any package can add some."""

STANDARD = (
    "past_pillar_panda",
    "cup_past_pillar",
    "bookshelf_panda",
    "level_tray_ur5",
    "narrow_mouth_xarm7",
    "planar_fold",
)
"""Default installed problems: few, short, of all arms."""

_EXPECTED = "expected_status"


@checked
def expected_status(status: Status) -> Callable[[Callable[..., Problem]], Callable[..., Problem]]:
    """Mark a function that makes a problem without a solution; others are expected to be solved."""
    if status is Status.SOLVED:
        raise ProblemError("expected_status: SOLVED is expected of every problem without it")

    def mark(make: Callable[..., Problem]) -> Callable[..., Problem]:
        setattr(make, _EXPECTED, status)
        return make

    return mark


@dataclass(frozen=True)
class Instance:
    """A problem, made on demand.

    Attributes:
        draw: 0, or the number of a random instance of an installed problem.
        files: Its scene, request and motions, if it is read from files.
    """

    name: str
    make: Callable[[], Problem]
    expected: Status = Status.SOLVED
    draw: int = 0
    files: tuple[Path, ...] = ()


@dataclass(frozen=True)
class Definition:
    """A function that makes a problem, known by name."""

    name: str
    make: Callable[..., Problem]

    @property
    def expected(self) -> Status:
        """How planning is expected to end."""
        status = getattr(self.make, _EXPECTED, Status.SOLVED)
        assert isinstance(status, Status)
        return status

    @property
    def randomised(self) -> bool:
        """Whether there are random instances."""
        return "rng" in signature(self.make).parameters

    @checked
    def instance(self, draw: int = 0) -> Instance:
        """Return the fixed instance (0) or a random one, if there are any, the same on every machine."""
        if draw == 0:
            return Instance(self.name, self.make, self.expected)
        if not self.randomised:
            raise ProblemError(f"problem {shown(self.name)} has no random instances")

        def drawn() -> Problem:
            return self.make(rng=np.random.default_rng((zlib.crc32(self.name.encode()), draw)))

        return Instance(self.name, drawn, self.expected, draw)


def definitions() -> tuple[Definition, ...]:
    """Return the installed problems, by name."""
    from importlib.metadata import entry_points

    installed = {entry.name: entry for entry in entry_points(group=GROUP)}
    return tuple(Definition(name, installed[name].load()) for name in sorted(installed))


@checked
def installed_definitions(names: Sequence[str] = ()) -> tuple[Definition, ...]:
    """Return installed problems by name, in this order; all if none is named."""
    known = {item.name: item for item in definitions()}
    for name in names:
        if name not in known:
            raise ProblemNotFound("installed problem", name, known)
    return tuple(known[name] for name in names or known)


@checked
def installed_instances(names: Sequence[str] = ()) -> tuple[Instance, ...]:
    """Return the fixed instances of installed problems by name; all if none is named."""
    return tuple(item.instance() for item in installed_definitions(names))


def instances_of(problems: Mapping[str, Problem] | Sequence[Problem | str]) -> tuple[Instance, ...]:
    """Return problems, or installed problems by name, as instances."""

    def fixed(name: str, problem: Problem) -> Instance:
        return Instance(name, lambda: problem)

    if isinstance(problems, Mapping):
        return tuple(fixed(name, problem) for name, problem in problems.items())
    listed: list[Instance] = []
    for item in sequence("problems", problems):
        if isinstance(item, str):
            listed.extend(installed_instances((item,)))
        else:
            problem = one_of("problem", item, Problem)
            listed.append(fixed(problem.name, problem))
    return tuple(listed)


def find_instances(
    folder: Path, robot: Robot, sets: Sequence[str] = (), *, limit: int | None = None
) -> tuple[Instance, ...]:
    """List the problems below a folder, named by set and number: of some sets, or of all."""
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


def row(outcome: RunOutcome) -> dict[str, object]:
    """Return an outcome as plain JSON data."""
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


def seconds(outcome: RunOutcome) -> dict[str, float]:
    return {"read": outcome.setup_seconds, **outcome.stages, "total": outcome.cpu_seconds}


def cause_of(status: Status, message: str) -> str:
    blocked = re.search(r"worst is (.+?) by ", message)
    return status.name if blocked is None else f"{status.name}: {blocked[1]}"


def not_proven_unaskable(outcome: RunOutcome) -> bool:
    return outcome.askable


def summary(
    outcomes: Sequence[RunOutcome], askable: Callable[[RunOutcome], bool] = not_proven_unaskable
) -> dict[str, object]:
    """Summarise success over all valid problems, CPU time, counts, and causes of failures."""
    asked = [outcome for outcome in outcomes if askable(outcome)]
    solved = [outcome for outcome in asked if outcome.verified]

    def middle(values: Sequence[float | None], share: float) -> float | None:
        known = [value for value in values if value is not None]
        return float(np.percentile(known, share)) if known else None

    totals = [outcome.cpu_seconds for outcome in asked]
    times = [seconds(outcome) for outcome in asked]
    stages = dict.fromkeys(stage for time in times for stage in time)
    first = [outcome for outcome in solved if outcome.attempts == 1]
    causes = Counter(cause_of(each.status, each.message) for each in outcomes if not each.verified)
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
        "causes": dict(causes.most_common()),
    }


def by_set(
    outcomes: Sequence[RunOutcome], askable: Callable[[RunOutcome], bool] = not_proven_unaskable
) -> dict[str, dict[str, object]]:
    names = dict.fromkeys(outcome.set_name for outcome in outcomes)
    return {name: summary([item for item in outcomes if item.set_name == name], askable) for name in names}
