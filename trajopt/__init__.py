"""Motion planning for robot arms by optimisation, with a proof of what was asked.

The short way is here: a robot, a scene, a problem, `plan`; then `explain`, `simulate`, `view` and `render`
take the result. The steps that `plan` is made of are in `trajopt.planning`, `trajopt.transcription`,
`trajopt.solvers`, `trajopt.retime` and `trajopt.verify`. `trajopt.simulate` and `trajopt.view` are functions
here and packages to import from; `bases` says how a robot's base moves.

What planning needs is imported with this package, everything else when its name is first used.
"""

import sys as _sys
from collections.abc import Mapping as _Mapping
from importlib import import_module as _import_module
from importlib.util import find_spec as _find_spec
from types import ModuleType as _ModuleType
from typing import TYPE_CHECKING as _TYPE_CHECKING

# Before anything else that imports pinocchio.
import trajopt.io.kinematics_library as _kinematics_library  # noqa: F401  # pyright: ignore[reportUnusedImport]
from trajopt.errors import MissingExtra as MissingExtra
from trajopt.errors import TrajoptError as TrajoptError
from trajopt.kinematics import goal_configurations as goal_configurations
from trajopt.model import bases as bases
from trajopt.model.clouds.points import Points as Points
from trajopt.model.clouds.voxels import Voxels as Voxels
from trajopt.model.load import load as load
from trajopt.model.meshes.mesh_cover import MeshPolicy as MeshPolicy
from trajopt.model.meshes.mesh_file import load_mesh as load_mesh
from trajopt.model.placement import Placement as Placement
from trajopt.model.placement import placement as placement
from trajopt.model.requirements import *  # every kind is named there
from trajopt.model.robot import Robot as Robot
from trajopt.model.scene import Scene as Scene
from trajopt.model.shapes import Box as Box
from trajopt.model.shapes import Capsule as Capsule
from trajopt.model.shapes import Cone as Cone
from trajopt.model.shapes import Cylinder as Cylinder
from trajopt.model.shapes import Plane as Plane
from trajopt.model.shapes import Sphere as Sphere
from trajopt.model.shapes import convex as convex
from trajopt.model.tool_speed import tool_speed as tool_speed
from trajopt.model.track import Prediction as Prediction
from trajopt.model.track import Track as Track
from trajopt.model.trajectory import Trajectory as Trajectory
from trajopt.planning.attempt import plan_once as plan_once
from trajopt.planning.budget import Budget as Budget
from trajopt.planning.judgement import judge as judge
from trajopt.planning.many import plan_many as plan_many
from trajopt.planning.plan import plan as plan
from trajopt.planning.result import Result as Result
from trajopt.planning.result import Status as Status
from trajopt.problem import Problem as Problem
from trajopt.problem import named_problem as named_problem
from trajopt.terms import Constraint as Constraint
from trajopt.terms import Cost as Cost
from trajopt.verify import examine as examine

if _TYPE_CHECKING:
    from trajopt import benchmark as benchmark
    from trajopt import verify as verify
    from trajopt.benchmark import compare as compare
    from trajopt.cartesian import follow as follow
    from trajopt.explanation import explain as explain
    from trajopt.grasping import pick_and_place as pick_and_place
    from trajopt.simulate import render as render
    from trajopt.simulate import simulate as simulate
    from trajopt.view import view as view

_LATER: _Mapping[str, str] = {
    "compare": "trajopt.benchmark",
    "follow": "trajopt.cartesian",
    "explain": "trajopt.explanation",
    "pick_and_place": "trajopt.grasping",
    "render": "trajopt.simulate",
    "simulate": "trajopt.simulate",
    "view": "trajopt.view",
}
"""Names that planning does not need, and where they are defined."""


class _Package(_ModuleType):
    """This package, whose other names, and rooms, are imported when they are first asked for."""

    def __getattr__(self, name: str) -> object:
        if name in _LATER:
            found: object = getattr(_import_module(_LATER[name]), name)
        elif not name.startswith("_") and _find_spec(f"{self.__name__}.{name}") is not None:
            found = _import_module(f"{self.__name__}.{name}")
        else:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        setattr(self, name, found)
        return found

    def __setattr__(self, name: str, value: object) -> None:
        # Python puts a room under its name here once it is imported; but `simulate` and `view` are functions.
        if not (name in _LATER and isinstance(value, _ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *_LATER})


_sys.modules[__name__].__class__ = _Package
