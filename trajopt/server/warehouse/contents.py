"""Contents: members of entries in the database, equal ones kept once."""

import sqlite3
import zlib
from collections.abc import Mapping
from pathlib import Path

from trajopt.files.bundle.archive import MOST_MEMBERS, is_plain
from trajopt.files.bundle.members import LARGEST, Members, digest
from trajopt.server.warehouse.database import Database
from trajopt.values.errors import shown


class StoredMembers(Members):
    """The members of one entry, read one by one."""

    def __init__(self, database: Database, entry: int, label: str) -> None:
        """Look up what there is.

        Args:
            database: The file.
            entry: The number of the entry in it.
            label: The entry in words.

        Raises:
            FileFormatError: If there is more than an entry can have.
        """
        super().__init__(Path(f"{database.path}: {label}"))
        self._database = database
        with database.reading() as connection:
            rows = connection.execute(
                "SELECT name, digest, size FROM members JOIN contents USING (digest) WHERE entry = ? "
                "ORDER BY members.rowid",
                (entry,),
            ).fetchmany(MOST_MEMBERS + 1)
        if len(rows) > MOST_MEMBERS or sum(size for *_, size in rows) > LARGEST:
            raise self.error(f"holds more than {LARGEST >> 20} MB or {MOST_MEMBERS} members")
        strange = [name for name, *_ in rows if not is_plain(str(name))]
        if strange:
            raise self.error(f"has a member of a name that no entry has: {shown(strange[0])}")
        self._digests = {str(name): (str(key), int(size)) for name, key, size in rows}

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the members."""
        return tuple(self._digests)

    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        """Return what a member holds; see `Members.read`."""
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
            raise self.error(f"{name} is damaged: it is not what was kept")
        return data

    def all(self) -> dict[str, bytes]:
        """Return all of them."""
        return {name: self.read(name) for name in self.names}


def packed_for(database: Database, members: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the members that are not there yet as they will be written, by digest.

    Packing takes long where there are meshes: it is done before the others have to wait.
    """
    found = {digest(data): data for data in members.values()}
    with database.reading() as connection:
        new = [key for key in found if not _is_kept(connection, key)]
    return {key: zlib.compress(found[key]) for key in new}


def keep_members(
    connection: sqlite3.Connection, entry: int, members: Mapping[str, bytes], packed: Mapping[str, bytes]
) -> None:
    """Write the members of an entry; what is there already is not written again.

    Args:
        connection: In a transaction that writes.
        entry: The number of the entry.
        members: What they hold, by name.
        packed: What `packed_for` returned.
    """
    for name, data in members.items():
        key = digest(data)
        if not _is_kept(connection, key):
            # What was there when others were packed may have been removed since.
            words = packed.get(key) or zlib.compress(data)
            connection.execute("INSERT INTO contents VALUES (?, ?, ?)", (key, len(data), words))
        connection.execute("INSERT INTO members VALUES (?, ?, ?)", (entry, name, key))


def drop_unused(connection: sqlite3.Connection) -> None:
    """Remove contents that no entry has any more."""
    connection.execute("DELETE FROM contents WHERE digest NOT IN (SELECT digest FROM members)")


def _is_kept(connection: sqlite3.Connection, key: str) -> bool:
    return connection.execute("SELECT 1 FROM contents WHERE digest = ?", (key,)).fetchone() is not None
