"""Values for another process: bundle documents and their arrays in one JSON document.

Values known to both sides are sent by name, repeated ones once. Verdicts are never sent.
"""

from base64 import b64decode, b64encode
from collections.abc import Mapping
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from trajopt.files.bundle.codec import BundleReader, BundleWriter, all_kinds
from trajopt.files.bundle.members import LARGEST, Members, array_bytes
from trajopt.planning.infeasibility.reasons import Obstruction
from trajopt.planning.judgement import decide
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.documents.codec import Kinds
from trajopt.values.documents.document import Node
from trajopt.values.errors import shown
from trajopt.verify import Judge

Kind = TypeVar("Kind")
SHARED = (Scene, SceneObject, Problem)
"""Values that are sent once, however often they occur."""
_NOWHERE = Path("/nonexistent")  # placeholder: the sender's files do not exist here


def message_of(value: object, known: Mapping[str, object]) -> dict[str, object]:
    """Return a value as plain data for JSON.

    Args:
        known: Values that the reader has already, by the name that both sides use.
    """
    references = _References(known)
    document = references.writer.document(value, "value")
    arrays = {name: b64encode(array_bytes(each)).decode() for name, each in references.writer.arrays.items()}
    return {"value": document, "shared": references.shared, "arrays": arrays}


def value_of_message(
    node: Node,
    known: Mapping[str, object],
    kind: type[Kind],
    *,
    kinds: Kinds | None = None,
    triangles: float = inf,
    rows: float = inf,
) -> Kind:
    """Return the value of a message from any sender; motions in it are judged here.

    Args:
        known: Values that are here already, by the name that both sides use.
        kinds: Classes that it may contain; `all_kinds()` when None.
        triangles: Most triangles in all its arrays together.
        rows: Most rows of each other array.
    """
    node.only(("value", "shared", "arrays"))
    arrays = _Arrays(node["arrays"], triangles, rows)
    shared: list[object] = []

    def shared_value(reference: Node) -> object:
        place = reference.only(("shared",))["shared"].value
        if type(place) is not int or not 0 <= place < len(shared):
            raise reference.error("names a shared value that is not before it")
        return shared[place]

    def known_value(reference: Node) -> object:
        name = reference.only(("known",))["known"].text()
        if name not in known:
            raise reference.error(f"names {shown(name)}; known are {', '.join(known)}")
        return known[name]

    reader = BundleReader(
        arrays.bounded,
        lambda name: _NOWHERE / Path(name).name,
        kinds=all_kinds() if kinds is None else kinds,
        references={"known": known_value, "shared": shared_value},
        made=lambda made, place: judged_here(made, place) if isinstance(made, Result) else made,
    )
    for each in node["shared"].elements():
        shared.append(reader.value(each))  # each names only those before it
    value = reader.value(node["value"])
    if not isinstance(value, kind):
        raise node["value"].error(f"must be a {kind.__name__}, is {shown(value)}")
    return value


class _References:
    """References of a message to values that the reader has, or that are written once."""

    def __init__(self, known: Mapping[str, object]) -> None:
        # Where files are is private: only their names are sent.
        self.writer = BundleWriter(all_kinds(), reference=self._document, file_name=lambda path: path.name)
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
