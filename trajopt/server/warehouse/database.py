"""The SQLite file of a warehouse: tables, locking and validation.

With SQLite's write-ahead log readers see whole transactions only, one process writes at a time, and a
committed transaction is durable.
"""

import os
import sqlite3
import time
from abc import ABC, abstractmethod
from collections.abc import Generator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from threading import RLock
from weakref import WeakSet

from trajopt.values.documents.files import is_file
from trajopt.values.errors import FileFormatError, ModelError, shown


class Forked(ABC):
    """Something closed before its process forks."""

    def __init__(self) -> None:
        self.lock = RLock()
        _FORKS.known.add(self)

    @abstractmethod
    def disconnect(self) -> None:
        """Close open connections; the lock is held."""


class _Forks:
    def __init__(self) -> None:
        self.known, self._held = WeakSet["Forked"](), list["Forked"]()

    def begin(self) -> None:
        held = list(self.known)
        for each in held:
            each.lock.acquire()
            each.disconnect()
        self._held = held

    def end(self) -> None:
        held, self._held = self._held, []
        for each in held:
            each.lock.release()


_FORKS = _Forks()  # of the process as a whole, as forks are
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_FORKS.begin, after_in_parent=_FORKS.end, after_in_child=_FORKS.end)


APPLICATION = 0x74726A77
"""Application id of a warehouse ("trjw") in SQLite's header."""
VERSION = 1
"""Version of the format. Later versions of trajopt read all earlier ones; newer ones are refused."""
PATIENCE = 60.0
"""Longest wait for writes of other processes [s], each of which takes milliseconds."""
_TABLES = """
CREATE TABLE entries (
  id INTEGER PRIMARY KEY, kind TEXT NOT NULL, name TEXT NOT NULL, version INTEGER NOT NULL,
  made TEXT NOT NULL, robot TEXT NOT NULL, scene TEXT NOT NULL, goal TEXT NOT NULL,
  ends TEXT NOT NULL, status TEXT NOT NULL, duration REAL,
  note TEXT NOT NULL, words TEXT NOT NULL, fingerprint TEXT NOT NULL,
  UNIQUE (kind, name, version));
CREATE TABLE contents (digest TEXT PRIMARY KEY, size INTEGER NOT NULL, packed BLOB NOT NULL);
CREATE TABLE members (
  entry INTEGER NOT NULL REFERENCES entries ON DELETE CASCADE, name TEXT NOT NULL,
  digest TEXT NOT NULL REFERENCES contents, PRIMARY KEY (entry, name));
CREATE INDEX members_of ON members (digest);
CREATE TABLE tags (
  entry INTEGER NOT NULL REFERENCES entries ON DELETE CASCADE, tag TEXT NOT NULL, PRIMARY KEY (entry, tag));
CREATE TABLE numbers (
  kind TEXT NOT NULL, name TEXT NOT NULL, last INTEGER NOT NULL, PRIMARY KEY (kind, name));
CREATE TABLE memories (
  number INTEGER PRIMARY KEY AUTOINCREMENT, key TEXT NOT NULL, arrays TEXT NOT NULL, wins INTEGER NOT NULL,
  failures INTEGER NOT NULL, used INTEGER NOT NULL);
"""
"""Entries; members by digest, each stored once; the last version number; memories of experience."""
Tables = dict[str, tuple[str, str]]


class Database(Forked):
    """The file of a warehouse.

    Threads take turns; it is closed before a fork, and reopened in both processes.
    """

    def __init__(self, path: Path, *, create: bool) -> None:
        self.path, self._depth = path, 0
        self._connection: sqlite3.Connection | None = None
        super().__init__()
        if "\0" in str(path):
            raise self.error("is not the name of a file: it has a zero character")
        if not create and not is_file(path):
            raise self.error("there is no such file")
        with self._translated():
            if create:
                path.parent.mkdir(parents=True, exist_ok=True)
            self._opened(create=create)

    def error(self, reason: str) -> FileFormatError:
        return FileFormatError(str(self.path), reason)

    def close(self) -> None:
        with self.lock:
            self.disconnect()

    def __del__(self) -> None:
        self.disconnect()

    def disconnect(self) -> None:
        if self._connection is not None and not self._depth:
            self._connection.close()
            self._connection = None

    @contextmanager
    def reading(self) -> Generator[sqlite3.Connection]:
        with self._transaction("BEGIN") as connection:
            yield connection

    @contextmanager
    def writing(self) -> Generator[sqlite3.Connection]:
        with self._transaction("BEGIN IMMEDIATE") as connection:
            yield connection

    @contextmanager
    def _transaction(self, begin: str) -> Generator[sqlite3.Connection]:
        with self.lock, self._translated():
            connection = self._opened(create=False)
            part = bool(self._depth)
            end, undo = ("RELEASE part", "ROLLBACK TO part") if part else ("COMMIT", "ROLLBACK")
            connection.execute("SAVEPOINT part" if part else begin)
            self._depth += 1
            try:
                yield connection
                connection.execute(end)
            except BaseException:
                with suppress(sqlite3.Error):
                    connection.execute(undo)
                    if part:
                        connection.execute(end)
                raise
            finally:
                self._depth -= 1

    @contextmanager
    def _translated(self) -> Generator[None]:
        try:
            yield
        except UnicodeEncodeError as error:
            raise ModelError(
                f"{shown(error.object)} has a character that UTF-8 cannot encode: write it differently"
            ) from error
        except UnicodeDecodeError as error:
            raise self.error(f"is damaged: a text in it is not UTF-8: {error}") from error
        except (sqlite3.Error, OSError) as error:
            code = getattr(error, "sqlite_errorname", "")
            if code == "SQLITE_NOTADB":
                raise self.error("is not a warehouse") from error
            if code.startswith(("SQLITE_BUSY", "SQLITE_LOCKED")):
                raise self.error(f"another process has been writing for {PATIENCE:g} s") from error
            if code.startswith("SQLITE_CORRUPT"):
                raise self.error(f"is damaged: {error}") from error
            raise self.error(f"cannot be used: {error}") from error

    def _opened(self, *, create: bool) -> sqlite3.Connection:
        if self._connection is not None:
            return self._connection
        mode = "rwc" if create else "rw"
        if create and not self.path.exists():
            # Plans and scenes are the owner's. SQLite gives its log the mode of the file.
            os.close(os.open(self.path, os.O_CREAT | os.O_RDWR, 0o600))
        connection = sqlite3.connect(
            f"{self.path.absolute().as_uri()}?mode={mode}",
            uri=True,
            timeout=PATIENCE,
            isolation_level=None,
            check_same_thread=False,
        )
        try:
            self._prepared(connection, create=create)
        except BaseException:
            connection.close()
            raise
        self._connection = connection
        return connection

    def _prepared(self, connection: sqlite3.Connection, *, create: bool) -> None:
        connection.execute("PRAGMA trusted_schema = OFF")  # a file from a stranger may have views of its own
        connection.execute("PRAGMA foreign_keys = ON")
        connection.execute("PRAGMA synchronous = FULL")
        connection.create_function("folded", 1, _folded, deterministic=True)
        if not self._is_warehouse(connection):
            if not create:
                raise self.error("is empty: it is not a warehouse yet")
            _in_log(connection)
            connection.execute("BEGIN IMMEDIATE")
            try:
                if not self._is_warehouse(connection):  # nor has another process made it meanwhile
                    for statement in _TABLES.split(";\n"):
                        connection.execute(statement)
                    connection.execute(f"PRAGMA application_id = {APPLICATION}")
                    connection.execute(f"PRAGMA user_version = {VERSION}")
                connection.execute("COMMIT")
            except BaseException:
                with suppress(sqlite3.Error):
                    connection.execute("ROLLBACK")
                raise
        _in_log(connection)

    def _is_warehouse(self, connection: sqlite3.Connection) -> bool:
        found = _tables(connection)
        application = connection.execute("PRAGMA application_id").fetchone()[0]
        version = connection.execute("PRAGMA user_version").fetchone()[0]
        if not found and application == 0 and version == 0:
            return False
        if application != APPLICATION:
            raise self.error("is not a warehouse, but a database of something else")
        if version != VERSION:
            raise self.error(
                f"is of format {version}, and this trajopt reads {VERSION}: it was written by a newer one"
            )
        with closing(sqlite3.connect(":memory:")) as wanted:
            wanted.executescript(_TABLES)
            required = _tables(wanted)
        for name, stated in required.items():
            if found.get(name) != stated:
                raise self.error(f"is not a warehouse: its table {shown(name)} is missing or another")
        strange = [name for name, (kind, _) in found.items() if kind in ("trigger", "view")]
        if strange:
            raise self.error(f"has code of its own, which no warehouse has: {shown(strange[0])}")
        return True


def _folded(text: object) -> str:
    return str(text).casefold()


def _tables(connection: sqlite3.Connection) -> Tables:
    rows = connection.execute(
        "SELECT name, type, sql FROM sqlite_master WHERE name NOT LIKE 'sqlite\\_%' ESCAPE '\\'"
    )
    return {name: (kind, sql) for name, kind, sql in rows}


def _in_log(connection: sqlite3.Connection) -> None:
    until = time.monotonic() + PATIENCE
    while True:
        try:
            connection.execute("PRAGMA journal_mode = WAL")
            return
        except sqlite3.OperationalError as error:
            busy = getattr(error, "sqlite_errorname", "").startswith(("SQLITE_BUSY", "SQLITE_LOCKED"))
            if not busy or time.monotonic() > until:
                raise
            time.sleep(0.01)
