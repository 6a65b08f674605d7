"""Containers of bundles: documents, arrays and meshes as members of a zip, or in one JSON message.

In messages for another process, values known to both sides are sent by name, repeated ones once. Verdicts are
never sent.
"""

import io
import re
import zipfile
import zlib
from abc import ABC, abstractmethod
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from hashlib import sha256
from math import inf
from pathlib import Path
from tokenize import TokenError
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from trajopt.files.bundle.codec import ArrayOf, BundleReader, BundleWriter, FileOf, all_kinds
from trajopt.planning.infeasibility.reasons import Obstruction
from trajopt.planning.judgement import decide
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.documents.codec import Kinds
from trajopt.values.documents.document import Node
from trajopt.values.documents.files import is_file, written_whole
from trajopt.values.errors import FileFormatError, shown
from trajopt.verify import Judge

LARGEST = 2**28
"""Largest unpacked size of all members together, equal to the limit of other files [bytes]."""
LARGEST_ARRAY = 2**26
"""Largest array, eight million numbers [bytes]."""
LARGEST_DOCUMENT = 2**24
"""Largest JSON document without its arrays and meshes [bytes]; parsing needs thirty times the memory."""
_TYPES = ("<f8", "<i8", "<i4", "|b1")
MOST_MEMBERS = 20_000
"""Most members; each object of a large scene has several arrays."""
ARRAYS = "arrays/"
_NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]{0,99}(/[A-Za-z0-9_-][A-Za-z0-9_.-]{0,99})?")
_PACKED = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
_ENCRYPTED = 0x1
_EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time stamp of every member, constant so that equal contents produce equal files."""


class Members(ABC):
    """Members by name, read one by one."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """The names of the members."""

    @abstractmethod
    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        """Return the bytes of a member."""

    def error(self, reason: str) -> FileFormatError:
        return FileFormatError(str(self.path), reason)

    def array(self, name: str) -> NDArray[np.generic]:
        """Return an array, read-only."""
        data = self.read(name, most=LARGEST_ARRAY)
        stream, layout = io.BytesIO(data), cast("Any", np.lib.format)
        try:
            version = layout.read_magic(stream)
            if version != (1, 0):
                raise self.error(f"{name} is an array of format {version}, known: (1, 0)")
            header: tuple[tuple[int, ...], bool, np.dtype[Any]] = layout.read_array_header_1_0(stream)
        except (ValueError, TypeError, SyntaxError, TokenError, RecursionError, MemoryError) as error:
            raise self.error(f"{name} is not an array: {error}") from error
        shape, fortran, kind = header
        rest = len(data) - stream.tell()
        if fortran or kind.str not in _TYPES:
            raise self.error(f"{name} is an array of a kind that no bundle has: {kind.str}")
        count = 1
        for size in shape:
            count *= size
        if any(size < 0 for size in shape) or count * kind.itemsize != rest:
            raise self.error(f"{name} declares shape {shape}, but has {rest} bytes")
        return cast("NDArray[np.generic]", np.frombuffer(data, kind, count, stream.tell()).reshape(shape))


def array_bytes(array: NDArray[np.generic]) -> bytes:
    """Return an array in numpy's own format, without objects."""
    stream = io.BytesIO()
    layout = cast("Any", np.lib.format)
    layout.write_array(stream, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False)
    return stream.getvalue()


def digest(data: bytes) -> str:
    """Return the SHA-256 of a member, in hexadecimal digits."""
    return sha256(data).hexdigest()


class Archive(Members):
    """The members of a bundle file, read one by one."""

    def __init__(self, path: Path | str) -> None:
        super().__init__(Path(path))
        if not is_file(self.path):
            raise self.error("there is no such file")
        try:
            with zipfile.ZipFile(self.path) as file:
                self._members = {item.filename: item for item in self._checked(file.infolist())}
        except (OSError, ValueError, zipfile.BadZipFile, NotImplementedError) as error:
            raise self.error(f"is not a bundle: {error}") from error

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the members."""
        return tuple(self._members)

    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        item = self._members.get(name)
        if item is None:
            raise self.error(f"has no member {shown(name)}")
        if item.file_size > most:
            raise self.error(f"{name} holds {item.file_size} bytes, more than {most}")
        try:
            with zipfile.ZipFile(self.path) as file, file.open(item) as member:
                data = member.read(most + 1)
        except (OSError, ValueError, EOFError, NotImplementedError, zipfile.BadZipFile, zlib.error) as error:
            raise self.error(f"{name} is damaged: {error}") from error
        if len(data) != item.file_size:
            raise self.error(f"{name} is damaged: it holds {len(data)} bytes and not {item.file_size}")
        return data

    def _checked(self, items: list[zipfile.ZipInfo]) -> Iterable[zipfile.ZipInfo]:
        if len(items) > MOST_MEMBERS:
            raise self.error(f"has {len(items)} members, more than {MOST_MEMBERS}")
        if sum(item.file_size for item in items) > LARGEST:
            raise self.error(f"holds more than {LARGEST >> 20} MB")
        seen = set[str]()
        for item in items:
            if not is_plain(item.filename):
                raise self.error(f"has a member of a name that no bundle has: {shown(item.filename)}")
            if item.filename in seen:
                raise self.error(f"has two members named {shown(item.filename)}")
            if item.compress_type not in _PACKED or item.flag_bits & _ENCRYPTED:
                raise self.error(f"{item.filename} is packed in a way that no bundle is")
            if item.filename.startswith(ARRAYS) and item.file_size > LARGEST_ARRAY:
                raise self.error(f"{item.filename} holds more than {LARGEST_ARRAY >> 20} MB")
            seen.add(item.filename)
            yield item


def is_plain(name: str) -> bool:
    """Return whether a member name is safe: a file in at most one folder inside the archive."""
    return _NAME.fullmatch(name) is not None


def write_archive(path: Path | str, members: Mapping[str, bytes]) -> None:
    """Write the members to a file atomically."""
    if len(members) > MOST_MEMBERS or sum(map(len, members.values())) > LARGEST:
        raise FileFormatError(str(path), f"would hold more than {LARGEST >> 20} MB or {MOST_MEMBERS} members")
    with written_whole(path) as draft, zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            item = zipfile.ZipInfo(name, _EPOCH)
            item.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(item, data)


Kind = TypeVar("Kind")
SHARED = (Robot, Scene, SceneObject, Problem)
"""Values that are sent once, however often they occur."""
_NOWHERE = Path("/nonexistent")  # placeholder: the sender's files do not exist here


def message_of(value: object, known: Mapping[str, object]) -> dict[str, object]:
    """Return a value as plain data for JSON."""
    # Where files are is private: only their names are sent.
    document, writer = shared_document(value, known, file_name=lambda path: path.name)
    arrays = {name: b64encode(array_bytes(each)).decode() for name, each in writer.arrays.items()}
    return {**document, "arrays": arrays}


def shared_document(
    value: object,
    known: Mapping[str, object] | None = None,
    *,
    file_name: Callable[[Path], str] | None = None,
) -> tuple[dict[str, object], BundleWriter]:
    """Return a value's document with the shared values, and the writer with its arrays and files.

    Args:
        file_name: Returns the name of a file; files become members when None.
    """
    references = _References(known or {}, file_name)
    document = references.writer.document(value, "value")
    return {"value": document, "shared": references.shared}, references.writer


def value_of_message(
    node: Node,
    known: Mapping[str, object],
    kind: type[Kind],
    *,
    kinds: Kinds | None = None,
    triangles: float = inf,
    rows: float = inf,
) -> Kind:
    """Return the value of a message from any sender, with bounded arrays; motions in it are judged here.

    Args:
        triangles: Most triangles in all its arrays together.
    """
    node.only(("value", "shared", "arrays"))
    arrays = _Arrays(node["arrays"], triangles, rows)
    value = shared_value_of(
        node, arrays.bounded, lambda name: _NOWHERE / Path(name).name, known=known, kinds=kinds
    )
    if not isinstance(value, kind):
        raise node["value"].error(f"must be a {kind.__name__}, is {shown(value)}")
    return value


def shared_value_of(
    node: Node,
    array_of: ArrayOf,
    file_of: FileOf,
    *,
    known: Mapping[str, object] | None = None,
    kinds: Kinds | None = None,
) -> object:
    """Return the value of a document with shared values; motions in it are judged here."""
    values, shared = known or {}, list[object]()

    def shared_value(reference: Node) -> object:
        place = reference.only(("shared",))["shared"].value
        if type(place) is not int or not 0 <= place < len(shared):
            raise reference.error("names a shared value that is not before it")
        return shared[place]

    def known_value(reference: Node) -> object:
        name = reference.only(("known",))["known"].text()
        if name not in values:
            raise reference.error(f"names {shown(name)}; known are {', '.join(values)}")
        return values[name]

    reader = BundleReader(
        array_of,
        file_of,
        kinds=all_kinds() if kinds is None else kinds,
        references={"known": known_value, "shared": shared_value},
        made=lambda made, place: judged_here(made, place) if isinstance(made, Result) else made,
    )
    for each in node["shared"].elements():
        shared.append(reader.value(each))  # each names only those before it
    return reader.value(node["value"])


class _References:
    """References of a message to values that the reader has, or that are written once."""

    def __init__(self, known: Mapping[str, object], file_name: Callable[[Path], str] | None) -> None:
        self.writer = BundleWriter(all_kinds(), reference=self._document, file_name=file_name)
        self.shared: list[object] = []
        self._known = {id(value): name for name, value in known.items()}
        self._written: dict[int, tuple[object, int]] = {}  # keeps the values, and so their ids

    def _document(self, value: object, place: str) -> object:
        if id(value) in self._known:
            return {"known": self._known[id(value)]}
        match value:
            case Result():
                sent = replace(value, solve=None, timed=None, judged=None, arguments=None)
                return self.writer.whole(sent, place)
            case Obstruction():
                return self.writer.whole(replace(value, residual=None), place)
            case _ if not isinstance(value, SHARED):
                return None
            case _:
                pass
        if id(value) not in self._written:
            document = self.writer.whole(value, place)
            self._written[id(value)] = value, len(self.shared)
            self.shared.append(document)
        return {"shared": self._written[id(value)][1]}


class _Arrays(Members):
    """The arrays of a message, with bounds."""

    def __init__(self, node: Node, triangles: float, rows: float) -> None:
        super().__init__(Path(node.path))
        self._node, self._triangles, self._rows = node, triangles, rows

    @property
    def names(self) -> tuple[str, ...]:
        return self._node.keys()

    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        node = self._node[name]
        try:
            return b64decode(node.text(), validate=True)
        except ValueError as error:
            raise node.error(f"is not an array: {error}") from error

    def bounded(self, name: str) -> NDArray[np.generic]:
        array = self.array(name)
        if array.ndim and array.dtype.kind == "i":
            self._triangles -= len(array)
        if self._triangles < 0 or (array.ndim and array.dtype.kind == "f" and len(array) > self._rows):
            raise self._node[name].error("holds more than a request may")
        return array


def judged_here(result: Result, node: Node) -> Result:
    if result.trajectory is None:
        return result
    problem = result.problem
    verdict, _ = decide(problem, result.trajectory, Judge(problem.reduced))
    if result.verified and not verdict.verified:
        raise node.error(f"has a motion that is not proven: {verdict.certificate.verdict}")
    return replace(result, judged=verdict)
