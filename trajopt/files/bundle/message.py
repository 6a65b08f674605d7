"""Values for another process: bundle documents and their arrays in one JSON document.

Values known to both sides are sent by name. Scenes, objects and problems that occur several times are
sent once. Verdicts are never sent: the receiver verifies each motion itself.
"""

from base64 import b64decode, b64encode
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from math import inf
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from trajopt.files.bundle.from_document import Reader
from trajopt.files.bundle.kinds import bundle_kinds
from trajopt.files.bundle.members import LARGEST, Members, array_bytes
from trajopt.files.bundle.to_document import Writer
from trajopt.planning.infeasibility.reasons import Obstruction
from trajopt.planning.judgement import decide
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.documents.document import Node
from trajopt.values.documents.values import Kinds, kinds_in
from trajopt.values.errors import shown
from trajopt.verify import Judge

Kind = TypeVar("Kind")
_ASKED = {"trajopt.tasks.grasping.grasp": "Straight Grasp Place", "trajopt.tasks.grasping.gripper": "Gripper"}
_ANSWERED = {
    "trajopt.planning.budget": "Stop",
    "trajopt.planning.status": "Status Certainty",
    "trajopt.planning.records": "Attempt",
    "trajopt.planning.result": "Result",
    "trajopt.planning.seeds.source": "SeedKind",
    "trajopt.planning.infeasibility.reasons": "Obstruction ObstructionKind",
    "trajopt.optimise.solvers.solver": "SolverStatus",
    "trajopt.tasks.cartesian.result": "Followed StopReason",
    "trajopt.tasks.grasping.result": "Stage Segment Refusal PickPlaceResult",
}
_OF_ROBOTS = {"Robot", "CollisionBody", "JointLimits", "LinkGeometry", "MeshReference"}
"""Kinds that only robots contain; requests refer to robots by name instead."""
SHARED = (Scene, SceneObject, Problem)
"""Kinds that are sent once, even if they occur several times."""
_NOWHERE = Path("/nonexistent")  # placeholder: the sender's files do not exist here


@cache
def request_kinds() -> Kinds:
    """Return the kinds allowed in a request: bundle kinds except robots, and grasps and places."""
    there = {name: kind for name, kind in bundle_kinds().items() if name not in _OF_ROBOTS}
    return {**there, **kinds_in(_ASKED)}


@cache
def all_kinds() -> Kinds:
    """Return the kinds allowed in an answer: robots, and results of all kinds."""
    return {**bundle_kinds(), **kinds_in({**_ASKED, **_ANSWERED})}


def message_of(value: object, known: Mapping[str, object]) -> dict[str, object]:
    """Return a value as plain data for JSON.

    Args:
        value: The value.
        known: Values that the receiver already has, by shared name.

    Raises:
        ModelError: If the value contains code of the caller, which cannot be sent.
    """
    writer = _Writer(known)
    document = writer.document(value, "value")
    arrays = {name: b64encode(array_bytes(each)).decode() for name, each in writer.arrays.items()}
    return {"value": document, "shared": writer.shared, "arrays": arrays}


def value_of_message(
    node: Node,
    known: Mapping[str, object],
    kind: type[Kind],
    *,
    kinds: Kinds | None = None,
    triangles: float = inf,
    rows: float = inf,
) -> Kind:
    """Return the value of an untrusted message; its motions are verified here.

    Args:
        node: The message.
        known: Values that this side already has, by shared name.
        kind: Required kind of the value.
        kinds: Kinds allowed inside it; `all_kinds()` when None.
        triangles: Largest total number of triangles in its arrays.
        rows: Largest number of rows of each other array.

    Raises:
        FileFormatError: If the message is not a value of this kind, or is too large.
    """
    node.only(("value", "shared", "arrays"))
    reader = _Reader(node, known, all_kinds() if kinds is None else kinds, triangles, rows)
    value = reader.value(node["value"])
    if not isinstance(value, kind):
        raise node["value"].error(f"must be a {kind.__name__}, is {shown(value)}")
    return value


class _Writer(Writer):
    def __init__(self, known: Mapping[str, object]) -> None:
        super().__init__()
        self._kinds = all_kinds()
        self._known = {id(value): name for name, value in known.items()}
        self.shared: list[object] = []
        self._written: dict[int, tuple[object, int]] = {}  # holding the values keeps their ids unique

    def other(self, value: object, place: str) -> object:
        if id(value) in self._known:
            return {"known": self._known[id(value)]}
        match value:
            case Path():
                return {"file": value.name}  # do not disclose the folder
            case Result():
                value = replace(value, solve=None, timed=None, judged=None, arguments=None)
            case Obstruction():
                value = replace(value, residual=None)
            case _:
                pass
        if not isinstance(value, SHARED):
            return super().other(value, place)
        if id(value) not in self._written:
            document = super().other(value, place)
            self._written[id(value)] = value, len(self.shared)
            self.shared.append(document)
        return {"shared": self._written[id(value)][1]}


class _Arrays(Members):
    def __init__(self, node: Node) -> None:
        super().__init__(Path(node.path))
        self._node = node

    @property
    def names(self) -> tuple[str, ...]:
        return self._node.keys()

    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        node = self._node[name]
        try:
            return b64decode(node.text(), validate=True)
        except ValueError as error:
            raise node.error(f"is not an array: {error}") from error


class _Reader(Reader):
    def __init__(
        self, message: Node, known: Mapping[str, object], kinds: Kinds, triangles: float, rows: float
    ) -> None:
        super().__init__(self._array_named, lambda name: _NOWHERE / Path(name).name)
        self._kinds = kinds
        self._forms = {**self._forms, "known": self._known_value, "shared": self._shared_value}
        self._node, self._arrays, self._known = message["arrays"], _Arrays(message["arrays"]), known
        self._triangles, self._rows = triangles, rows
        self._made: list[object] = []
        for each in message["shared"].elements():
            self._made.append(self.value(each))  # each may refer only to earlier ones

    def value(self, node: Node) -> Any:
        made: object = super().value(node)
        return judged_here(made, node) if isinstance(made, Result) and node.has("kind") else made

    def _known_value(self, node: Node) -> Any:
        name = node.only(("known",))["known"].text()
        if name not in self._known:
            raise node.error(f"names {shown(name)}; known are {', '.join(self._known)}")
        return self._known[name]

    def _shared_value(self, node: Node) -> Any:
        place = node.only(("shared",))["shared"].value
        if type(place) is not int or not 0 <= place < len(self._made):
            raise node.error("names a shared value that is not before it")
        return self._made[place]

    def _array_named(self, name: str) -> NDArray[np.generic]:
        array = self._arrays.array(name)
        if array.ndim and array.dtype.kind == "i":
            self._triangles -= len(array)
        if self._triangles < 0 or (array.ndim and array.dtype.kind == "f" and len(array) > self._rows):
            raise self._node[name].error("holds more than a request may")
        return array


def judged_here(result: Result, node: Node) -> Result:
    """Return a result with this process's own verdict on its motion.

    Args:
        result: The result received from another process.
        node: The place of the result in the message.

    Raises:
        FileFormatError: If its motion is declared proven but is not.
    """
    if result.trajectory is None:
        return result
    problem = result.problem
    verdict, _ = decide(problem, result.trajectory, Judge(problem.reduced))
    if result.verified and not verdict.verified:
        raise node.error(f"has a motion that is not proven: {verdict.certificate.verdict}")
    return replace(result, judged=verdict)
