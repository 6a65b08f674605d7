"""The codec of bundles: large arrays and files are members of their own, and containers add references.

To the documents of `trajopt/values/documents/codec.py` it adds `{"array": name}`, `{"file": name}` and
`{"kinematics": {...}}`. Its containers are a zip (`Archive`), one JSON message (`message`) and the files of a
campaign.
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

from trajopt.problem.file_kinds import check_fields, check_value, model_kinds
from trajopt.values.arrays import Floats, floats
from trajopt.values.documents.codec import Form, Kinds, Reader, Writer, is_mapping, kinds_in, of_known_type
from trajopt.values.documents.document import Node
from trajopt.values.errors import ShapeError
from trajopt.values.placement import as_placement

SMALL = 64
"""Most numbers of an array written into the document itself, for readers of the file."""
Reference = Callable[[object, str], object]
"""A value and its name in messages -> the document that refers to it; None if the value is written here."""
ArrayOf = Callable[[str], NDArray[np.generic]]
FileOf = Callable[[str], Path]


class BundleWriter(Writer):
    """Converts values to documents, and collects their arrays and files by member."""

    def __init__(
        self,
        kinds: Kinds | None = None,
        *,
        reference: Reference | None = None,
        file_name: Callable[[Path], str] | None = None,
    ) -> None:
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
        """Return a reference to a value, a file, a model of a robot or an instance as a document."""
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
        found: object = super().value(node)
        return found if self._made is None or not node.has("kind") else self._made(found, node)

    def array(self, node: Node) -> NDArray[np.generic]:
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


_OF_REQUESTS = {
    "trajopt.tasks.grasping.grasp": "Straight Grasp Place",
    "trajopt.tasks.grasping.gripper": "Gripper",
}
_ANSWERED = {
    "trajopt.planning.budget": "Stop",
    "trajopt.planning.status": "Status Certainty",
    "trajopt.planning.result": "Attempt Result",
    "trajopt.planning.seeds.source": "SeedKind",
    "trajopt.planning.infeasibility.reasons": "Obstruction ObstructionKind",
    "trajopt.optimise.solvers.solver": "SolverStatus",
    "trajopt.tasks.cartesian.result": "Followed StopReason",
    "trajopt.tasks.grasping.result": "Stage Segment PickPlaceResult",
    "trajopt.tasks.sequence": "CandidateNames StageRefusal StageNode",
    "trajopt.tasks.result": "StageRest TaskSegment Handling TaskResult",
}
_OF_ROBOTS = {"Robot", "CollisionBody", "JointLimits", "LinkGeometry", "MeshReference"}
"""Parts of robots: a request names a robot and does not contain one."""


@cache
def bundle_kinds() -> Kinds:
    """Return the classes whose values bundles contain."""
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
    return {**there, **kinds_in(_OF_REQUESTS)}


@cache
def all_kinds() -> Kinds:
    return {**bundle_kinds(), **kinds_in({**_OF_REQUESTS, **_ANSWERED})}


def _digest(path: Path) -> str:
    # The document contains the model of the description; only meshes are files.
    if path.suffix.lower() == ".urdf" or not path.is_file():
        return path.suffix.lower()
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()


def fingerprint(value: object) -> str:
    """Return a digest; values with equal numbers, names and mesh contents have equal digests."""
    return digest_as_written(BundleWriter(file_name=cache(_digest)), value)


def digest_as_written(writer: BundleWriter, value: object) -> str:
    """Return a digest of a value's document and arrays, as written by a new writer."""
    whole = sha256(json.dumps(writer.document(value, type(value).__name__)).encode())
    for array in writer.arrays.values():
        whole.update(f"{array.dtype} {array.shape}".encode() + array.tobytes())
    return whole.hexdigest()


MOST_JOINTS = 1_000
"""Most joints: ten times a humanoid with hands. """
_JOINTS: Mapping[str, Callable[[], Any]] = {
    kind().shortname(): kind
    for kind in (
        *(pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ),
        *(pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ),
        *(pin.JointModelRUBX, pin.JointModelRUBY, pin.JointModelRUBZ),
    )
}
_CONTINUOUS = """<robot name="one"><link name="a"/><link name="b"/>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0.1 0.7 0.4"/>
<limit effort="1" velocity="1"/></joint></robot>"""
_OF_POSITIONS = ("lowerPositionLimit", "upperPositionLimit")
_OF_RATES = (
    *("velocityLimit", "effortLimit", "friction", "damping"),
    *("armature", "rotorInertia", "rotorGearRatio"),
)
_FRAMES = {
    str(kind): kind
    for kind in (
        *(pin.FrameType.OP_FRAME, pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT),
        *(pin.FrameType.BODY, pin.FrameType.SENSOR),
    )
}


def _continuous(axis: Floats) -> Any:
    """Return a joint without limits about an axis, exact to the last digit.

    Its constructor takes no axis, and the URDF reader rounds, so the axis is overwritten afterwards.
    """
    model = pin.buildModelFromXML(_CONTINUOUS)
    read = _axis(model.joints[1])
    model.loadFromString(model.saveToString().replace(_digits(read), _digits(axis)))
    return model.joints[1]


def _digits(axis: Floats) -> str:
    return " ".join(format(float(part), ".17e") for part in axis)


def _unaligned(kind: Callable[[float, float, float], Any]) -> Callable[[Floats], Any]:
    def joint(axis: Floats) -> Any:
        made = kind(1.0, 0.0, 0.0)
        made.axis = axis  # the constructor would normalise it again
        return made

    return joint


_UNALIGNED: Mapping[str, Callable[[Floats], Any]] = {
    pin.JointModelRevoluteUnaligned().shortname(): _unaligned(pin.JointModelRevoluteUnaligned),
    pin.JointModelPrismaticUnaligned().shortname(): _unaligned(pin.JointModelPrismaticUnaligned),
    pin.JointModelRevoluteUnboundedUnaligned().shortname(): _continuous,
}


def kinematics_document(model: pin.Model) -> dict[str, object]:
    """Return a model as plain data with arrays: joints, inertias and frames, in model order.

    Pinocchio's own archives load unchecked memory from untrusted files.
    """
    joints = [_joint(model, place) for place in range(1, model.njoints)]
    frames = [_frame(frame) for frame in model.frames]
    names = (*_OF_POSITIONS, *_OF_RATES)
    return {
        "name": str(model.name),
        "bodies": int(model.nbodies),
        "gravity": np.array(model.gravity.vector),
        "base_inertia": _inertia(model.inertias[0]),
        "joints": joints,
        "frames": frames,
        **{name: np.array(getattr(model, name)) for name in names},
    }


def _joint(model: pin.Model, place: int) -> dict[str, object]:
    joint = model.joints[place]
    kind = str(joint.shortname())
    if kind not in _JOINTS and kind not in _UNALIGNED:
        raise KeyError(kind)
    axis = {} if kind in _JOINTS else {"axis": _axis(joint)}
    return {
        "name": str(model.names[place]),
        "kind": kind,
        **axis,
        "parent": int(model.parents[place]),
        "placement": model.jointPlacements[place].np.copy(),
        "inertia": _inertia(model.inertias[place]),
    }


def _axis(joint: Any) -> Floats:
    data = joint.createData()
    joint.calc(data, np.array([1.0, 0.0][: joint.nq]))
    subspace = np.array(data.S).ravel()
    return subspace[3:] if subspace[3:].any() else subspace[:3]


def _frame(frame: Any) -> dict[str, object]:
    return {
        "name": str(frame.name),
        "kind": str(frame.type),
        "joint": int(frame.parentJoint),
        "parent": int(frame.parentFrame),
        "placement": frame.placement.np.copy(),
        "inertia": _inertia(frame.inertia),
    }


def _inertia(inertia: Any) -> Floats:
    return np.concatenate(([inertia.mass], inertia.lever, inertia.inertia.ravel()))


def model_from(node: Node) -> pin.Model:
    """Build a model from the output of `kinematics_document`, with its arrays read."""
    model = pin.Model()
    model.name = node["name"].text()
    model.gravity = pin.Motion(_array(node["gravity"], (6,)))
    joints = node["joints"].elements()
    for joint in joints:
        parent = _index(joint["parent"], model.njoints)
        model.addJoint(parent, _kind(joint), _placement(joint["placement"]), joint["name"].text())
    frames = node["frames"].elements()
    for _ in range(1, _index(node["bodies"], len(frames) + 2)):
        model.appendBodyToJoint(0, pin.Inertia.Zero(), pin.SE3.Identity())
    inertias = [node["base_inertia"], *(joint["inertia"] for joint in joints)]
    for place, inertia in enumerate(inertias):
        model.inertias[place] = _inertia_of(inertia)
    for place, frame in enumerate(frames):
        _add_frame(model, frame, place)
    for name in (*_OF_POSITIONS, *_OF_RATES):
        size = model.nq if name in _OF_POSITIONS else model.nv
        setattr(model, name, _array(node[name], (size,), infinite=True))
    return model


def _add_frame(model: pin.Model, node: Node, place: int) -> None:
    joint, kind = _index(node["joint"], model.njoints), _FRAMES.get(node["kind"].text())
    if kind is None:
        raise node["kind"].error("is not a kind of frame")
    parent = _index(node["parent"], max(place, 1))
    at, inertia = _placement(node["placement"]), _inertia_of(node["inertia"])
    if place == 0:  # the world, in every model
        return
    before = model.nframes
    model.addFrame(pin.Frame(node["name"].text(), joint, parent, at, kind, inertia), False)
    if model.nframes == before:
        raise node["name"].error("is the name of two frames")


def _kind(joint: Node) -> Any:
    kind = joint["kind"].text()
    if kind in _JOINTS:
        return _JOINTS[kind]()
    if kind not in _UNALIGNED:
        raise joint["kind"].error("is not a kind of joint")
    axis = _array(joint["axis"], (3,))
    if abs(float(np.linalg.norm(axis)) - 1.0) > 1e-6:
        raise joint["axis"].error("is not of length one")
    return _UNALIGNED[kind](axis)


def _placement(node: Node) -> pin.SE3:
    at = as_placement(node.place, _array(node, (4, 4)))
    return pin.SE3(np.array(at.rotation), np.array(at.translation))


def _inertia_of(node: Node) -> pin.Inertia:
    numbers = _array(node, (13,))
    if numbers[0] < 0.0:
        raise node.error("has a negative mass")
    return pin.Inertia(float(numbers[0]), numbers[1:4], numbers[4:].reshape(3, 3))


def _index(node: Node, count: int) -> int:
    if not isinstance(node.value, int) or isinstance(node.value, bool) or not 0 <= node.value < count:
        raise node.error(f"must be a number from 0 to {count - 1}")
    return node.value


def _array(node: Node, shape: tuple[int, ...], *, infinite: bool = False) -> Floats:
    value = cast("Any", node.value)
    if not isinstance(value, np.ndarray) or cast("Floats", value).shape != shape:
        raise node.error(f"must be an array of shape {shape}")
    numbers = np.array(value, dtype=np.float64)
    return numbers if infinite else np.array(floats(node.place, numbers, shape))
