"""The codec of bundles: large arrays and files are members of their own, and containers add references.

To the documents of `trajopt/values/documents/codec.py` it adds `{"array": name}` for a large array and
`{"file": name}` for a file, both with the name of the member, and `{"kinematics": {...}}` for Pinocchio's
model of a robot. It has three containers: a zip (`Archive`), one JSON message (`message`) and the files of a
campaign, named after the hash of their content.
"""

import json
from collections.abc import Callable, Mapping
from functools import cache
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any, cast

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from trajopt.files.bundle.kinematics import MOST_JOINTS, kinematics_document, model_from
from trajopt.problem.file_kinds import check_fields, check_value, model_kinds
from trajopt.values.documents.codec import Form, Kinds, Reader, Writer, is_mapping, kinds_in, of_known_type
from trajopt.values.documents.document import Node
from trajopt.values.errors import ShapeError

SMALL = 64
"""Most numbers of an array that is written into the document itself, for readers of the file."""
Reference = Callable[[object, str], object]
"""A value and its name in messages -> the document that refers to it; None if the value is written here."""
ArrayOf = Callable[[str], NDArray[np.generic]]
"""The name of an array's member -> the array."""
FileOf = Callable[[str], Path]
"""The name of a file -> its place."""


class BundleWriter(Writer):
    """Converts values to documents, and collects their arrays and files.

    Attributes:
        arrays: Arrays by the name of their member.
        files: Files by the name of their member.
    """

    def __init__(
        self,
        kinds: Kinds | None = None,
        *,
        reference: Reference | None = None,
        file_name: Callable[[Path], str] | None = None,
    ) -> None:
        """Choose the container's part.

        Args:
            kinds: Classes that may be written; those of bundles when None.
            reference: Refers to values that are written elsewhere.
            file_name: Returns the name of a file; files become members when None.
        """
        super().__init__(bundle_kinds() if kinds is None else kinds)
        self._reference, self._file_name = reference, file_name or self._member
        self.arrays: dict[str, NDArray[np.generic]] = {}
        self.files: dict[str, Path] = {}
        self._by_path: dict[Path, str] = {}

    def array(self, value: NDArray[np.generic], place: str) -> object:
        """Return an array as a document, or the name of its member."""
        value = of_known_type(value)
        if 0 < value.size <= SMALL and np.isfinite(cast("Any", value)).all():
            return super().array(value, place)
        name = f"arrays/{len(self.arrays)}.npy"
        self.arrays[name] = value
        return {"array": name}

    def instance(self, value: object, place: str) -> object:
        """Return a reference to a value, a file, a model of a robot or an instance as a document.

        Raises:
            ModelError: If it is none of these.
        """
        referred = None if self._reference is None else self._reference(value, place)
        if referred is not None:
            return referred
        match value:
            case Path():
                return {"file": self._file_name(value)}
            case pin.Model():
                return {"kinematics": self._tree(kinematics_document(value))}
            case _:
                return self.whole(value, place)

    def whole(self, value: object, place: str) -> object:
        """Return an instance as a document, without a reference to it."""
        return super().instance(value, place)

    def _member(self, path: Path) -> str:
        """Return the name of a file's member; of descriptions and missing files the name alone."""
        if path not in self._by_path:
            if path.suffix.lower() == ".urdf" or not path.is_file():
                return path.name
            name = f"meshes/{len(self.files)}{path.suffix.lower()}"
            self._by_path[path], self.files[name] = name, path
        return self._by_path[path]

    def _tree(self, item: object) -> object:
        if isinstance(item, dict):
            return {key: self._tree(each) for key, each in cast("dict[str, object]", item).items()}
        if isinstance(item, list):
            return [self._tree(each) for each in cast("list[object]", item)]
        return self.document(item, "kinematics")


class BundleReader(Reader):
    """Makes values of documents: only of known classes, each checked again."""

    def __init__(
        self,
        array_of: ArrayOf,
        file_of: FileOf,
        *,
        kinds: Kinds | None = None,
        references: Mapping[str, Form] | None = None,
        made: Callable[[object, Node], object] | None = None,
    ) -> None:
        """Choose the container's part.

        Args:
            array_of: Returns the arrays that are members.
            file_of: Returns the places of files.
            kinds: Classes that may be read; those of bundles when None.
            references: Readers of the container's references, by their key.
            made: Replaces a value that was made, such as a result whose motion is judged again.
        """
        forms: dict[str, Form] = {
            "file": lambda node: file_of(node.only(("file",))["file"].text()),
            "kinematics": self._kinematics,
            **(references or {}),
        }
        super().__init__(bundle_kinds() if kinds is None else kinds, check_fields, check_value, forms)
        self._array_of, self._made = cache(array_of), made  # each array is read once

    def value(self, node: Node) -> Any:
        """Return the value that a document states.

        Raises:
            FileFormatError: If it does not state one.
        """
        found: object = super().value(node)
        return found if self._made is None or not node.has("kind") else self._made(found, node)

    def array(self, node: Node) -> NDArray[np.generic]:
        """Return an array, of the document or of a member.

        Raises:
            FileFormatError: If it is not an array.
        """
        if isinstance(node["array"].value, str):
            return self._array_of(node.only(("array", "type"))["array"].text())
        return super().array(node)

    def _kinematics(self, node: Node) -> pin.Model:
        stated = node.only(("kinematics",))["kinematics"]
        if len(stated["joints"].elements()) > MOST_JOINTS:
            raise stated["joints"].error(f"are more than {MOST_JOINTS}")
        tree = Node(self._tree(stated), node.path, f"{node.place}.kinematics")
        try:
            return model_from(tree)
        except ShapeError as error:
            raise node.error(str(error)) from error
        except (ValueError, RuntimeError) as error:
            raise node.error(f"is not a model of a robot: {error}") from error

    def _tree(self, node: Node) -> object:
        if isinstance(node.value, list):
            return [self._tree(item) for item in node.elements()]
        if not is_mapping(node.value):
            return node.value
        if "array" in node.value:
            return self.array(node)
        return {key: self._tree(node[key]) for key in node.value}


_ASKED = {"trajopt.tasks.grasping.grasp": "Straight Grasp Place", "trajopt.tasks.grasping.gripper": "Gripper"}
_ANSWERED = {
    "trajopt.planning.budget": "Stop",
    "trajopt.planning.status": "Status Certainty",
    "trajopt.planning.result": "Attempt Result",
    "trajopt.planning.seeds.source": "SeedKind",
    "trajopt.planning.infeasibility.reasons": "Obstruction ObstructionKind",
    "trajopt.optimise.solvers.solver": "SolverStatus",
    "trajopt.tasks.cartesian.result": "Followed StopReason",
    "trajopt.tasks.grasping.result": "Stage Segment Refusal PickPlaceResult",
}
_OF_ROBOTS = {"Robot", "CollisionBody", "JointLimits", "LinkGeometry", "MeshReference"}
"""Parts of robots: a request names a robot and does not contain one."""


@cache
def bundle_kinds() -> Kinds:
    """Return the classes of bundles: of problems and of the arguments of planning."""
    return {
        **model_kinds(),
        **kinds_in(
            {
                "trajopt.optimise.nlp": "Loss",
                "trajopt.problem.residual": "Cost Constraint Window",
                "trajopt.problem.smoothness": "Velocity Acceleration Jerk",
                "trajopt.optimise.terms.joint_positions": "RestPosture",
                "trajopt.optimise.terms.singularity_distance": "LostManipulability",
                "trajopt.problem.problem": "Problem",
                "trajopt.planning.budget": "Budget",
            }
        ),
    }


@cache
def request_kinds() -> Kinds:
    """Return the classes of requests to a server: of bundles without robots, and grasps and places."""
    there = {name: kind for name, kind in bundle_kinds().items() if name not in _OF_ROBOTS}
    return {**there, **kinds_in(_ASKED)}


@cache
def all_kinds() -> Kinds:
    return {**bundle_kinds(), **kinds_in({**_ASKED, **_ANSWERED})}


def _digest(path: Path) -> str:
    # The document contains the model of the description; only meshes are files.
    if path.suffix.lower() == ".urdf" or not path.is_file():
        return path.suffix.lower()
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()


def fingerprint(value: object) -> str:
    """Return a digest; values with equal numbers, names and mesh contents have equal digests.

    Args:
        value: A robot, a scene, a problem or a part of one.

    Raises:
        ModelError: If it contains an object that cannot be stored, such as code of the caller.
    """
    return digest_as_written(BundleWriter(file_name=cache(_digest)), value)


def digest_as_written(writer: BundleWriter, value: object) -> str:
    """Return a digest of a value's document and arrays, as written by a new writer.

    Raises:
        ModelError: If the value contains an object that cannot be stored.
    """
    whole = sha256(json.dumps(writer.document(value, type(value).__name__)).encode())
    for array in writer.arrays.values():
        whole.update(f"{array.dtype} {array.shape}".encode() + array.tobytes())
    return whole.hexdigest()
