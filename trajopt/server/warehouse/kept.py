"""What a warehouse keeps: kinds, entries, and the values that have no class elsewhere."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum

from trajopt.problem.requirements import Requirement
from trajopt.values.arrays import Value, mapping, name_of, number, one_of, several
from trajopt.values.errors import shown
from trajopt.values.errors.arguments import checked


class Kind(Enum):
    """Kinds of what a warehouse keeps; each value says what it is."""

    ROBOT = "a robot"
    SCENE = "a robot among objects"
    PROBLEM = "a problem that nobody planned yet"
    PLAN = "what planning answered: a plan, or a failure"
    STATE = "positions of a robot's joints"
    CONSTRAINTS = "requirements that motions keep to"


@checked
@dataclass(frozen=True, eq=False)
class State(Value):
    """Positions of a robot's joints that are worth a name: what MoveIt calls a named state.

    `Problem` takes `positions` as its start or its goal.

    Attributes:
        robot: The robot's name.
        positions: Positions by joint [rad | m].
    """

    robot: str
    positions: Mapping[str, float]

    def __post_init__(self) -> None:
        """Check names and numbers.

        Raises:
            ProblemError: If they are none.
            ModelError: If a name has a lone surrogate.
            ShapeError: If a position is no number, or not finite.
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
    """Requirements that are worth a name, for the constraints or the goal of problems: as MoveIt has them.

    Attributes:
        robot: The robot's name.
        requirements: What must hold.
        group: The group that they are for; empty for any.
    """

    robot: str
    requirements: tuple[Requirement, ...]
    group: str = ""

    def __post_init__(self) -> None:
        """Check the kinds.

        Raises:
            ProblemError: If one is no requirement.
        """
        object.__setattr__(self, "requirements", several("requirements", self.requirements, Requirement))


@dataclass(frozen=True, eq=False, kw_only=True)
class Entry(Value):
    """What a warehouse says of something that it keeps; `Warehouse.load` returns the thing itself.

    Attributes:
        kind: What it is.
        name: Its name.
        version: 1 for what was kept first under that name, then 2, ...; numbers are not used again.
        made: When it was kept (UTC, as ISO 8601 has it).
        robot: Name of the robot.
        goal: The goal in words; empty where there is none.
        status: How planning ended ("SOLVED"); empty where nothing was planned.
        duration: Of the motion [s]; None where there is none.
        note: What the user has to say of it.
        tags: Words that it was marked with, sorted.
        fingerprint: The same for the same content, in hexadecimal digits.
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
        """Say in a line what it is."""
        parts = [self.kind.name.lower(), shown(self.name), f"version {self.version}", f"robot {self.robot}"]
        if self.status:
            took = "" if self.duration is None else f", {self.duration:.3f} s"
            parts.append(f"{self.status}{took}")
        return ", ".join([*parts, f"kept {self.made}", *([f"tags {' '.join(self.tags)}"] * bool(self.tags))])


def oldest_first(entries: Iterable[Entry]) -> list[Entry]:
    """Sort entries by date, and those of one kind and name by version, whatever a clock did between them."""
    versions: dict[tuple[Kind, str], list[Entry]] = {}
    for each in sorted(entries, key=lambda each: each.version):
        versions.setdefault((each.kind, each.name), []).append(each)
    by_date = sorted((each for of_one in versions.values() for each in of_one), key=lambda each: each.made)
    in_turn = {key: iter(of_one) for key, of_one in versions.items()}
    return [next(in_turn[each.kind, each.name]) for each in by_date]
