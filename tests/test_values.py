"""Everything public that is a value can be pickled and copied, whatever was asked of it before."""

import copy
import gc
import importlib
import inspect
import pickle
import pkgutil
import types
import typing
import weakref
from collections import abc
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from functools import cache, cached_property
from multiprocessing import get_context
from multiprocessing.context import BaseContext
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import ArrayLike

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.optimise.kinematics import inverse_kinematics, self_motion
from trajopt.optimise.methods import method_named
from trajopt.optimise.terms import Cost, soft_clearance
from trajopt.optimise.terms.clearance import MarginRule
from trajopt.optimise.terms.symbolic import SymbolicKinematics
from trajopt.optimise.terms.user_functions import Expression
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.tasks.cartesian import FollowOptions, follow, follows_curve, line
from trajopt.tasks.grasping import gripper_of
from trajopt.tasks.sequence import StageNode
from trajopt.values import errors
from trajopt.values.arrays import Value
from trajopt.values.errors import RenderingUnavailable
from trajopt.values.moved import MOVED
from trajopt.why import explain

WORKSPACES = {
    "AsyncClient", "AsyncSession", "BudgetTracker", "Cancellation", "Client", "CommittedMotion", "Counts",
    "DynamicObstacles", "WorkCounts", "PlanningWorkspace", "ObstacleContacts", "Player",
    "Events", "SessionCalls", "Experience", "Guard", "GuardedArm", "LeRobotController", "StreamingExecutor",
    "FrankaController",
    "UrController",
    "DepthCamera", "Gamepad", "GoalSearch", "IdealExecutor", "Judge", "KnotsNlp", "LiveView", "Logbook",
    "MirrorView", "MoveGroupCommander", "RunPublisher",
    "PlanningSceneInterface", "Played", "Printed", "Query", "Recorder", "RobotCommander", "RunViewer",
    "Search", "Service", "ServiceSession", "Servo", "ServoPage", "Session", "SimulatedExecutor", "Supervisor",
    "SymbolicKinematics", "Timeline", "Value", "Viewer", "Warehouse", "Watch", "Workspace", "World",
}  # fmt: skip
"""Public classes that are no values: they work, count, or show."""


def public_classes() -> list[type]:
    """Classes that `trajopt` and its rooms name."""
    found: dict[type, None] = {}
    rooms = [info.name for info in pkgutil.iter_modules(to.__path__, "trajopt.") if info.ispkg]
    folders = [
        f"trajopt.{new}" for old, new in MOVED.items() if "." not in old and old not in ("errors", "seeds")
    ]
    named = {name: getattr(to, name) for name in dir(to)}
    for module in map(importlib.import_module, {*rooms, *folders} - {"trajopt.native"}):
        named.update({f"{module.__name__}.{name}": item for name, item in vars(module).items()})
    for name, item in named.items():
        ours = inspect.isclass(item) and item.__module__.startswith("trajopt.")
        if ours and not name.rpartition(".")[2].startswith("_"):
            found[item] = None
    return sorted(found, key=lambda kind: (kind.__module__, kind.__name__))


def is_value(kind: type) -> bool:
    return is_dataclass(kind) and kind.__dataclass_params__.frozen  # type: ignore[attr-defined]


VALUES = [kind for kind in public_classes() if is_value(kind) and kind.__name__ not in WORKSPACES]


def test_every_public_class_is_a_value_or_known_not_to_be() -> None:
    for kind in public_classes():
        known = is_value(kind) or issubclass(kind, Enum | Exception) or getattr(kind, "_is_protocol", False)
        assert known or kind.__name__ in WORKSPACES, f"{kind}: a value, or among WORKSPACES?"
    assert len(VALUES) > 80


@pytest.mark.parametrize("kind", VALUES, ids=lambda kind: f"{kind.__module__}.{kind.__name__}")
def test_computed_properties_are_not_part_of_a_value(kind: type) -> None:
    """Each is filled with a sample of every field: a new kind of field needs a sample here."""
    value = KNOWN[kind]() if kind in KNOWN else filled(kind)
    lazy = [name for name, item in inspect.getmembers(kind) if isinstance(item, cached_property)]
    for name in lazy:
        vars(value).setdefault(name, SymbolicKinematics)  # stands for anything; nobody asks for it again
    same(value, pickle.loads(pickle.dumps(value)))
    same(value, copy.deepcopy(value))
    same(value, copy.copy(value))
    cloudpickle = pytest.importorskip("cloudpickle")
    same(value, pickle.loads(cloudpickle.dumps(value)))


def filled(kind: Any) -> Any:
    """Return an instance with a sample in every field, checks left out."""
    hints = typing.get_type_hints(kind, vars(importlib.import_module(kind.__module__)))
    value = object.__new__(kind)
    for item in fields(kind):
        object.__setattr__(value, item.name, sample(hints[item.name], item.name))
    return value


PLAIN: dict[Any, Any] = {
    float: 0.25, int: 3, str: "words", bool: True, object: "anything", Path: Path("a/file"), bytes: b"",
    Any: 1.5, type(None): None, StageNode: StageNode("a stage"),
}  # fmt: skip


def sample(hint: Any, name: str) -> Any:
    """Return something of a declared type."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin is not None and not (inspect.isclass(origin) and is_dataclass(origin)):
        return sample_of_generic(origin, inner, name)
    kind = origin or hint
    if kind in PLAIN:
        return PLAIN[kind]
    if kind in KNOWN:
        return KNOWN[kind]()
    if is_dataclass(kind):
        return filled(kind)
    if isinstance(kind, typing.TypeVar) or getattr(kind, "_is_protocol", False):
        return "anything"
    assert issubclass(kind, Enum), f"field {name}: no sample of {hint}"
    return next(iter(kind))


def sample_of_generic(origin: Any, inner: tuple[Any, ...], name: str) -> Any:
    """Return something of a type with parameters."""
    make: dict[Any, Any] = {
        np.ndarray: read_only,
        typing.Union: lambda: sample(next(item for item in inner if item is not type(None)), name),
        tuple: lambda: tuple(sample(item, name) for item in inner if item is not Ellipsis),
        abc.Sequence: lambda: (sample(inner[0], name),),
        frozenset: lambda: frozenset((sample(inner[0], name),)),
        abc.Mapping: lambda: {sample(inner[0], name): sample(inner[1], name)},
        abc.Callable: lambda: to.load,
        typing.Literal: lambda: inner[0],
        type: lambda: to.Box,
    }
    make |= {types.UnionType: make[typing.Union], dict: make[abc.Mapping], list: make[abc.Sequence]}
    array = typing.get_args(ArrayLike)[0] in inner
    assert array or origin in make, f"field {name}: no sample of {origin}"
    return read_only() if array else make[origin]()


def read_only() -> np.ndarray:
    array = np.arange(6.0).reshape(2, 3)
    array.flags.writeable = False
    return array


def panda() -> to.Robot:
    return _panda()


@cache
def _panda() -> to.Robot:
    return to.load("panda")


@cache
def reduced() -> Any:
    return reduce_model(to.Scene(panda()), "panda_arm", panda().positions("ready"))


@cache
def solved() -> Any:
    return to.plan(problem())


@cache
def problem() -> to.Problem:
    asked = to.named_problem("past_pillar_panda")
    return replace(
        asked,
        costs=[*(asked.costs or ()), soft_clearance(0.02), Cost(Expression("first", first_joint), 0.01)],
    )


def first_joint(kinematics: SymbolicKinematics) -> ca.SX:
    return kinematics.q[0]


KNOWN: dict[Any, Any] = {
    pin.Model: lambda: panda().model,
    to.Robot: panda,
    ReducedModel: reduced,
    to.Trajectory: lambda: solved().trajectory,
    to.optimise.methods.Method: lambda: method_named("sqp"),
    to.optimise.terms.Residual: to.optimise.terms.Velocity,
    to.Result: solved,
    to.optimise.methods.Decoded: lambda: to.optimise.methods.Decoded(solved().path),
    MarginRule: lambda: to.load,  # any function
    to.optimise.solvers.Solver: to.optimise.solvers.Sqp,
    BaseContext: lambda: get_context("spawn"),
    np.random.Generator: lambda: np.random.default_rng(1),
    Expression: lambda: Expression("first", first_joint),
}
"""What is no plain data, and Robot, Trajectory and the reduced model, whose fields depend on each other."""


def same(one: Any, other: Any, seen: set[tuple[int, int]] | None = None) -> None:
    """Assert that two values state the same, that what was read-only is, and nothing else is there."""
    if seen is None:
        extra = set(getattr(other, "__dict__", ())) - {item.name for item in fields(one)}
        assert not extra, "restored with what was computed of it"
        seen = set()
    if one is other or (id(one), id(other)) in seen:
        return
    seen.add((id(one), id(other)))
    assert type(one) is type(other)
    if isinstance(one, float):
        assert one == other or (np.isnan(one) and np.isnan(other))
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype and one.flags.writeable == other.flags.writeable
        np.testing.assert_array_equal(one, other)
    elif (inside := parts(one)) is None:
        assert one == other
    else:
        theirs = parts(other)
        assert theirs is not None and list(inside) == list(theirs)
        for name, part in inside.items():
            same(part, theirs[name], seen)


def parts(value: Any) -> Mapping[Any, Any] | None:
    """Return what a value is made of, by name; None if it can be compared as a whole."""
    if isinstance(value, dict):
        return value
    if isinstance(value, tuple | list):
        return dict(enumerate(value))
    if isinstance(value, ReducedModel):  # made again of its scene
        names = ("scene", "group", "start", "model", "joint_names", "limits", "mimic_matrix", "mimic_offset")
        return {name: getattr(value, name) for name in names} | {
            "bodies": [body.name for body in value.bodies]
        }
    if is_dataclass(value):
        return {item.name: getattr(value, item.name) for item in fields(value)}
    if isinstance(value, np.random.Generator):
        return value.bit_generator.state
    return vars(value) if type(value).__eq__ is object.__eq__ and hasattr(value, "__dict__") else None


def used() -> Iterator[tuple[str, Any]]:
    """Yield values of every room that were used before."""
    result = solved()
    assert result.verified
    yield "problem", problem()
    yield "result", result
    yield "plan", result.require()
    refused = to.plan(to.named_problem("start_in_collision"))
    yield "failure", refused
    yield "explanation", explain(refused)
    yield "gripper", gripper_of(panda())
    at = to.Scene(panda()).placement_of("panda_hand_tcp", panda().positions("ready"))
    goal = to.frame_placement("panda_hand_tcp", at)
    yield "goal set", to.any_of({"one": goal, "other": to.joint_positions({"panda_joint1": 0.1})})
    yield "inverse kinematics", inverse_kinematics(reduced(), goal, starts=4)
    yield "self-motion", self_motion(reduced(), goal, panda().positions("ready")[:7])
    way = line(at, to.placement(at.translation + np.array((0, 0, 0.02)), rotation=at.rotation))
    followed = follow(
        to.Scene(panda()), follows_curve("panda_hand_tcp", way), start="ready", group="panda_arm",
        options=FollowOptions(),
    )  # fmt: skip
    yield "followed", followed
    for name in ("sqp", "chomp", "stomp", "bspline", "free-duration"):
        yield name, method_named(name)
    yield "budget", to.Budget(work=10, workers=2)


def test_values_that_were_used_are_pickled_as_new_ones() -> None:
    for name, value in used():
        restored = pickle.loads(pickle.dumps(value))
        same(value, restored), name
        same(value, copy.deepcopy(value)), name
        same(value, copy.copy(value)), name


def test_caches_are_not_dragged_along() -> None:
    asked = to.named_problem("past_pillar_panda")
    before = len(pickle.dumps(asked))
    result = to.plan(asked)
    assert len(pickle.dumps(asked)) == before
    assert len(pickle.dumps(result.problem)) == before
    for part in (asked.scene, asked.scene.robot, asked.reduced):
        assert len(pickle.dumps(part)) <= before + 100
    again = pickle.loads(pickle.dumps(asked))
    assert np.array_equal(to.plan(again).require().path.knots, result.require().path.knots)


def planned_and_left() -> "weakref.ref[to.Scene]":
    """Plan with a term of one's own that knows its scene; return only whether the scene is still there."""
    asked = to.named_problem("past_pillar_panda")
    scene = asked.scene.remove("pillar")
    own = Cost(Expression("own", lambda kinematics: kinematics.q[0] * scene.margin), 0.01)
    result = to.plan(replace(asked, scene=scene, costs=[own]), budget=to.Budget(attempts=1))
    assert result.path is not None
    return weakref.ref(scene)


def test_derived_data_is_freed_with_its_value() -> None:
    gone = planned_and_left()
    gc.collect()
    assert gone() is None


def test_models_with_infinite_limits(tmp_path: Path) -> None:
    robot = odd_arm(tmp_path)
    robot.model.effortLimit = np.full(robot.model.nv, np.inf)
    restored = pickle.loads(pickle.dumps(robot))
    assert restored.model == robot.model
    for name in dir(robot.model):
        mine = getattr(robot.model, name)
        if isinstance(mine, np.ndarray):
            np.testing.assert_array_equal(getattr(restored.model, name), mine)


RAISED = [
    errors.FrameNotFound("frame", "a", ["b", "c"]), errors.ShapeError("x", "is bad"),
    errors.SizeError("x", "y"),
    errors.MeshFileError("p", "r"), errors.GripperError("r", "w"), errors.FileFormatError("p", "r"),
    errors.UnsupportedJoint("j", "planar"), errors.SolverNotFound("solver", "a", ["b"]),
    errors.MissingExtra("viser", "view"), errors.PlanningFailed("why", "result"), errors.DuplicateObject("a"),
    errors.ProblemError("message"), errors.BackendFailed("message"),
    RenderingUnavailable(["egl: none"]),
]  # fmt: skip


@pytest.mark.parametrize("error", RAISED, ids=lambda error: type(error).__name__)
def test_errors_are_pickled_whole(error: Exception) -> None:
    for restored in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(restored) is type(error) and str(restored) == str(error)
        assert vars(restored) == vars(error) and restored.args == error.args


def test_lazy_values_are_values() -> None:
    """Whoever keeps what it computed must leave it out of its pickles."""
    for kind in VALUES:
        lazy = [name for name, item in vars(kind).items() if isinstance(item, cached_property)]
        assert not lazy or issubclass(kind, Value), kind
