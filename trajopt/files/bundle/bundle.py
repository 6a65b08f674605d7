"""Write and read bundles."""

import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from enum import Enum
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, TypeVar, cast

from trajopt.files.bundle.codec import BundleReader, BundleWriter
from trajopt.files.bundle.containers import (
    LARGEST,
    LARGEST_DOCUMENT,
    Archive,
    Members,
    array_bytes,
    digest,
    shared_document,
    shared_value_of,
    write_archive,
)
from trajopt.files.proof import MotionProof, prove
from trajopt.planning.budget import Budget
from trajopt.planning.judgement import judge
from trajopt.planning.result import Plan, PlanArguments, Recalled, Result, SavedResult
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, Value, floats, one_of
from trajopt.values.documents.document import Node
from trajopt.values.documents.files import read_bytes, refuse_deep_nesting
from trajopt.values.errors import FileFormatError, ModelError, ProblemError, ShapeError, TrajoptError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Path as PlannedPath
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate

FORMAT = "trajopt bundle"
VERSION = 1
"""Format version. trajopt reads all older versions and refuses newer ones."""
SUFFIX = ".trajopt"
DESCRIPTION, PROBLEM, ARGUMENTS, ANSWER, MOTION, EXPLANATION, URDF, PROOF = (
    *("bundle.json", "problem.json", "arguments.json", "answer.json", "motion.json"),
    *("explanation.json", "robot.urdf", "motion.proof"),
)
"""The documents of a bundle; arrays are in `arrays/`, meshes in `meshes/`."""
_PACKAGES = ("numpy", "pin", "coal", "casadi", "osqp", "mujoco", "scipy")
Kind = TypeVar("Kind")
_ARGUMENTS = (
    *("method", "improve", "every_goal", "seeds", "experience", "budget", "random", "planned_by"),
    "custom_method",
)
MOST_VALUES = 500_000
"""Most values in a document; ten thousand boxes in a scene have about 350,000."""
_NO_FOLDER = Path("/nonexistent")  # placeholder for meshes that were not unpacked
VALUE = "value.json"


class Holds(Enum):
    """Kind of content of a bundle; each value is its description."""

    PLAN = "a plan"
    FAILURE = "a problem that planning did not solve"
    PROBLEM = "a problem"
    MOTIONS = "the result of several motions"


@dataclass(frozen=True, eq=False, kw_only=True)
class Bundle(Value):
    """The content of a bundle file.

    Attributes:
        arguments: Of the planning call; None if not planned or unknown.
        custom_method: Whether the method was an object with its own options, which a file cannot hold.
        trajectory: The motion, verified or not; None if planning did not reach one.
        path_planned: Likewise, without timing.
        proof: Of the motion, if it was requested; `proof.check()` runs the checker.
    """

    path: Path
    holds: Holds
    made: str
    versions: Mapping[str, str]
    problem: Problem
    arguments: PlanArguments | None = None
    method: str = ""
    custom_method: bool = False
    trajectory: Trajectory | None = None
    path_planned: PlannedPath | None = None
    answer: Mapping[str, object] = field(default_factory=dict[str, object])
    explanation: Mapping[str, object] = field(default_factory=dict[str, object])
    proof: MotionProof | None = None

    @property
    def status(self) -> str:
        """Name of the status of planning; empty if not planned."""
        return str(self.answer.get("status", ""))

    def require(self) -> Trajectory:
        if self.trajectory is None:
            raise ModelError(f"{self.path} holds {self.holds.value}, and no motion")
        return self.trajectory

    def judged(self) -> Certificate:
        """Verify the motion again, ignoring any verdict in the file.

        Raises:
            ModelError: If the bundle has no motion.
        """
        return judge(self.problem, self.require())

    def __repr__(self) -> str:
        return f"Bundle({shown(self.problem.name)}: {self.holds.value})"

    def __str__(self) -> str:
        lines = [
            f"{self.path.name}: {self.holds.value}, written {self.made} by trajopt "
            f"{self.versions.get('trajopt', '(unknown)')}",
            str(self.problem),
        ]
        if self.answer:
            lines.append(f"  answer       {self.answer.get('message', self.status)}")
        if self.trajectory is not None:
            lines.append(f"  motion       {self.trajectory}")
        return "\n".join(lines)


@checked
def save(
    what: Result | Plan | Problem | Value, path: Path | str, *, explained: bool = True, proof: bool = False
) -> None:
    """Write a result, a plan or a problem as a bundle, with visual meshes.

    Args:
        what: A result, a plan, or a problem; or a result of several motions, which `read_result` reads.
        explained: Whether to include the explanation of a failure, which may take seconds.
        proof: Whether to include a proof of the motion (docs/proofs.md).

    Raises:
        ModelError: If the problem contains code of the caller, which a file cannot hold.
        ProblemError: If a proof is requested, but there is no verified motion, or no witness is found.
        FileFormatError: If the file cannot be written, or a mesh of the robot cannot be read.
    """
    if isinstance(what, Result | Plan | Problem):
        write_archive(path, bundle_members(what, explained=explained, proof=proof))
        return
    if proof:
        raise ProblemError("each segment has a proof of its own: segment.result.require().save_proof(path)")
    write_archive(path, result_members(what))


def result_members(what: Value) -> dict[str, bytes]:
    """Return the members of a `SavedResult` by name."""
    document, writer = shared_document(what)
    members = {VALUE: _json(document), **named_members(writer)}
    name = str(getattr(what, "name", type(what).__name__))
    return {DESCRIPTION: _described(Holds.MOTIONS, name, members), **members}


def bundle_members(
    what: Result | Plan | Problem, *, explained: bool = True, proof: bool = False
) -> dict[str, bytes]:
    """Return the members of a bundle by name; see `save`."""
    writer, members = BundleWriter(), dict[str, bytes]()
    problem = what if isinstance(what, Problem) else what.problem
    if proof:
        members[PROOF] = _proof(what).data
    members[PROBLEM] = _json(writer.document(problem, "problem"))
    if not isinstance(what, Problem):
        members |= _answer_members(writer, what)
    if isinstance(what, Result):
        members |= _arguments_members(writer, what)
        if explained and not what.verified:
            members[EXPLANATION] = _json(what.explain().as_dict())
    if problem.scene.robot.urdf_xml.lstrip().startswith("<"):
        members[URDF] = problem.scene.robot.urdf_xml.encode()
    members |= named_members(writer)
    return {DESCRIPTION: _described(_holds(what), problem.name, members), **members}


def _described(holds: Holds, name: str, members: Mapping[str, bytes]) -> bytes:
    return _json(
        {
            "format": FORMAT,
            "version": VERSION,
            "holds": holds.name,
            "name": name,
            "made": datetime.now(UTC).isoformat(timespec="seconds"),
            "versions": versions(),
            "members": {name: digest(data) for name, data in members.items()},
        }
    )


def _proof(what: Result | Plan | Problem) -> MotionProof:
    if isinstance(what, Problem) or what.trajectory is None:
        raise ProblemError(f"there is no motion of {shown(what)} that could be proven: save it without proof")
    return prove(what.problem, what.trajectory)


def named_members(writer: BundleWriter) -> dict[str, bytes]:
    """Return the arrays and meshes named in documents."""
    arrays = {name: array_bytes(array) for name, array in writer.arrays.items()}
    return arrays | {name: _mesh(file) for name, file in writer.files.items()}


def versions() -> Mapping[str, str]:
    """Return the versions of Python, trajopt and its dependencies, by name."""
    found = {"python": platform.python_version(), "machine": platform.machine()}
    for name, package in (("trajopt", "trajopt-planner"), *((each, each) for each in _PACKAGES)):
        try:
            found[name] = version(package)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def _holds(what: Result | Plan | Problem) -> Holds:
    if isinstance(what, Problem):
        return Holds.PROBLEM
    return Holds.PLAN if isinstance(what, Plan) or what.verified else Holds.FAILURE


def _answer_members(writer: BundleWriter, what: Result | Plan) -> dict[str, bytes]:
    stated = {"path": what.path, "trajectory": what.trajectory}
    motion = {name: writer.document(each, name) for name, each in stated.items() if each is not None}
    if isinstance(what, Plan):
        answer = {"status": "SOLVED", "verified": True, "certificate": what.certificate.as_dict()}
    else:
        answer = what.as_dict()
        # The motion has its own document.
        for name in ("joint_names", "points"):
            answer.pop(name, None)
    return {ANSWER: _json(answer), MOTION: _json(motion)}


def _arguments_members(writer: BundleWriter, result: Result) -> dict[str, bytes]:
    arguments = result.arguments
    if arguments is None:
        return {}
    own = arguments.method is not None and not isinstance(arguments.method, str)
    budget = arguments.budget
    stated: Mapping[str, object] = {
        "method": None if own else arguments.method,
        "improve": arguments.improve,
        "every_goal": arguments.every_goal,
        "seeds": arguments.seeds,
        # A clock is code, so the budget is stored without it.
        "budget": Budget(
            budget.seconds, budget.work, budget.attempts, workers=budget.workers, improve=budget.improve
        ),
    }
    document = {name: writer.document(each, f"arguments.{name}") for name, each in stated.items()}
    recalled = arguments.recalled
    document["experience"] = None if recalled is None else recalled.as_dict()
    document["random"] = (
        None if arguments.random is None else json.loads(json.dumps(arguments.random, default=_plain_state))
    )
    return {ARGUMENTS: _json({**document, "planned_by": result.method, "custom_method": own})}


def _plain_state(item: object) -> object:
    tolist = getattr(item, "tolist", None)
    if tolist is None:
        raise ModelError(f"the state of the random generator is not data: {type(item).__name__}")
    return tolist()


def _mesh(file: Path) -> bytes:
    data = read_bytes(file)
    if len(data) > LARGEST:
        raise FileFormatError(str(file), f"holds more than {LARGEST >> 20} MB")
    return data


def _json(document: object) -> bytes:
    return json.dumps(one_of("document", document, dict), allow_nan=False).encode()


@checked
def read_bundle(path: Path | str, *, meshes: Path | str | None = None) -> Bundle:
    """Read a bundle.

    Reading runs no code from the file. Verdicts are ignored: `Bundle.judged` verifies the motion.

    Args:
        meshes: Folder for unpacking the visual meshes; None leaves them packed.
    """
    archive = Archive(path)
    about, holds = _about(archive)
    if holds is Holds.MOTIONS:
        raise about["holds"].error(f"is {holds.value}: read it with read_result")
    return _bundle(archive, about, holds, meshes)


def _bundle(archive: Members, about: Node, holds: Holds, meshes: Path | str | None) -> Bundle:
    reader = reader_of(archive, meshes)
    problem = _problem(archive, reader)
    motion = _motion(archive, reader, problem)
    arguments = _arguments(archive, reader)
    try:
        datetime.fromisoformat(about["made"].text())
    except ValueError as error:
        raise about["made"].error("is not a date") from error
    return Bundle(
        path=archive.path,
        holds=holds,
        made=about["made"].text(),
        versions=_texts(about["versions"]),
        problem=problem,
        arguments=arguments,
        method="" if arguments is None else document_in(archive, ARGUMENTS)["planned_by"].text(""),
        custom_method=arguments is not None and document_in(archive, ARGUMENTS)["custom_method"].flag(),
        trajectory=motion.get("trajectory"),
        path_planned=motion.get("path"),
        answer=_plain(archive, ANSWER),
        explanation=_plain(archive, EXPLANATION),
        proof=_stored_proof(archive, problem, motion.get("trajectory")),
    )


def _stored_proof(archive: Members, problem: Problem, trajectory: Trajectory | None) -> MotionProof | None:
    if PROOF not in archive.names:
        return None
    proof = MotionProof(archive.read(PROOF))
    try:
        field = "motion" if trajectory is None else proof.differs_from(problem, trajectory)
    except FileFormatError as error:
        raise archive.error(f"{PROOF} is damaged: {error}") from error
    if field:
        raise archive.error(f"{PROOF} is not a proof of this plan: its {field} differs")
    return proof


@checked
def read_result(path: Path | str, *, meshes: Path | str | None = None) -> Value:
    """Read the result of a task, of a pick and place, or of following a curve; its motions are judged again.

    Args:
        meshes: As in `read_bundle`.

    Raises:
        FileFormatError: If the file is invalid, holds something else, or a motion that is not proven.
    """
    archive = Archive(path)
    about, holds = _about(archive)
    if holds is not Holds.MOTIONS:
        raise about["holds"].error(f"is {holds.value}: read it with read_bundle")
    return _result(archive, meshes)


def read_saved(path: Path | str, *, meshes: Path | str | None = None) -> Bundle | Value:
    """Read a bundle or a result."""
    return saved_of(Archive(path), meshes)


def saved_of(archive: Members, meshes: Path | str | None = None) -> Bundle | Value:
    """Return the bundle or result in members."""
    about, holds = _about(archive)
    return _result(archive, meshes) if holds is Holds.MOTIONS else _bundle(archive, about, holds, meshes)


def _result(archive: Members, meshes: Path | str | None) -> Value:
    node = document_in(archive, VALUE).only(("value", "shared"))
    value = shared_value_of(node, archive.array, lambda name: _file(archive, name, meshes))
    if not isinstance(value, Value):
        raise node["value"].error(f"must be a result, is {shown(value)}")
    if isinstance(value, SavedResult) and value.missing:
        raise node["value"].error(f"has no motion of the stage {shown(value.missing)}")
    return value


def _about(archive: Members) -> tuple[Node, Holds]:
    about = document_in(archive, DESCRIPTION)
    if about["format"].value != FORMAT:
        raise about.error("is not a bundle of trajopt")
    if about["version"].value != VERSION:
        raise about["version"].error(f"is {shown(about['version'].value)}; this trajopt reads {VERSION}")
    _check_digests(archive, about["members"])
    holds = about["holds"].text()
    if holds not in Holds.__members__:
        raise about["holds"].error(f"must be one of {', '.join(Holds.__members__)}, is {shown(holds)}")
    return about, Holds[holds]


def document_in(archive: Members, name: str) -> Node:
    """Return a JSON document among members."""
    place = f"{archive.path}: {name}"
    try:
        text = archive.read(name, most=LARGEST_DOCUMENT).decode()
        refuse_deep_nesting(place, text)
        if text.count(",") > MOST_VALUES:
            raise FileFormatError(place, f"holds more than {MOST_VALUES} values")
        value = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise FileFormatError(place, f"cannot be parsed: {error}") from error
    if not isinstance(value, dict):
        raise FileFormatError(place, "must be a mapping")
    return Node(cast("object", value), place)


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is not a number in JSON")


def _plain(archive: Members, name: str) -> Mapping[str, object]:
    if name not in archive.names:
        return {}
    return cast("dict[str, object]", document_in(archive, name).value)


def _check_digests(archive: Members, members: Node) -> None:
    digests = _texts(members)
    if set(digests) != set(archive.names) - {DESCRIPTION}:
        raise members.error("does not name the members that are there")
    for name, stated in digests.items():
        if digest(archive.read(name)) != stated:
            raise archive.error(f"{name} does not match its digest: the file is damaged")


def _texts(node: Node) -> dict[str, str]:
    inside: object = node.value
    if not isinstance(inside, dict):
        raise node.error("must be a mapping")
    return {key: node[key].text() for key in cast("dict[str, object]", inside)}


def _problem(archive: Members, reader: BundleReader) -> Problem:
    node = document_in(archive, PROBLEM)
    problem = _of_kind(reader, node, Problem)
    try:
        _ = problem.reduced
    except (TrajoptError, ValueError, TypeError, LookupError, AttributeError, ArithmeticError) as error:
        # The values were checked one by one; this checks that they are consistent.
        raise node.error(f"robot and scene do not fit together: {type(error).__name__}: {error}") from error
    return problem


def _of_kind(reader: BundleReader, node: Node, kind: type[Kind]) -> Kind:
    value = reader.value(node)
    if not isinstance(value, kind):
        raise node.error(f"must be a {kind.__name__}, is {shown(value)}")
    return value


def _motion(archive: Members, reader: BundleReader, problem: Problem) -> dict[str, Any]:
    if MOTION not in archive.names:
        return {}
    node = document_in(archive, MOTION).only(("path", "trajectory"))
    found: dict[str, Any] = {}
    for key, kind in (("path", PlannedPath), ("trajectory", Trajectory)):
        if node.has(key):
            found[key] = _of_kind(reader, node[key], kind)
            if found[key].joint_names != problem.reduced.joint_names:
                raise node[key].error("is of other joints than the problem")
    return found


def _arguments(archive: Members, reader: BundleReader) -> PlanArguments | None:
    if ARGUMENTS not in archive.names:
        return None
    node = document_in(archive, ARGUMENTS)
    node.only(_ARGUMENTS)
    random: object = node["random"].value
    if random is not None and not isinstance(random, dict):
        raise node["random"].error("must be a mapping")
    return PlanArguments(
        None if node["method"].missing else node["method"].text(),
        node["improve"].flag(),
        node["every_goal"].flag(),
        _of_kind(reader, node["budget"], Budget),
        cast("dict[str, object] | None", random),
        seeds := tuple(_knots(reader, seed) for seed in node["seeds"].elements()),
        _recalled(node["experience"], seeds),
    )


def _recalled(node: Node, seeds: tuple[Floats, ...]) -> Recalled | None:
    if node.missing:
        return None
    node.only(("version", "memories"))
    numbers = [node["version"], *node["memories"].elements()]
    for each in numbers:
        if type(each.value) is not int or each.value < 0:
            raise each.error("must be a whole number that is not negative")
    version, *memories = (int(cast("int", each.value)) for each in numbers)
    if len(memories) > len(seeds):
        raise node["memories"].error(f"are {len(memories)}, of {len(seeds)} paths")
    return Recalled(version, tuple(memories), seeds[len(seeds) - len(memories) :])


def _knots(reader: BundleReader, node: Node) -> Floats:
    try:
        return floats(node.place, reader.value(node), (None, None))
    except ShapeError as error:
        raise node.error(str(error)) from error


def reader_of(archive: Members, meshes: Path | str | None = None) -> BundleReader:
    return BundleReader(archive.array, lambda name: _file(archive, name, meshes))


def _file(archive: Members, name: str, folder: Path | str | None) -> Path:
    if name not in archive.names:
        return Path(Path(name).name)
    if folder is None:
        return _NO_FOLDER / Path(name).name
    target = Path(folder) / Path(name).name  # member names are plain, so it stays within the folder
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(archive.read(name))
    return target


def value_members(value: object, name: str) -> dict[str, bytes]:
    """Return a value as members."""
    writer = BundleWriter()
    document = {"value": writer.document(value, name)}
    return {VALUE: json.dumps(document, allow_nan=False).encode(), **named_members(writer)}


def value_of(members: Members, meshes: Path | str | None = None) -> Any:
    """Return the value stored in members."""
    return reader_of(members, meshes).value(document_in(members, VALUE)["value"])
