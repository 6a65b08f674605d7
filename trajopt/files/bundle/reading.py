"""Read bundles from any sender, written by this or an earlier version."""

import json
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any, TypeVar, cast

from trajopt.files.bundle.archive import Archive
from trajopt.files.bundle.bundle import (
    ANSWER,
    ARGUMENTS,
    DESCRIPTION,
    EXPLANATION,
    FORMAT,
    MOTION,
    PROBLEM,
    VERSION,
    Bundle,
    Holds,
)
from trajopt.files.bundle.from_document import Reader
from trajopt.files.bundle.members import LARGEST_DOCUMENT, Members, digest
from trajopt.planning.budget import Budget
from trajopt.planning.plan_arguments import PlanArguments, Recalled
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, floats
from trajopt.values.documents.document import Node
from trajopt.values.documents.files import refuse_deep_nesting
from trajopt.values.errors import FileFormatError, ShapeError, TrajoptError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Path as PlannedPath
from trajopt.values.trajectory import Trajectory

Kind = TypeVar("Kind")
_ARGUMENTS = (
    *("method", "improve", "every_goal", "seeds", "experience", "budget", "random", "planned_by"),
    "custom_method",
)
MOST_VALUES = 500_000
"""Largest number of values in a document; ten thousand boxes in a scene have about 350,000."""
_NO_FOLDER = Path("/nonexistent")  # placeholder for meshes that were not unpacked


@checked
def read_bundle(path: Path | str, *, meshes: Path | str | None = None) -> Bundle:
    """Read a bundle.

    Reading creates only data and runs no code from the file. Any verdict in the file is ignored until the
    motion is verified again (`Bundle.judged`).

    Args:
        path: The file.
        meshes: Folder for unpacking the visual meshes; None leaves them packed.

    Raises:
        FileFormatError: If the file is missing, damaged, too large, incomplete, or newer than this version of
            trajopt.
    """
    return bundle_of(Archive(path), meshes)


def bundle_of(archive: Members, meshes: Path | str | None = None) -> Bundle:
    """Return the bundle stored in members; see `read_bundle`.

    Raises:
        FileFormatError: If the members are incomplete or malformed.
    """
    about = document_in(archive, DESCRIPTION)
    if about["format"].value != FORMAT:
        raise about.error("is not a bundle of trajopt")
    if about["version"].value != VERSION:
        raise about["version"].error(f"is {shown(about['version'].value)}; this trajopt reads {VERSION}")
    _check_digests(archive, about["members"])
    reader = reader_of(archive, meshes)
    holds, problem = about["holds"].text(), _problem(archive, reader)
    if holds not in Holds.__members__:
        raise about["holds"].error(f"must be one of {', '.join(Holds.__members__)}, is {shown(holds)}")
    motion = _motion(archive, reader, problem)
    arguments = _arguments(archive, reader)
    try:
        datetime.fromisoformat(about["made"].text())
    except ValueError as error:
        raise about["made"].error("is not a date") from error
    return Bundle(
        path=archive.path,
        holds=Holds[holds],
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
    )


def document_in(archive: Members, name: str) -> Node:
    """Return a JSON document among members.

    Raises:
        FileFormatError: If it is missing, too large, nested too deeply, not JSON, or not a mapping.
    """
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
    """Check every member against its stored digest.

    This detects damage, not malice: an attacker can change the digest too.
    """
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


def _problem(archive: Members, reader: Reader) -> Problem:
    """Return the problem, after checking that its robot is valid."""
    node = document_in(archive, PROBLEM)
    problem = _of_kind(reader, node, Problem)
    try:
        _ = problem.reduced
    except (TrajoptError, ValueError, TypeError, LookupError, AttributeError, ArithmeticError) as error:
        # The values were checked one by one; this checks that they are consistent.
        raise node.error(f"robot and scene do not fit together: {type(error).__name__}: {error}") from error
    return problem


def _of_kind(reader: Reader, node: Node, kind: type[Kind]) -> Kind:
    value = reader.value(node)
    if not isinstance(value, kind):
        raise node.error(f"must be a {kind.__name__}, is {shown(value)}")
    return value


def _motion(archive: Members, reader: Reader, problem: Problem) -> dict[str, Any]:
    """Return path and trajectory of the problem's joints, if present."""
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


def _arguments(archive: Members, reader: Reader) -> PlanArguments | None:
    """Return the arguments of the planning call; None if absent."""
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
    """Return the recalled experience; its paths are the last of the seeds."""
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


def _knots(reader: Reader, node: Node) -> Floats:
    try:
        return floats(node.place, reader.value(node), (None, None))
    except ShapeError as error:
        raise node.error(str(error)) from error


def reader_of(archive: Members, meshes: Path | str | None = None) -> Reader:
    """Return a reader of documents whose arrays and meshes are members.

    Args:
        archive: The members.
        meshes: As in `read_bundle`.
    """
    return Reader(archive.array, lambda name: _file(archive, name, meshes))


def _file(archive: Members, name: str, folder: Path | str | None) -> Path:
    """Return the path of a mesh, unpacked if a folder is given; for other files the name."""
    if name not in archive.names:
        return Path(Path(name).name)
    if folder is None:
        return _NO_FOLDER / Path(name).name
    target = Path(folder) / Path(name).name  # member names are plain, so it stays within the folder
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(archive.read(name))
    return target
