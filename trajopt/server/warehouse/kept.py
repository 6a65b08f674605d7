"""Kinds, entries, and named values of a warehouse."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from trajopt.files.bundle import Bundle
from trajopt.files.bundle.codec import BundleWriter, digest_as_written
from trajopt.optimise.terms.joint_positions import fixed_positions
from trajopt.planning.result import Plan, Result, SavedResult
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import GoalSet, Requirement
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Value, mapping, name_of, number, one_of, several
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

if TYPE_CHECKING:
    from trajopt.tasks.sequence import MotionSequence


class EntryKind(Enum):
    """Kinds of entries; each value describes its kind."""

    ROBOT = "a robot"
    SCENE = "a robot among objects"
    PROBLEM = "a problem without a plan"
    PLAN = "a result of planning: a plan, or a failure"
    TASK = "a result of a task, of a pick and place, or of following a curve"
    STATE = "positions of a robot's joints"
    CONSTRAINTS = "requirements that motions keep to"


@checked
@dataclass(frozen=True, eq=False)
class StoredState(Value):
    """Named positions of a robot's joints, like a named state of MoveIt.

    `Problem` accepts `positions` as its start or goal.
    """

    robot: str
    positions: Mapping[str, float]

    def __post_init__(self) -> None:
        one_of("robot", self.robot, str)
        positions = mapping("positions", self.positions)
        several("joints of positions", positions, str)
        for name in (self.robot, *positions):
            name_of("name", name)
        stated = {name: number(f"position of {name}", each) for name, each in positions.items()}
        object.__setattr__(self, "positions", stated)


@checked
@dataclass(frozen=True, eq=False)
class Constraints(Value):
    """Named requirements of a group, or of any, as in MoveIt: for constraints or goals."""

    robot: str
    requirements: tuple[Requirement, ...]
    group: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "requirements", several("requirements", self.requirements, Requirement))


@dataclass(frozen=True, eq=False, kw_only=True)
class Entry(Value):
    """Description of a stored value; `Warehouse.load` returns the value.

    Attributes:
        version: 1 for the first value of that name, then 2, ...; numbers are not reused.
        made: Time of storage (UTC, ISO 8601).
        fingerprint: Equal for equal content, in hexadecimal digits.
    """

    kind: EntryKind
    name: str
    version: int
    made: str
    robot: str
    goal: str = ""
    status: str = ""
    duration: float | None = None
    note: str = ""
    tags: tuple[str, ...] = ()
    fingerprint: str = field(default="", repr=False)

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {**vars(self), "kind": self.kind.name.lower(), "tags": list(self.tags)}

    def __str__(self) -> str:
        parts = [self.kind.name.lower(), shown(self.name), f"version {self.version}", f"robot {self.robot}"]
        if self.status:
            took = "" if self.duration is None else f", {self.duration:.3f} s"
            parts.append(f"{self.status}{took}")
        return ", ".join([*parts, f"kept {self.made}", *([f"tags {' '.join(self.tags)}"] * bool(self.tags))])


def oldest_first(entries: Iterable[Entry]) -> list[Entry]:
    versions: dict[tuple[EntryKind, str], list[Entry]] = {}
    for each in sorted(entries, key=lambda each: each.version):
        versions.setdefault((each.kind, each.name), []).append(each)
    by_date = sorted((each for of_one in versions.values() for each in of_one), key=lambda each: each.made)
    in_turn = {key: iter(of_one) for key, of_one in versions.items()}
    return [next(in_turn[each.kind, each.name]) for each in by_date]


Keepable: TypeAlias = Result | Plan | SavedResult | Problem | Scene | Robot | StoredState | Constraints
"""Values that a warehouse stores."""


@dataclass(frozen=True, kw_only=True)
class Described:
    """Description of an entry."""

    kind: EntryKind
    robot: str
    scene: str = ""
    goal: str = ""
    ends: Mapping[str, float] = field(default_factory=dict[str, float])
    status: str = ""
    duration: float | None = None
    words: str = ""


def described(value: Keepable | Bundle) -> Described:
    """Describe something."""
    match value:
        case Robot():
            words = " ".join((value.name, *value.links, *value.joint_names, *value.groups))
            return Described(kind=EntryKind.ROBOT, robot=value.name, words=words)
        case Scene():
            words = " ".join((value.robot.name, *value.objects, *value.tools))
            return Described(
                kind=EntryKind.SCENE, robot=value.robot.name, scene=scene_fingerprint(value), words=words
            )
        case Problem():
            return _of_problem(value)
        case Result() | Plan():
            motion = value.trajectory
            if isinstance(value, Plan):
                return _of_answer(value.problem, motion, "SOLVED", "")
            return _of_answer(
                value.problem, motion if value.verified else None, value.status.name, value.reason
            )
        case SavedResult():
            return _of_saved(value)
        case Bundle():
            return _of_bundle(value)
        case StoredState():
            words = " ".join((value.robot, *value.positions))
            return Described(kind=EntryKind.STATE, robot=value.robot, ends=value.positions, words=words)
        case Constraints():
            words = " ".join((value.robot, value.group, *map(str, value.requirements)))
            return Described(kind=EntryKind.CONSTRAINTS, robot=value.robot, words=words)
    raise ProblemError(
        "a warehouse keeps results of all kinds, plans, problems, scenes, robots, states and constraints, "
        f"not {shown(value)}"
    )


def scene_fingerprint(scene: Scene) -> str:
    return digest_as_written(BundleWriter(), scene)


def _of_problem(problem: Problem) -> Described:
    goal = problem.goal
    fixed = None if isinstance(goal, GoalSet) else fixed_positions(problem.goals, problem.reduced)
    joints = problem.reduced.joint_names
    return Described(
        kind=EntryKind.PROBLEM,
        robot=problem.scene.robot.name,
        scene=scene_fingerprint(problem.scene),
        goal=str(goal) if isinstance(goal, GoalSet) else " and ".join(map(str, problem.goals)),
        ends={} if fixed is None else dict(zip(joints, map(float, fixed), strict=True)),
        words=" ".join((problem.name, str(problem), *problem.scene.objects)),
    )


def _of_bundle(bundle: Bundle) -> Described:
    if not bundle.answer:
        return _of_problem(bundle.problem)
    motion = bundle.trajectory if bundle.answer.get("verified") is True else None
    return _of_answer(bundle.problem, motion, bundle.status, str(bundle.answer.get("message", "")))


def _of_saved(value: SavedResult) -> Described:
    from trajopt.tasks.cartesian import Followed  # slow to import

    if isinstance(value, Followed):
        motion = value.trajectory if value.verified else None
        return replace(
            _of_answer(value.problem, motion, value.status.name, value.reason), kind=EntryKind.TASK
        )
    found = cast("MotionSequence[Any]", value)
    stages = [stage.name for stage in found.stages] if found.verified else []
    return Described(
        kind=EntryKind.TASK,
        robot=found.scene.robot.name,
        scene=scene_fingerprint(found.scene),
        goal=", ".join(stages),
        ends=found.final_state if found.verified else {},
        status=found.status.name,
        duration=found.trajectory.duration if found.verified else None,
        words=" ".join((found.name, found.group, found.reason, *stages, *found.scene.objects)),
    )


def _of_answer(problem: Problem, motion: Trajectory | None, status: str, reason: str) -> Described:
    asked = _of_problem(problem)
    ends = asked.ends
    if motion is not None:
        ends = dict(zip(motion.joint_names, map(float, motion.positions[-1]), strict=True))
    return Described(
        kind=EntryKind.PLAN,
        robot=asked.robot,
        scene=asked.scene,
        goal=asked.goal,
        ends=ends,
        status=status,
        duration=None if motion is None else motion.duration,
        words=f"{asked.words} {reason}",
    )
