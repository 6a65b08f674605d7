"""The words of the Python API as JSON: `{"frame_placement": {"frame": "tool0", "placement": {...}}}`.

A mapping of a function's name to its arguments represents its result; lists represent tuples, and placements
have the arguments of `placement`.
"""

import inspect
from collections.abc import Callable, Mapping
from enum import Enum
from functools import cache
from typing import Any, cast, get_type_hints

from trajopt.problem import requirements
from trajopt.problem.tool_speed import tool_speed
from trajopt.scene.track import Prediction, Track
from trajopt.tasks.cartesian import arc_about, arc_through, circle, line, polyline, spline
from trajopt.values.documents.document import Node
from trajopt.values.errors import shown
from trajopt.values.placement import placement
from trajopt.values.shapes.clouds import Points, Voxels
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Cylinder, Plane, Sphere, convex

PLACEMENT_FIELDS = frozenset(inspect.signature(placement).parameters)


SHAPES: Mapping[str, Callable[..., object]] = {
    "box": Box,
    "sphere": Sphere,
    "cylinder": Cylinder,
    "capsule": Capsule,
    "cone": Cone,
    "plane": Plane,
    "convex": convex,
    "mesh": Mesh,
    "points": Points,
    "voxels": Voxels,
}
_STATED = (name for name in requirements.__all__ if name[0].islower())
WORDS: Mapping[str, Callable[..., object]] = {
    **{name: cast("Callable[..., object]", getattr(requirements, name)) for name in _STATED},
    "tool_speed": tool_speed,
    "placement": placement,
    **SHAPES,
    "line": line,
    "polyline": polyline,
    "arc_about": arc_about,
    "arc_through": arc_through,
    "circle": circle,
    "spline": spline,
    "track": Track.through,
    "prediction": Prediction,
}


def value_of(node: Node) -> Any:
    """Return the value of a part of a request."""
    value = node.value
    if isinstance(value, list):
        return tuple(value_of(element) for element in node.elements())
    if not isinstance(value, dict):
        return value
    members = cast("dict[str, object]", value)
    if members and members.keys() <= PLACEMENT_FIELDS:
        return called(placement, node)
    if len(members) == 1:
        word, inside = next(iter(members.items()))
        if word in WORDS and isinstance(inside, dict):
            return called(WORDS[word], node[word])
    return {key: value_of(node[key]) for key in members}


def called(function: Callable[..., Any], node: Node, **given: object) -> Any:
    """Call a function with the arguments that a mapping has."""
    known, names = _signature(function), _hints(function)
    arguments = {key: value_of(node[key]) for key in node.only(known.parameters.keys() - {"self"}).keys()}
    arguments = {**given, **arguments}
    for name, kind in names.items():
        value = arguments.get(name)
        if isinstance(value, str) and inspect.isclass(kind) and issubclass(kind, Enum):
            arguments[name] = _member(kind, node[name])
    try:
        bound = known.bind(**arguments)
    except TypeError as error:
        raise node.error(str(error)) from error
    return function(*bound.args, **bound.kwargs)


def _member(kind: type[Enum], node: Node) -> Enum:
    name = node.text()
    if name not in kind.__members__:
        raise node.error(f"unknown {shown(name)}; known: {', '.join(kind.__members__)}")
    return kind[name]


@cache
def _signature(function: Callable[..., Any]) -> inspect.Signature:
    return inspect.signature(function)


@cache
def _hints(function: Callable[..., Any]) -> Mapping[str, Any]:
    made: Any = function.__init__ if inspect.isclass(function) else function
    return get_type_hints(made)
