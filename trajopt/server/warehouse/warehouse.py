"""The class `Warehouse`."""

import json
import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any, cast

import numpy as np

from trajopt.files.bundle import Bundle
from trajopt.files.bundle.bundle import saved_of
from trajopt.files.bundle.containers import Archive, write_archive
from trajopt.files.proof import StandingMotion
from trajopt.planning.experience import Experience, Memory
from trajopt.planning.result import SavedResult
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.warehouse.database import Database
from trajopt.server.warehouse.kept import (
    Constraints,
    Entry,
    EntryKind,
    Keepable,
    StoredState,
    described,
    oldest_first,
)
from trajopt.server.warehouse.rows import (
    BUNDLED,
    Conditions,
    StoredMembers,
    checked_tags,
    drop_unused,
    keep,
    kept_in,
    members_of,
    the_one,
)
from trajopt.values.arrays import Floats, floats, readonly, several
from trajopt.values.arrays import path as as_path
from trajopt.values.errors import ModelError, TrajoptError, shown
from trajopt.values.errors.arguments import checked_class


@checked_class
class Warehouse:
    """A file that stores values by name and version.

    A completed call is durable; processes and threads may share a file.
    `with Warehouse("cell.warehouse") as kept:` closes it.

    A missing entry is an EntryNotFound, a damaged or unwritable file a FileFormatError, and an invalid or
    ambiguous name a ModelError.
    """

    def __init__(self, path: Path | str, *, create: bool = True) -> None:
        """Open a file.

        Args:
            path: The file, on a local disk: SQLite's locks do not work across a network.

        Raises:
            FileFormatError: If it cannot be opened, is not a warehouse, or is newer than this trajopt.
        """
        self.path = as_path("path", path)
        self._database = Database(self.path, create=create)

    def __enter__(self) -> "Warehouse":
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def __reduce__(self) -> tuple[Any, ...]:
        return Warehouse, (self.path,)

    def __repr__(self) -> str:
        return f"Warehouse({shown(str(self.path))})"

    def close(self) -> None:
        self._database.close()

    def together(self) -> AbstractContextManager[object]:
        """Make all changes in a block one transaction.

        Other threads and processes wait with their writes until the block ends.
        """
        return self._database.writing()

    def add(
        self,
        name: str,
        what: Keepable,
        *,
        tags: Sequence[str] = (),
        note: str = "",
        explained: bool = True,
    ) -> Entry:
        """Store a value durably; the previous value of that name stays as an earlier version.

        Args:
            what: A result of any kind and status; a plan, problem, scene, robot, state, or constraints.
            explained: Whether to include the explanation of a failure, which takes up to some seconds.
        """
        about, members = described(what), members_of(what, explained=explained)
        return keep(self._database, name, about, members, tags=tags, note=note)

    def add_bundle(
        self, path: Path | str, name: str = "", *, tags: Sequence[str] = (), note: str = ""
    ) -> Entry:
        """Store a bundle's file, by default under the name of its problem or task.

        Raises:
            FileFormatError: If it is not a bundle, or cannot be stored.
        """
        archive = Archive(path)
        saved: Any = saved_of(archive)
        named = str(getattr(saved, "name", "") or saved.problem.name)
        members = {each: archive.read(each) for each in archive.names}
        return keep(self._database, name or named, described(saved), members, tags=tags, note=note)

    def find(
        self,
        *,
        kind: EntryKind | None = None,
        name: str = "",
        robot: str = "",
        goal: str | Mapping[str, float] = "",
        within: float = 0.1,
        scene: str = "",
        text: str = "",
        tags: Sequence[str] = (),
        since: datetime | None = None,
        until: datetime | None = None,
        solved: bool | None = None,
        newest: bool = False,
    ) -> tuple[Entry, ...]:
        """Return entries that meet all conditions, the latest first.

        Args:
            goal: With these words in the goal; or joints and final positions of the motion, goal or
                state [rad | m].
            within: Tolerance of these positions [rad | m].
            scene: In the stored scene of this name, in any of its versions.
            text: With all these words in the description: names, objects, requirements, reasons, notes.
            solved: Whether planning found a motion; unplanned entries match neither value.
        """
        conditions = Conditions(
            kind=kind, name=name, robot=robot, goal=goal, within=within, scene=scene, text=text,
            tags=several("tags", tags, str), since=since, until=until, solved=solved, newest=newest,
        )  # fmt: skip
        with self._database.reading() as connection:
            return tuple(entry for _, entry in conditions.found(connection))

    def entry(self, name: str, *, kind: EntryKind | None = None, version: int | None = None) -> Entry:
        """Return the description of an entry; its kind may be None if the name is unambiguous."""
        with self._database.reading() as connection:
            return the_one(connection, name, kind, version)[1]

    def load(self, entry: Entry, *, meshes: Path | str | None = None) -> Any:
        """Return the value of an entry; for a problem or a plan the bundle, its meshes in a folder."""
        return kept_in(self._members(entry), entry.kind, meshes)

    def robot(self, name: str, *, version: int | None = None) -> Robot:
        """Return a robot; the last version when `version` is None. Raises as `entry` and `load` do."""
        return self.load(self.entry(name, kind=EntryKind.ROBOT, version=version))

    def scene(self, name: str, *, version: int | None = None) -> Scene:
        return self.load(self.entry(name, kind=EntryKind.SCENE, version=version))

    def problem(self, name: str, *, version: int | None = None) -> Problem:
        bundle: Bundle = self.load(self.entry(name, kind=EntryKind.PROBLEM, version=version))
        return bundle.problem

    def plan(self, name: str, *, version: int | None = None) -> Bundle:
        """Return a plan or a failure, as the bundle that was kept of it; see `robot`."""
        return self.load(self.entry(name, kind=EntryKind.PLAN, version=version))

    def task(self, name: str, *, version: int | None = None) -> SavedResult:
        """Return a `SavedResult`; see `robot`.

        Its motions are judged again.
        """
        return self.load(self.entry(name, kind=EntryKind.TASK, version=version))

    def standing(self, name: str, *, version: int | None = None) -> StandingMotion:
        """Return a plan's motion, verified again, for questions whether it is proven in changed scenes.

        Raises:
            EntryNotFound: If there is none.
            ModelError: If the entry has no motion.
            ProblemError: If the judge does not verify it.
        """
        bundle = self.plan(name, version=version)
        return StandingMotion(bundle.problem, bundle.require())

    def state(self, name: str, *, version: int | None = None) -> StoredState:
        """Return positions of joints; see `robot`."""
        return self.load(self.entry(name, kind=EntryKind.STATE, version=version))

    def constraints(self, name: str, *, version: int | None = None) -> Constraints:
        """Return requirements; see `robot`."""
        return self.load(self.entry(name, kind=EntryKind.CONSTRAINTS, version=version))

    def mark(self, entry: Entry, *, tags: Sequence[str] | None = None, note: str | None = None) -> Entry:
        """Change the tags or the note of an entry; None leaves them."""
        words = None if tags is None else checked_tags(tags)
        with self._database.writing() as connection:
            number, _ = the_one(connection, entry.name, entry.kind, entry.version)
            if words is not None:
                connection.execute("DELETE FROM tags WHERE entry = ?", (number,))
                connection.executemany("INSERT INTO tags VALUES (?, ?)", [(number, each) for each in words])
            if note is not None:
                connection.execute("UPDATE entries SET note = ? WHERE id = ?", (note, number))
            return the_one(connection, entry.name, entry.kind, entry.version)[1]

    def remove(
        self, name: str, *, kind: EntryKind | None = None, version: int | None = None
    ) -> tuple[Entry, ...]:
        """Delete entries permanently, all versions by default; return them."""
        with self._database.writing() as connection:
            number, last = the_one(connection, name, kind, version)
            gone = [(number, last)]
            if version is None:
                gone = Conditions(kind=last.kind, name=name).found(connection)
            connection.executemany("DELETE FROM entries WHERE id = ?", [(each,) for each, _ in gone])
            drop_unused(connection)
            return tuple(entry for _, entry in gone)

    def export(self, entry: Entry, path: Path | str) -> None:
        """Write a problem, a plan or a result as a bundle's file, for all commands."""
        if entry.kind not in BUNDLED:
            raise ModelError(
                f"{shown(entry.name)} is {entry.kind.value}, and bundles are of problems and plans: "
                "copy it to another warehouse"
            )
        write_archive(path, self._members(entry).all())

    def copy_to(self, other: "Warehouse", entries: Sequence[Entry] | None = None) -> tuple[Entry, ...]:
        """Copy entries (all if None) with their dates, tags and notes to a warehouse; return the copies.

        Entries with the same name, date and content are not copied again; others of the same name become
        further versions.
        """
        chosen = self.find() if entries is None else several("entries", entries, Entry)
        copied = list[Entry]()
        for each in oldest_first(chosen):
            known = other.find(kind=each.kind, name=each.name)
            if any((one.made, one.fingerprint) == (each.made, each.fingerprint) for one in known):
                continue
            members = self._members(each)
            value = kept_in(members, each.kind)  # nothing that cannot be read is handed on
            copied.append(
                keep(
                    other._database, each.name, described(value), members.all(),
                    tags=each.tags, note=each.note, made=each.made,
                )
            )  # fmt: skip
        return tuple(copied)

    def experience(self, *, most: int = 1000, learning: bool = True) -> Experience:
        """Return the experience stored in this file: `plan(problem, experience=kept.experience())`.

        Args:
            most: Most memories; beyond it the longest without a success is deleted.
        """
        return Experience(StoredMemories(self._database), most, learning)

    def _members(self, entry: Entry) -> StoredMembers:
        with self._database.reading() as connection:
            number, _ = the_one(connection, entry.name, entry.kind, entry.version)
        return StoredMembers(
            self._database, number, f"{entry.kind.name.lower()} {entry.name} version {entry.version}"
        )


_COUNTED = ("EXPERIENCE", "")
"""Key of the memories' version among the version numbers."""
_ARRAYS = ("start", "goal", "scene", "knots")


class StoredMemories:
    """The memories of a warehouse; see `trajopt.planning.experience.Storage`."""

    def __init__(self, database: Database) -> None:
        self._database = database

    @property
    def version(self) -> int:
        with self._database.reading() as connection:
            return _version(connection)

    def all(self) -> Mapping[int, Memory]:
        with self._database.reading() as connection:
            rows = connection.execute("SELECT * FROM memories ORDER BY number").fetchall()
        found = dict[int, Memory]()
        for number, key, arrays, wins, failures, used in rows:
            try:
                parts = _arrays(json.loads(arrays))
                found[int(number)] = Memory(
                    number=int(number), key=str(key), start=parts["start"], goal=parts["goal"],
                    scene=parts["scene"], knots=parts["knots"], wins=int(wins), failures=int(failures),
                    used=int(used),
                )  # fmt: skip
            except (TypeError, ValueError, KeyError, TrajoptError) as error:
                raise self._database.error(f"memory {number} is damaged: {error}") from error
        return found

    def change(
        self, *, new: Memory | None = None, changed: Iterable[Memory] = (), gone: Iterable[int] = ()
    ) -> tuple[int, Memory | None]:
        with self._database.writing() as connection:
            connection.execute(
                "INSERT INTO numbers VALUES (?, ?, 1) ON CONFLICT DO UPDATE SET last = last + 1", _COUNTED
            )
            version = _version(connection)
            connection.executemany(
                "UPDATE memories SET wins = ?, failures = ?, used = ? WHERE number = ?",
                [(each.wins, each.failures, each.used, each.number) for each in changed],
            )
            connection.executemany("DELETE FROM memories WHERE number = ?", [(each,) for each in gone])
            if new is not None:
                arrays = {name: cast("Floats", getattr(new, name)).tolist() for name in _ARRAYS}
                number = connection.execute(
                    "INSERT INTO memories VALUES (NULL, ?, ?, ?, ?, ?)",
                    (new.key, json.dumps(arrays), new.wins, new.failures, version),
                ).lastrowid
                assert number is not None
                new = replace(new, number=number, used=version)
            return version, new


def _version(connection: sqlite3.Connection) -> int:
    row = connection.execute("SELECT last FROM numbers WHERE kind = ? AND name = ?", _COUNTED).fetchone()
    return 0 if row is None else int(row[0])


def _arrays(document: Mapping[str, object]) -> Mapping[str, Floats]:
    start = floats("start", cast("list[float]", document["start"]), (None,))
    knots = floats("knots", cast("list[float]", document["knots"]), (None, len(start)))
    scene = np.array(document["scene"], float).reshape(-1, 6)
    goal = np.array(document["goal"], float).reshape(-1)
    if len(knots) < 2:
        raise KeyError("knots")
    found = {"start": start, "goal": goal, "scene": floats("scene", scene, (None, 6)), "knots": knots}
    return {name: readonly(np.array(each)) for name, each in found.items()}
