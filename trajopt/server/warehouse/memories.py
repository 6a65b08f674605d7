"""Memories of experience in a warehouse's file: what several processes have planned, for all of them."""

import json
import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import cast

import numpy as np

from trajopt.planning.experience import Memory
from trajopt.server.warehouse.database import Database
from trajopt.values.arrays import Floats, floats, readonly
from trajopt.values.errors import TrajoptError

_COUNTED = ("EXPERIENCE", "")
"""Where the version is, among the numbers that were given."""
_ARRAYS = ("start", "goal", "scene", "knots")


class StoredMemories:
    """The memories of a warehouse; see `trajopt.planning.experience.Storage`."""

    def __init__(self, database: Database) -> None:
        """Take the file."""
        self._database = database

    @property
    def version(self) -> int:
        """How often they were changed, by any process."""
        with self._database.reading() as connection:
            return _version(connection)

    def all(self) -> Mapping[int, Memory]:
        """Return all memories by number.

        Raises:
            FileFormatError: If one is damaged.
        """
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
        """Add, change and remove memories in one step; see `trajopt.planning.experience.Storage.change`.

        Raises:
            FileFormatError: If the file cannot be written.
        """
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
    """Return the arrays of a memory.

    Raises:
        KeyError: If one is missing.
        ShapeError: If one is of another shape.
    """
    start = floats("start", cast("list[float]", document["start"]), (None,))
    knots = floats("knots", cast("list[float]", document["knots"]), (None, len(start)))
    scene = np.array(document["scene"], float).reshape(-1, 6)
    goal = np.array(document["goal"], float).reshape(-1)
    if len(knots) < 2:
        raise KeyError("knots")
    found = {"start": start, "goal": goal, "scene": floats("scene", scene, (None, 6)), "knots": knots}
    return {name: readonly(np.array(each)) for name, each in found.items()}
