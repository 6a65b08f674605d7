"""Which entries are meant: by kind, robot, goal, scene, date, tag and words."""

import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime

from trajopt.server.warehouse.kept import Entry, Kind
from trajopt.values.errors import EntryNotFound, ModelError, shown

COLUMNS = "id, kind, name, version, made, robot, goal, status, duration, note, fingerprint"
"""Columns of an `Entry`."""
_TAGGED = "EXISTS (SELECT 1 FROM tags WHERE entry = id AND tag = ?)"
_SAYS = (
    "(instr(words, ?) OR instr(folded(note), ?) OR EXISTS "
    "(SELECT 1 FROM tags WHERE entry = id AND instr(folded(tag), ?)))"
)
_NEWEST = (
    "version = (SELECT max(version) FROM entries AS other "
    "WHERE other.kind = entries.kind AND other.name = entries.name)"
)


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Conditions on entries; a missing one is ignored.

    Attributes:
        kind: Their kind.
        name: Their name.
        robot: Name of their robot.
        goal: Words of their goal; or joints with the final positions of their motion [rad | m].
        within: Tolerance of these positions [rad | m].
        scene: Name of a stored scene, any version of which they use.
        text: Words that all occur in their description.
        tags: Tags that they all have.
        since: Earliest time of storage.
        until: End of the time of storage.
        solved: Whether planning found a motion.
        newest: Whether only the last version of each name counts.
    """

    kind: Kind | None = None
    name: str = ""
    robot: str = ""
    goal: str | Mapping[str, float] = ""
    within: float = 0.1
    scene: str = ""
    text: str = ""
    tags: Sequence[str] = field(default_factory=tuple[str, ...])
    since: datetime | None = None
    until: datetime | None = None
    solved: bool | None = None
    newest: bool = False

    def found(self, connection: sqlite3.Connection) -> list[tuple[int, Entry]]:
        """Return the numbers and the entries, the last that was kept first.

        Raises:
            EntryNotFound: If no scene of that name is kept.
        """
        conditions = list(self._conditions(connection))
        tests = " AND ".join(["1", *(test for test, _ in conditions)])
        rows = connection.execute(
            f"SELECT {COLUMNS}, ends FROM entries WHERE {tests} ORDER BY made DESC, id DESC",
            [value for _, values in conditions for value in values],
        ).fetchall()
        if isinstance(self.goal, Mapping):
            rows = [row for row in rows if self._ends_there(row[-1])]
        return [(row[0], entry_of(connection, row)) for row in rows]

    def _ends_there(self, ends: str) -> bool:
        """Return whether a motion ends at the positions of the goal.

        Raises:
            sqlite3.DatabaseError: If the column is damaged.
        """
        assert isinstance(self.goal, Mapping)
        try:
            known = {str(joint): float(at) for joint, at in json.loads(ends).items()}
        except (AttributeError, TypeError, ValueError) as error:
            raise sqlite3.DatabaseError(f"the end of a motion is damaged: {error}") from error
        return all(
            joint in known and abs(known[joint] - at) <= self.within for joint, at in self.goal.items()
        )

    def _conditions(self, connection: sqlite3.Connection) -> Iterator[tuple[str, Sequence[object]]]:
        """Yield conditions, each with the values in it."""
        same = {"kind": self.kind and self.kind.name, "name": self.name, "robot": self.robot}
        yield from ((f"{column} = ?", (value,)) for column, value in same.items() if value)
        if isinstance(self.goal, str):
            yield from (("instr(folded(goal), ?)", (word.casefold(),)) for word in self.goal.split())
        if self.scene:
            scenes = _scenes(connection, self.scene)
            yield f"scene IN ({', '.join('?' * len(scenes))})", scenes
        yield from ((_SAYS, (word.casefold(),) * 3) for word in self.text.split())
        yield from ((_TAGGED, (tag,)) for tag in self.tags)
        for test, when in (("made >= ?", self.since), ("made < ?", self.until)):
            if when is not None:
                yield test, (moment(when),)
        if self.solved is not None:
            yield "status = 'SOLVED'" if self.solved else "status NOT IN ('', 'SOLVED')", ()
        if self.newest:
            yield _NEWEST, ()


def moment(when: datetime) -> str:
    """Return a time in UTC as text, whose order is that of times.

    A time without a zone is local.
    """
    return when.astimezone(UTC).isoformat(timespec="microseconds")


def entry_of(connection: sqlite3.Connection, row: Sequence[object]) -> Entry:
    """Return the entry of a row of `COLUMNS`.

    Raises:
        sqlite3.DatabaseError: If a column does not hold a value of its kind.
    """
    number, kind, name, version, made, robot, goal, status, duration, note, mark = row[:11]
    tags = connection.execute("SELECT tag FROM tags WHERE entry = ? ORDER BY tag", (number,))
    try:
        return Entry(
            kind=Kind[str(kind)],
            name=str(name),
            version=int(str(version)),
            made=str(made),
            robot=str(robot),
            goal=str(goal),
            status=str(status),
            duration=None if duration is None else float(str(duration)),
            note=str(note),
            tags=tuple(tag for (tag,) in tags),
            fingerprint=str(mark),
        )
    except (KeyError, ValueError) as error:
        raise sqlite3.DatabaseError(f"entry {number} is damaged: {error}") from error


def the_one(
    connection: sqlite3.Connection, name: str, kind: Kind | None, version: int | None
) -> tuple[int, Entry]:
    """Return an entry by name, by default the last version.

    Raises:
        EntryNotFound: If there is none of that name, kind and version, or the name is ambiguous.
    """
    found = Conditions(kind=kind, name=name).found(connection)
    what = "entry" if kind is None else kind.name.lower()
    if not found:
        raise EntryNotFound(what, name, _names(connection, kind))
    kinds = sorted({entry.kind.name.lower() for _, entry in found})
    if len(kinds) > 1:
        raise ModelError(f"{shown(name)} is the name of a {' and a '.join(kinds)}: say which kind is meant")
    if version is None:
        return max(found, key=lambda each: each[1].version)
    for number, entry in found:
        if entry.version == version:
            return number, entry
    versions = [str(entry.version) for _, entry in found]
    raise EntryNotFound(f"version of {what} {shown(name)}", str(version), versions)


def _scenes(connection: sqlite3.Connection, name: str) -> list[str]:
    """Return the fingerprints of a scene's versions.

    Raises:
        EntryNotFound: If no scene of that name is stored.
    """
    rows = connection.execute(
        "SELECT DISTINCT scene FROM entries WHERE kind = ? AND name = ?", (Kind.SCENE.name, name)
    ).fetchall()
    if not rows:
        raise EntryNotFound("scene", name, _names(connection, Kind.SCENE))
    return [scene for (scene,) in rows]


def _names(connection: sqlite3.Connection, kind: Kind | None) -> list[str]:
    rows = connection.execute(
        "SELECT DISTINCT name FROM entries WHERE ?1 IS NULL OR kind = ?1",
        (None if kind is None else kind.name,),
    )
    return [name for (name,) in rows]
