"""Motion planning for robot arms by optimisation, with a proof of every requirement.

The short way: a robot, a scene, a problem, `plan`; then `explain`, `simulate`, `view` and `render`. The steps
of `plan` are in `trajopt.planning`, `trajopt.optimise`, `trajopt.timing` and `trajopt.verify`.

A name is imported when it is first used, so that a part of the package, such as the judge, loads alone.
"""

import warnings as _warnings
from collections.abc import Mapping as _Mapping
from importlib import import_module as _import_module
from importlib.util import find_spec as _find_spec
from typing import TYPE_CHECKING as _TYPE_CHECKING

# Here, so that a missing core is an error of the first import.
import trajopt.native as _native  # noqa: F401  # pyright: ignore[reportUnusedImport]
from trajopt.values.moved import new_name as _new_name
from trajopt.values.moved import watch_imports as _watch_imports

with _warnings.catch_warnings():
    # pinocchio 3.8 imports `hppfcl`, Coal's old name. With `-W error` that would be an error of ours.
    _warnings.filterwarnings("ignore", "Please update your 'hppfcl' imports", DeprecationWarning)
    _import_module("pinocchio")

if _TYPE_CHECKING:
    from trajopt import verify as verify
    from trajopt.lab import suite as suite
    from trajopt.lab.suite import compare as compare
    from trajopt.optimise.kinematics import goal_configurations as goal_configurations
    from trajopt.optimise.terms import Constraint as Constraint
    from trajopt.optimise.terms import Cost as Cost
    from trajopt.planning.attempt import plan_once as plan_once
    from trajopt.planning.budget import Budget as Budget
    from trajopt.planning.judgement import judge as judge
    from trajopt.planning.many import plan_many as plan_many
    from trajopt.planning.plan import plan as plan
    from trajopt.planning.result import Plan as Plan
    from trajopt.planning.result import Result as Result
    from trajopt.planning.result import Status as Status
    from trajopt.problem.problem import Problem as Problem
    from trajopt.problem.problem import named_problem as named_problem
    from trajopt.problem.requirements import *  # every kind is named there
    from trajopt.problem.tool_speed import tool_speed as tool_speed
    from trajopt.robot import bases as bases
    from trajopt.robot.bodies import MeshPolicy as MeshPolicy
    from trajopt.robot.load import load as load
    from trajopt.robot.robot import Robot as Robot
    from trajopt.scene.scene import Scene as Scene
    from trajopt.scene.track import Prediction as Prediction
    from trajopt.scene.track import Track as Track
    from trajopt.simulation import render as render
    from trajopt.simulation import simulate as simulate
    from trajopt.tasks.cartesian import follow as follow
    from trajopt.tasks.grasping import pick_and_place as pick_and_place
    from trajopt.tasks.task import Task as Task
    from trajopt.values import errors as errors
    from trajopt.values.errors import MissingExtra as MissingExtra
    from trajopt.values.errors import TrajoptError as TrajoptError
    from trajopt.values.placement import Placement as Placement
    from trajopt.values.placement import placement as placement
    from trajopt.values.shapes.clouds import Points as Points
    from trajopt.values.shapes.clouds import Voxels as Voxels
    from trajopt.values.shapes.mesh import Mesh as Mesh
    from trajopt.values.shapes.mesh import load_mesh as load_mesh
    from trajopt.values.shapes.shapes import Box as Box
    from trajopt.values.shapes.shapes import Capsule as Capsule
    from trajopt.values.shapes.shapes import Cone as Cone
    from trajopt.values.shapes.shapes import Cylinder as Cylinder
    from trajopt.values.shapes.shapes import Plane as Plane
    from trajopt.values.shapes.shapes import Sphere as Sphere
    from trajopt.values.shapes.shapes import convex as convex
    from trajopt.values.trajectory import Path as Path
    from trajopt.values.trajectory import Trajectory as Trajectory
    from trajopt.verify import examine as examine
    from trajopt.verify.certificate import Certificate as Certificate
    from trajopt.viewer import view as view
    from trajopt.why import explain as explain

_NAMES_OF: _Mapping[str, str] = {
    "lab.suite": "compare",
    "optimise.kinematics": "goal_configurations",
    "optimise.terms": "Constraint Cost",
    "planning.attempt": "plan_once",
    "planning.budget": "Budget",
    "planning.judgement": "judge",
    "planning.many": "plan_many",
    "planning.plan": "plan",
    "planning.result": "Plan Result Status",
    "problem.problem": "Problem named_problem",
    "problem.tool_speed": "tool_speed",
    "robot.bodies": "MeshPolicy",
    "robot.load": "load",
    "robot.robot": "Robot",
    "scene.scene": "Scene",
    "scene.track": "Prediction Track",
    "simulation": "render simulate",
    "tasks.cartesian": "follow",
    "tasks.grasping": "pick_and_place",
    "tasks.task": "Task",
    "values.errors": "MissingExtra TrajoptError",
    "values.placement": "Placement placement",
    "values.shapes.clouds": "Points Voxels",
    "values.shapes.mesh": "Mesh load_mesh",
    "values.shapes.shapes": "Box Capsule Cone Cylinder Plane Sphere convex",
    "values.trajectory": "Path Trajectory",
    "verify": "examine",
    "verify.certificate": "Certificate",
    "viewer": "view",
    "why": "explain",
}
"""Module -> the public names that it defines; `trajopt.problem.requirements` lists its own."""

_HOME = {name: f"trajopt.{module}" for module, names in _NAMES_OF.items() for name in names.split()}
_REQUIREMENTS = "trajopt.problem.requirements"
_MODULES: _Mapping[str, str] = {
    "bases": "trajopt.robot.bases",
    "errors": "trajopt.values.errors",
    "suite": "trajopt.lab.suite",
}
"""Public name -> the module that it is."""


def _imported(name: str) -> object:
    """Return what a public name stands for.

    Raises:
        AttributeError: If there is no such name, or it has another name now.
    """
    found: object
    if name == "__all__":
        found = [*_MODULES, *_HOME, *_import_module(_REQUIREMENTS).__all__]
    elif name in _HOME:
        found = getattr(_import_module(_HOME[name]), name)
        if name == "Problem":  # whoever states a problem plans it: the planner loads now, not within the plan
            _import_module(_HOME["plan"])
    elif name in _MODULES:
        found = _import_module(_MODULES[name])
    elif (new := _new_name(f"trajopt.{name}")) is not None:
        raise AttributeError(f"trajopt.{name} is now {new}")
    elif name in _import_module(_REQUIREMENTS).__all__:
        found = getattr(_import_module(_REQUIREMENTS), name)
    elif not name.startswith("_") and _find_spec(f"trajopt.{name}") is not None:
        found = _import_module(f"trajopt.{name}")
    else:
        raise AttributeError(f"module 'trajopt' has no attribute {name!r}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    names: list[str] = [*globals(), *_MODULES, *_HOME, *_import_module(_REQUIREMENTS).__all__]
    return sorted(set(names))


if not _TYPE_CHECKING:  # type checkers know the names from the imports above
    __getattr__ = _imported

_watch_imports()
