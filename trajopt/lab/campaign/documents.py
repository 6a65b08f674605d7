"""Shared values of problems, as documents by content hash: robots, scenes, base problems.

A worker receives documents, never live objects, and constructs each robot and scene once.
"""

import json
from base64 import b64decode, b64encode
from collections.abc import Mapping
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from trajopt.files.bundle.bundle import named_members
from trajopt.files.bundle.codec import ArrayOf, BundleReader, BundleWriter, FileOf
from trajopt.files.bundle.containers import LARGEST, Archive, Members, array_bytes, write_archive
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import one_of
from trajopt.values.cached import LruCache
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError

DOCUMENT = "document.json"
"""The member of a document's file with the value; arrays and meshes are further members."""
SUFFIX, MESHES = ".zip", "meshes/"
KEPT = 16
"""Robots, scenes and problems that a process keeps, some megabytes each: campaigns process scenes in
sequence.
"""
SHARED = (Robot, Scene)
"""Kinds that other documents refer to by key."""
NO_MATTER = frozenset({"visuals", "mesh_notes", "notes", "left_out", "urdf_path"})
"""Fields of a robot that planning does not use; left out of the hash."""

Kind = TypeVar("Kind")
Documents: TypeAlias = Path | Mapping[str, Mapping[str, bytes]]
"""Documents: their folder, or the members of each by its key."""


class Packer:
    """Turns values into documents, each once.

    Attributes:
        members: Of each document by its key: the members of its file.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self.members: dict[str, Mapping[str, bytes]] = {}
        self._known: dict[int, tuple[object, str]] = {}

    def key(self, value: Robot | Scene | Problem) -> str:
        known = self._known.get(id(value))
        if known is not None:
            return known[1]
        writer = self._writer(value)
        document = writer.document(value, type(value).__name__.lower())
        members = {DOCUMENT: _json(document), **named_members(writer)}
        key = _key(document, members)
        self.members.setdefault(key, members)
        self._known[id(value)] = value, key
        return key

    def statement(self, problem: Problem) -> dict[str, object]:
        writer = self._writer(problem)
        document = writer.document(problem, "problem")
        arrays = {name: b64encode(array_bytes(each)).decode() for name, each in writer.arrays.items()}
        return {"document": document, "arrays": arrays}

    def write(self, folder: Path) -> None:
        for key, members in self.members.items():
            write_archive(folder / f"{key}{SUFFIX}", members)

    def _writer(self, whole: object) -> BundleWriter:
        return BundleWriter(
            reference=lambda value, _: (
                {"stored": self.key(value)} if isinstance(value, SHARED) and value is not whole else None
            )
        )


class Library:
    """Makes values of documents, each once as long as it is kept."""

    def __init__(self, documents: Documents, *, meshes: Path | None = None) -> None:
        """Open a library.

        Args:
            documents: Their folder, or the members of each by its key.
            meshes: A folder for unpacked meshes for a viewer; None to leave them packed.
        """
        self._documents, self._meshes = documents, meshes
        self._made: LruCache[str, object] = LruCache(KEPT)

    def robot(self, key: str) -> Robot:
        return self._one(key, Robot)

    def scene(self, key: str) -> Scene:
        return self._one(key, Scene)

    def problem(self, key: str) -> Problem:
        return self._one(key, Problem)

    def stated(self, statement: Mapping[str, Any]) -> Problem:
        arrays = cast("Mapping[str, str]", statement["arrays"])
        reader = self._reader(lambda name: _array(b64decode(arrays[name])), Path)
        return one_of("problem", reader.value(Node(statement["document"], "problem")), Problem)

    def _one(self, key: str, kind: type[Kind]) -> Kind:
        return one_of(key, self._made.get(key, lambda: self._read(key)), kind)

    def _read(self, key: str) -> object:
        known = self._documents
        members = Archive(known / f"{key}{SUFFIX}") if isinstance(known, Path) else Sent(key, known)
        try:
            document: object = json.loads(members.read(DOCUMENT))
        except ValueError as error:
            raise FileFormatError(str(members.path), f"{DOCUMENT} cannot be parsed: {error}") from error
        reader = self._reader(members.array, lambda name: self._file(members, name))
        return reader.value(Node(document, f"{members.path}: {DOCUMENT}"))

    def _reader(self, array_of: ArrayOf, file_of: FileOf) -> BundleReader:
        def stored(node: Node) -> object:
            return self._one(node.only(("stored",))["stored"].text(), object)

        return BundleReader(array_of, file_of, references={"stored": stored})

    def _file(self, members: Members, name: str) -> Path:
        if self._meshes is None or name not in members.names:
            return Path(Path(name).name)
        target = self._meshes / f"{members.path.stem[:12]}_{Path(name).name}"
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(members.read(name))
        return target


class Sent(Members):
    """The members of a document that were sent from elsewhere."""

    def __init__(self, key: str, documents: Mapping[str, Mapping[str, bytes]]) -> None:
        """Select the members of a key."""
        super().__init__(Path(key))
        self._held = documents.get(key, {})

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._held)

    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        if name not in self._held:
            raise self.error(f"has no member {name}")
        return self._held[name]


def sent_from(folder: Path) -> Mapping[str, Mapping[str, bytes]]:
    found = [Archive(path) for path in sorted(folder.glob(f"*{SUFFIX}"))]
    return {
        each.path.stem: {name: each.read(name) for name in each.names if not name.startswith(MESHES)}
        for each in found
    }


def digest(*parts: object) -> str:
    """Return the hash of plain data: 32 hexadecimal digits, the same on every machine."""
    return sha256(_json(parts)).hexdigest()[:32]


def _key(document: object, members: Mapping[str, bytes]) -> str:
    seen = sha256(_json(_essence(document)))
    for name in sorted(_named(_essence(document)) & members.keys()):
        seen.update(members[name])
    return seen.hexdigest()[:32]


def _essence(document: object) -> object:
    if isinstance(document, dict):
        stated = cast("dict[str, object]", document)
        left_out = NO_MATTER if stated.get("kind") == Robot.__name__ else frozenset[str]()
        return {name: each for name, each in stated.items() if name not in left_out}
    return document


def _named(item: object) -> set[str]:
    if isinstance(item, dict):
        stated = cast("dict[str, object]", item)
        here = {name for key in ("array", "file") if isinstance(name := stated.get(key), str)}
        return here.union(*map(_named, stated.values()))
    if isinstance(item, list):
        return set[str]().union(*map(_named, cast("list[object]", item)))
    return set()


def _array(data: bytes) -> NDArray[np.generic]:
    return cast("NDArray[np.generic]", np.load(BytesIO(data), allow_pickle=False))


def _json(document: object) -> bytes:
    return json.dumps(document, allow_nan=False, separators=(",", ":")).encode()
