"""Kinds, entries, and named values of a warehouse."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum

from trajopt.problem.requirements import Requirement
from trajopt.values.arrays import Value, mapping, name_of, number, one_of, several
from trajopt.values.errors import shown
from trajopt.values.errors.arguments import checked


class Kind(Enum):
    """Kinds of entries; each value describes its kind."""

    ROBOT = "a robot"
    SCENE = "a robot among objects"
    PROBLEM = "a problem that nobody planned yet"
    PLAN = "what planning answered: a plan, or a failure"
    STATE = "positions of a robot's joints"
    CONSTRAINTS = "requirements that motions keep to"


@checked
@dataclass(frozen=True, eq=False)
class State(Value):
    """Named positions of a robot's joints, like a named state of MoveIt.

    `Problem` accepts `positions` as its start or goal.

    Attributes:
        robot: The robot's name.
        positions: Positions by joint [rad | m].
    """

    robot: str
    positions: Mapping[str, float]

    def __post_init__(self) -> None:
        """Check names and numbers.

        Raises:
            ProblemError: If they are missing.
            ModelError: If a name has a lone surrogate.
            ShapeError: If a position is not a finite number.
        """
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
    """Named requirements, for the constraints or the goal of problems, as in MoveIt.

    Attributes:
        robot: The robot's name.
        requirements: The requirements.
        group: Their group; empty for any.
    """

    robot: str
    requirements: tuple[Requirement, ...]
    group: str = ""

    def __post_init__(self) -> None:
        """Check the kinds.

        Raises:
            ProblemError: If one is not a requirement.
        """
        object.__setattr__(self, "requirements", several("requirements", self.requirements, Requirement))


@dataclass(frozen=True, eq=False, kw_only=True)
class Entry(Value):
    """Description of a stored value; `Warehouse.load` returns the value.

    Attributes:
        kind: Its kind.
        name: Its name.
        version: 1 for the first value of that name, then 2, ...; numbers are not reused.
        made: Time of storage (UTC, ISO 8601).
        robot: Name of the robot.
        goal: The goal in words; empty without one.
        status: Status of planning ("SOLVED"); empty if not planned.
        duration: Of the motion [s]; None without one.
        note: The user's note.
        tags: Its tags, sorted.
        fingerprint: Equal for equal content, in hexadecimal digits.
    """

    kind: Kind
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
        """Return plain data that JSON can hold."""
        return {
            "kind": self.kind.name.lower(),
            "name": self.name,
            "version": self.version,
            "made": self.made,
            "robot": self.robot,
            "goal": self.goal,
            "status": self.status,
            "duration": self.duration,
            "note": self.note,
            "tags": list(self.tags),
            "fingerprint": self.fingerprint,
        }

    def __str__(self) -> str:
        """Return a line that describes it."""
        parts = [self.kind.name.lower(), shown(self.name), f"version {self.version}", f"robot {self.robot}"]
        if self.status:
            took = "" if self.duration is None else f", {self.duration:.3f} s"
            parts.append(f"{self.status}{took}")
        return ", ".join([*parts, f"kept {self.made}", *([f"tags {' '.join(self.tags)}"] * bool(self.tags))])


def oldest_first(entries: Iterable[Entry]) -> list[Entry]:
    """Sort entries by date, and those of one kind and name by version, also if the clock was set back."""
    versions: dict[tuple[Kind, str], list[Entry]] = {}
    for each in sorted(entries, key=lambda each: each.version):
        versions.setdefault((each.kind, each.name), []).append(each)
    by_date = sorted((each for of_one in versions.values() for each in of_one), key=lambda each: each.made)
    in_turn = {key: iter(of_one) for key, of_one in versions.items()}
    return [next(in_turn[each.kind, each.name]) for each in by_date]
