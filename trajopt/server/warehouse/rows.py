"""Rows of a warehouse: finding, writing and reading entries."""

import json
import sqlite3
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, cast

from trajopt.files.bundle.bundle import (
    DESCRIPTION,
    bundle_members,
    result_members,
    saved_of,
    value_members,
    value_of,
)
from trajopt.files.bundle.containers import LARGEST, MOST_MEMBERS, Members, digest, is_plain
from trajopt.planning.result import Plan, Result, SavedResult
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.warehouse.database import Database
from trajopt.server.warehouse.kept import Constraints, Described, Entry, EntryKind, Keepable, StoredState
from trajopt.values.arrays import several
from trajopt.values.errors import EntryNotFound, ModelError, shown

COLUMNS = "id, kind, name, version, made, robot, goal, status, duration, note, fingerprint"
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
    """Conditions on entries; a missing one is ignored."""

    kind: EntryKind | None = None
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
        assert isinstance(self.goal, Mapping)
        try:
            known = {str(joint): float(at) for joint, at in json.loads(ends).items()}
        except (AttributeError, TypeError, ValueError) as error:
            raise sqlite3.DatabaseError(f"the end of a motion is damaged: {error}") from error
        return all(
            joint in known and abs(known[joint] - at) <= self.within for joint, at in self.goal.items()
        )

    def _conditions(self, connection: sqlite3.Connection) -> Iterator[tuple[str, Sequence[object]]]:
        same = {"kind": self.kind and self.kind.name, "name": self.name, "robot": self.robot}
        yield from ((f"{column} = ?", (value,)) for column, value in same.items() if value)
        if isinstance(self.goal, str):
            yield from (("instr(folded(goal), ?)", (word.casefold(),)) for word in self.goal.split())
        if self.scene:
            rows = connection.execute(
                "SELECT DISTINCT scene FROM entries WHERE kind = ? AND name = ?",
                (EntryKind.SCENE.name, self.scene),
            ).fetchall()
            if not rows:
                raise EntryNotFound("scene", self.scene, _names(connection, EntryKind.SCENE))
            scenes = [scene for (scene,) in rows]
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
    """Return a time in UTC as text that sorts by time.

    A time without a zone is local.
    """
    return when.astimezone(UTC).isoformat(timespec="microseconds")


def entry_of(connection: sqlite3.Connection, row: Sequence[object]) -> Entry:
    """Return the entry of a row of `COLUMNS`."""
    number, kind, name, version, made, robot, goal, status, duration, note, mark = row[:11]
    tags = connection.execute("SELECT tag FROM tags WHERE entry = ? ORDER BY tag", (number,))
    try:
        return Entry(
            kind=EntryKind[str(kind)],
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
    connection: sqlite3.Connection, name: str, kind: EntryKind | None, version: int | None
) -> tuple[int, Entry]:
    """Return an entry by name, by default the last version."""
    found = Conditions(kind=kind, name=name).found(connection)
    what = "entry" if kind is None else kind.name.lower()
    if not found:
        raise EntryNotFound(what, name, _names(connection, kind))
    kinds = sorted({entry.kind.name.lower() for _, entry in found})
    if len(kinds) > 1:
        raise ModelError(f"{shown(name)} is the name of a {' and a '.join(kinds)}; give the kind")
    if version is None:
        return max(found, key=lambda each: each[1].version)
    for number, entry in found:
        if entry.version == version:
            return number, entry
    versions = [str(entry.version) for _, entry in found]
    raise EntryNotFound(f"version of {what} {shown(name)}", str(version), versions)


def _names(connection: sqlite3.Connection, kind: EntryKind | None) -> list[str]:
    rows = connection.execute(
        "SELECT DISTINCT name FROM entries WHERE :kind IS NULL OR kind = :kind",
        {"kind": None if kind is None else kind.name},
    )
    return [name for (name,) in rows]


LONGEST_NAME = 200
"""Characters of a name or a tag."""
BUNDLED = (EntryKind.PROBLEM, EntryKind.PLAN, EntryKind.TASK)
"""Kinds stored as the members of a file that `save` writes."""


def members_of(what: Keepable, *, explained: bool) -> dict[str, bytes]:
    """Return the members of a value by name."""
    match what:
        case Result() | Plan() | Problem():
            return bundle_members(what, explained=explained)
        case SavedResult():
            return result_members(what)
        case StoredState():
            return value_members({"robot": what.robot, "positions": what.positions}, "state")
        case Constraints():
            stated = {"robot": what.robot, "requirements": what.requirements, "group": what.group}
            return value_members(stated, "constraints")
        case _:
            return value_members(what, type(what).__name__.lower())


def kept_in(members: Members, kind: EntryKind, meshes: Path | str | None = None) -> Any:
    """Return the value of members: for a problem or a plan the bundle."""
    if kind in BUNDLED:
        return saved_of(members, meshes)
    value: object = value_of(members, meshes)
    wanted = {EntryKind.ROBOT: Robot, EntryKind.SCENE: Scene}.get(kind, dict)
    if not isinstance(value, wanted):
        raise members.error(f"holds no {kind.name.lower()}, but {shown(value)}")
    made = {EntryKind.STATE: StoredState, EntryKind.CONSTRAINTS: Constraints}.get(kind)
    if made is None:
        return cast("Robot | Scene", value)
    try:
        return made(**cast("dict[str, Any]", value))
    except (TypeError, ValueError) as error:
        raise members.error(f"holds no {kind.name.lower()}: {error}") from error


def keep(
    database: Database,
    name: str,
    about: Described,
    members: Mapping[str, bytes],
    *,
    tags: Sequence[str],
    note: str,
    made: str = "",
) -> Entry:
    """Write an entry with its members, in one transaction."""
    _check_word("name", name)
    marked, mark = checked_tags(tags), _fingerprint(members)
    packed = packed_for(database, members)
    with database.writing() as connection:
        named = (about.kind.name, name)
        connection.execute(
            "INSERT INTO numbers VALUES (?, ?, 1) ON CONFLICT DO UPDATE SET last = last + 1", named
        )
        row = connection.execute("SELECT last FROM numbers WHERE kind = ? AND name = ?", named).fetchone()
        version = int(row[0])
        number = connection.execute(
            "INSERT INTO entries VALUES (NULL, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
            (
                *(about.kind.name, name, version, made or moment(datetime.now(UTC)), about.robot),
                *(about.scene, about.goal, json.dumps(dict(about.ends)), about.status, about.duration),
                *(note, f"{name} {about.words}".casefold(), mark),
            ),
        ).lastrowid
        assert number is not None
        keep_members(connection, number, members, packed)
        connection.executemany("INSERT INTO tags VALUES (?, ?)", [(number, each) for each in marked])
        return the_one(connection, name, about.kind, version)[1]


def _fingerprint(members: Mapping[str, bytes]) -> str:
    if DESCRIPTION in members:
        return digest(members[DESCRIPTION])
    return digest("".join(f"{each} {digest(members[each])}\n" for each in sorted(members)).encode())


def _check_word(what: str, word: str) -> None:
    if not word.strip() or len(word) > LONGEST_NAME or not word.isprintable():
        raise ModelError(
            f"{what} must be 1 to {LONGEST_NAME} characters that can be printed, is {shown(word)}"
        )


def checked_tags(tags: Sequence[str]) -> tuple[str, ...]:
    words = several("tags", tags, str)
    for word in words:
        _check_word("tag", word)
    return tuple(sorted(set(words)))


class StoredMembers(Members):
    """The members of one entry, read on demand."""

    def __init__(self, database: Database, entry: int, label: str) -> None:
        super().__init__(Path(f"{database.path}: {label}"))
        self._database = database
        with database.reading() as connection:
            rows = connection.execute(
                "SELECT name, digest, size FROM members JOIN contents USING (digest) WHERE entry = ? "
                "ORDER BY members.rowid",
                (entry,),
            ).fetchmany(MOST_MEMBERS + 1)
        if not all(isinstance(size, int) and size >= 0 for *_, size in rows):
            raise self.error("is damaged: the size of a member is not a number of bytes")
        if len(rows) > MOST_MEMBERS or sum(size for *_, size in rows) > LARGEST:
            raise self.error(f"holds more than {LARGEST >> 20} MB or {MOST_MEMBERS} members")
        strange = [name for name, *_ in rows if not is_plain(str(name))]
        if strange:
            raise self.error(f"has a member of a name that no entry has: {shown(strange[0])}")
        self._digests = {str(name): (str(key), int(size)) for name, key, size in rows}

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._digests)

    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        if name not in self._digests:
            raise self.error(f"has no member {shown(name)}")
        key, size = self._digests[name]
        if size > most:
            raise self.error(f"{name} holds {size} bytes, more than {most}")
        with self._database.reading() as connection:
            row = connection.execute("SELECT packed FROM contents WHERE digest = ?", (key,)).fetchone()
        if row is None:
            raise self.error(f"{name} was removed while it was read")
        try:
            data = zlib.decompressobj().decompress(row[0], size + 1)
        except (zlib.error, TypeError) as error:
            raise self.error(f"{name} is damaged: {error}") from error
        if len(data) != size or digest(data) != key:
            raise self.error(f"{name} is corrupted: its checksum does not match")
        return data

    def all(self) -> dict[str, bytes]:
        return {name: self.read(name) for name in self.names}


def packed_for(database: Database, members: Mapping[str, bytes]) -> dict[str, bytes]:
    found = {digest(data): data for data in members.values()}
    with database.reading() as connection:
        new = [key for key in found if not _is_kept(connection, key)]
    return {key: zlib.compress(found[key]) for key in new}


def keep_members(
    connection: sqlite3.Connection, entry: int, members: Mapping[str, bytes], packed: Mapping[str, bytes]
) -> None:
    for name, data in members.items():
        key = digest(data)
        if not _is_kept(connection, key):
            # What was there when others were packed may have been removed since.
            words = packed.get(key) or zlib.compress(data)
            connection.execute("INSERT INTO contents VALUES (?, ?, ?)", (key, len(data), words))
        connection.execute("INSERT INTO members VALUES (?, ?, ?)", (entry, name, key))


def drop_unused(connection: sqlite3.Connection) -> None:
    connection.execute("DELETE FROM contents WHERE digest NOT IN (SELECT digest FROM members)")


def _is_kept(connection: sqlite3.Connection, key: str) -> bool:
    return connection.execute("SELECT 1 FROM contents WHERE digest = ?", (key,)).fetchone() is not None
