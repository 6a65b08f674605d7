"""Write a problem, a plan or a result as a bundle."""

import json
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from trajopt.files.bundle.archive import write_archive
from trajopt.files.bundle.bundle import (
    ANSWER,
    ARGUMENTS,
    DESCRIPTION,
    EXPLANATION,
    FORMAT,
    MOTION,
    PROBLEM,
    URDF,
    VERSION,
    Holds,
)
from trajopt.files.bundle.members import LARGEST, array_bytes, digest
from trajopt.files.bundle.to_document import Writer
from trajopt.planning.budget import Budget
from trajopt.planning.result import Plan, Result
from trajopt.problem.problem import Problem
from trajopt.values.arrays import one_of
from trajopt.values.documents.files import read_bytes
from trajopt.values.errors import FileFormatError, ModelError
from trajopt.values.errors.arguments import checked

_PACKAGES = ("numpy", "pin", "coal", "casadi", "osqp", "mujoco", "scipy")


@checked
def save(what: Result | Plan | Problem, path: Path | str, *, explained: bool = True) -> None:
    """Write a result, a plan or a problem as a bundle.

    Visual meshes are included, so that a machine without the robot's files can display it.

    Args:
        what: A result (success or failure), a plan, or a problem.
        path: The file, by convention with the extension ".trajopt".
        explained: Whether to include the explanation of a failure (`Result.explain`), which may take seconds.

    Raises:
        ModelError: If the problem contains code of the caller, which a file cannot hold.
        FileFormatError: If the file cannot be written, or a mesh of the robot cannot be read.
    """
    write_archive(path, bundle_members(what, explained=explained))


def bundle_members(what: Result | Plan | Problem, *, explained: bool = True) -> dict[str, bytes]:
    """Return the members of a bundle by name; see `save`.

    Raises:
        ModelError: If the problem contains code of the caller.
        FileFormatError: If a mesh of the robot cannot be read.
    """
    writer, members = Writer(), dict[str, bytes]()
    problem = what if isinstance(what, Problem) else what.problem
    members[PROBLEM] = _json(writer.document(problem, "problem"))
    if not isinstance(what, Problem):
        members |= _answer(writer, what)
    if isinstance(what, Result):
        members |= _arguments(writer, what)
        if explained and not what.verified:
            members[EXPLANATION] = _json(what.explain().as_dict())
    if problem.scene.robot.urdf_xml.lstrip().startswith("<"):
        members[URDF] = problem.scene.robot.urdf_xml.encode()
    members |= named_members(writer)
    described: dict[str, object] = {
        "format": FORMAT,
        "version": VERSION,
        "holds": _holds(what).name,
        "name": problem.name,
        "made": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": versions(),
        "members": {name: digest(data) for name, data in members.items()},
    }
    return {DESCRIPTION: _json(described), **members}


def named_members(writer: Writer) -> dict[str, bytes]:
    """Return the arrays and meshes named in documents.

    Raises:
        FileFormatError: If a mesh cannot be read.
    """
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


def _answer(writer: Writer, what: Result | Plan) -> dict[str, bytes]:
    """Return the result and the motion as planned."""
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


def _arguments(writer: Writer, result: Result) -> dict[str, bytes]:
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
        None if arguments.random is None else json.loads(json.dumps(arguments.random, default=_plain))
    )
    return {ARGUMENTS: _json({**document, "planned_by": result.method, "custom_method": own})}


def _plain(item: object) -> object:
    """Return the state of a random generator as JSON data: arrays become lists of integers."""
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
