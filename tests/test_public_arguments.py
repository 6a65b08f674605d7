"""Every public function, class and method, found by looking: wrong kinds of arguments are refused by name.

What is added to a room is covered without a line here, but for a sample of an argument of a new name.
"""

import enum
import importlib
import inspect
from collections.abc import Callable, Iterator

import numpy as np
import pytest

import trajopt as to
from tests.public_samples import ALONG, CALLED_BY_SOLVERS, INNER, OPEN, RETURNED, instances, sample
from trajopt.values.errors.arguments import Kinds

ROOMS = (
    "trajopt", "trajopt.robot.bases", "trajopt.tasks.cartesian", "trajopt.tasks.grasping",
    "trajopt.files.export", "trajopt.optimise.kinematics", "trajopt.files.moveit",
    "trajopt.optimise.methods", "trajopt.optimise.solvers",
    "trajopt.optimise.transcription", "trajopt.optimise.terms", "trajopt.timing", "trajopt.verify",
    "trajopt.simulation", "trajopt.viewer", "trajopt.why", "trajopt.lab.suite", "trajopt.lab.srdf",
    "trajopt.planning", "trajopt.driving", "trajopt.lab.perception", "trajopt.server.warehouse",
    "trajopt.lab.campaign", "trajopt.server.client", "trajopt.server",
    "trajopt.viewer.report", "trajopt.planning.experience", "trajopt.lab.reach",
)  # fmt: skip
"""Rooms whose names are for callers."""
CLASSES: dict[str, type[object]] = {}
Found = tuple[str, Callable[..., object]]


def found() -> Iterator[Found]:
    """Yield each public function, class and method once, by its name."""
    seen: set[int] = set()
    for room in map(importlib.import_module, ROOMS):
        names = to.__all__ if room is to else vars(room)
        for name in sorted(names):
            value = getattr(room, name)
            home = getattr(value, "__module__", "")
            own = home.startswith("trajopt") and not home.startswith(
                ("trajopt.values.arrays", "trajopt.values.errors")
            )
            helper = not hasattr(room, "__path__") and home != room.__name__
            if name.startswith("_") or not callable(value) or not own or helper or id(value) in seen:
                continue
            seen.add(id(value))
            if not inspect.isclass(value):
                yield name, value
            elif not issubclass(value, enum.Enum | Exception) and not getattr(value, "_is_protocol", False):
                yield from of_class(name, value)


def of_class(name: str, kind: type[object]) -> Iterator[Found]:
    CLASSES[name] = kind
    if name not in RETURNED:
        yield name, kind
    for method in vars(kind):
        value = inspect.getattr_static(kind, method)
        if (method.startswith("_") and method != "__call__") or not (
            inspect.isfunction(value) or isinstance(value, staticmethod | classmethod)
        ):
            continue
        if isinstance(value, staticmethod | classmethod):
            yield f"{name}.{method}", getattr(kind, method)
        elif len(inspect.signature(value).parameters) > 1:
            yield f"{name}.{method}", value


def tried(name: str) -> bool:
    owner, _, method = name.partition(".")
    return owner not in INNER and name not in INNER and method not in CALLED_BY_SOLVERS


PUBLIC: dict[str, Callable[..., object]] = {name: call for name, call in found() if tried(name)}


def wrong(annotation: object) -> Iterator[tuple[str, object]]:
    """Yield values that are of none of the kinds that an annotation allows."""
    words = str(annotation)
    yield "an object", object()
    if "None" not in words:
        yield "None", None
    if not any(kind in words for kind in ("str", "Path", "numpy", "GoalLike")):
        yield "a text", "elbo"
    if not any(kind in words for kind in ("Mapping", "dict", "Iterable", "Collection")):
        yield "a mapping", {"a": 1}
    if not any(
        kind in words
        for kind in ("Sequence", "Iterable", "numpy", "tuple", "list", "frozenset", "Collection")
    ):
        yield "a list", [1.0, 2.0]
    if "float" in words and "numpy" not in words and "Callable" not in words and "Mapping" not in words:
        yield "not a number", np.nan


def parameters(call: Callable[..., object]) -> list[inspect.Parameter]:
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return [item for item in inspect.signature(call).parameters.values() if item.kind in kinds]


@pytest.mark.parametrize("name", PUBLIC)
@pytest.mark.timeout(120)
def test_an_argument_of_the_wrong_kind_is_refused_by_its_name(name: str) -> None:
    call = PUBLIC[name]
    fits = Kinds(call)
    taken = parameters(call)
    at_hand = {
        item.name: sample(name, item.replace(annotation=fits[item.name][1]), fits[item.name][0])
        for item in taken
        if item.default is inspect.Parameter.empty and item.name != "self"
    }
    if taken and taken[0].name == "self":
        owner = name.partition(".")[0]
        at_hand["self"] = instances().get(owner) or object.__new__(CLASSES[owner])
    in_order = [
        item.name for item in taken if item.kind is item.POSITIONAL_OR_KEYWORD and item.name in at_hand
    ]
    for item in taken:
        if item.name == "self" or f"{name}.{item.name}" in OPEN:
            continue
        for kind, value in wrong(fits[item.name][1]):
            where = f"{name}({item.name}={kind})"
            try:
                by_name = {**at_hand, **ALONG.get(name, {}), item.name: value}
                first = [by_name.pop(each) for each in in_order if each in by_name]
                call(*first, **by_name)
            except to.TrajoptError as error:
                words = (item.name, item.name.replace("_", " "))
                assert any(word in str(error) for word in words), f"{where}: {error} does not name it"
                assert len(str(error)) <= 400, where
            except Exception as error:
                pytest.fail(f"{where}: a raw {type(error).__name__}: {str(error)[:200]}")
            else:
                pytest.fail(f"{where}: taken")
