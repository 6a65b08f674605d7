"""Recipes: how a worker makes a problem, of shared documents and a small row of a table."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Protocol, cast

import numpy as np

from trajopt.files.moveit.motion_plan_request import request_of
from trajopt.files.moveit.planning_scene import apply_motions, scene_of
from trajopt.lab.campaign.documents import Library
from trajopt.lab.suite import installed_definitions
from trajopt.optimise.kinematics import random_configurations
from trajopt.problem.problem import Problem
from trajopt.robot.loading.pinocchio_model import placed_model, root_placement
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.cached import LruCache
from trajopt.values.documents.document import parse_document, parse_list
from trajopt.values.errors import CampaignError, ProblemError, shown
from trajopt.values.placement import WORLD, Placement, placement

KEPT = 4
"""Derived scenes and models that a process keeps: the problems of one follow each other."""


class Workshop:
    """The library, with a cache of recent scenes and models."""

    def __init__(self, library: Library) -> None:
        """Begin with nothing made."""
        self.library = library
        self._placed: LruCache[tuple[Scene, tuple[float, ...]], Scene] = LruCache(KEPT)
        self._reduced: LruCache[tuple[Scene, str], ReducedModel] = LruCache(KEPT)

    def reduced(self, scene: Scene, group: str) -> ReducedModel:
        return self._reduced.get(
            (scene, group), lambda: reduce_model(scene, group, scene.robot.positions(None))
        )

    def placed(self, scene: Scene, where: tuple[float, ...]) -> Scene:
        """Return a scene with the base of its robot elsewhere: x, y, z [m] and the turn about z [rad]."""
        return self._placed.get((scene, where), lambda: _with_base_at(scene, where))


class Recipe(Protocol):
    """Recipe of one problem: plain data that identifies the problem."""

    def problem(self, shop: Workshop, /) -> Problem:
        """Make the problem."""
        ...


@dataclass(frozen=True)
class Stated:
    """A problem as it was stated in Python.

    Attributes:
        statement: As `Packer.statement` returned it.
    """

    statement: Mapping[str, Any]

    def problem(self, shop: Workshop, /) -> Problem:
        return shop.library.stated(self.statement)


@dataclass(frozen=True)
class FromMessages:
    """A problem of MoveIt's messages, as texts.

    Attributes:
        name: Name of the problem, also in error messages.
        scene: `PlanningScene` in YAML.
        request: `MotionPlanRequest` in YAML.
        motions: Motions of objects, in YAML; may be empty.
    """

    robot: str
    name: str
    scene: str
    request: str
    motions: str = ""

    def problem(self, shop: Workshop, /) -> Problem:
        robot = shop.library.robot(self.robot)
        around = scene_of(parse_document(self.scene, f"scene of {self.name}"), robot)
        scene = around.scene
        if self.motions:
            scene = apply_motions(parse_list(self.motions, f"motions of {self.name}"), scene)
        asked = request_of(
            parse_document(self.request, f"request of {self.name}"), scene, around.state, around.world_names
        ).problem()
        return replace(asked, name=self.name)


@dataclass(frozen=True)
class JointToJoint:
    """A motion between two configurations in a shared scene.

    Attributes:
        start: Positions of its joints; the others are in the default configuration [rad | m].
        goal: Positions at the end [rad | m].
    """

    scene: str
    group: str
    start: tuple[float, ...]
    goal: tuple[float, ...]

    def problem(self, shop: Workshop, /) -> Problem:
        scene = shop.library.scene(self.scene)
        return _between(scene, self.group, self.start, self.goal, "joint to joint")


@dataclass(frozen=True)
class RandomMotion:
    """A motion between two random free configurations."""

    scene: str
    group: str
    seed: int
    number: int

    def problem(self, shop: Workshop, /) -> Problem:
        scene = shop.library.scene(self.scene)
        rng = np.random.default_rng((self.seed, self.number))
        found = random_configurations(shop.reduced(scene, self.group), 2, rng=rng)
        if len(found.positions) < 2:
            raise ProblemError(f"fewer than two of {found.drawn} random configurations are free")
        start, goal = found.positions.tolist()
        return _between(scene, self.group, start, goal, f"random motion {self.number}")


@dataclass(frozen=True)
class Perturbed:
    """A problem with randomly displaced objects.

    Attributes:
        shift: Largest shift along each axis [m].
        turn: Largest turn about the vertical through the object's origin [rad].
    """

    base: str
    seed: int
    number: int
    shift: float
    turn: float

    def problem(self, shop: Workshop, /) -> Problem:
        base = shop.library.problem(self.base)
        rng, scene = np.random.default_rng((self.seed, self.number)), base.scene
        for name, item in base.scene.objects.items():
            change = rng.uniform(-1.0, 1.0, 4)  # drawn for every object, so that one more changes no other
            if item.frame != WORLD or item.timing.motion is not None:
                continue
            turned = placement(rpy=(0.0, 0.0, self.turn * float(change[3]))).rotation
            here = item.placement
            moved = Placement(turned @ here.rotation, here.translation + self.shift * change[:3])
            scene = scene.move(name, moved)
        return replace(base, scene=scene, name=f"{base.name}, perturbed {self.number}")


@dataclass(frozen=True)
class BasePlaced:
    """A problem with another placement of the robot's base; goals in the world stay.

    Attributes:
        where: Of the robot's root in the world: x, y, z [m] and the turn about z [rad].
    """

    base: str
    where: tuple[float, float, float, float]

    def problem(self, shop: Workshop, /) -> Problem:
        base = shop.library.problem(self.base)
        return replace(base, scene=shop.placed(base.scene, tuple(self.where)))


@dataclass(frozen=True)
class Installed:
    """An instance of an installed problem.

    Attributes:
        draw: 0 for the fixed one, else the number of a random one.
    """

    name: str
    draw: int

    def problem(self, shop: Workshop, /) -> Problem:
        return installed_definitions((self.name,))[0].instance(self.draw).make()


RECIPES: Mapping[str, Callable[..., Recipe]] = {
    kind.__name__: kind
    for kind in (Stated, FromMessages, JointToJoint, RandomMotion, Perturbed, BasePlaced, Installed)
}


def written(recipe: Recipe) -> str:
    stated = asdict(cast("Any", recipe))
    return json.dumps({"recipe": type(recipe).__name__, **stated}, allow_nan=False, separators=(",", ":"))


def read(text: str) -> Recipe:
    """Return the recipe that `written` wrote.

    Raises:
        CampaignError: If it is none.
    """
    stated = cast("dict[str, Any]", json.loads(text))
    kind = RECIPES.get(str(stated.pop("recipe", "")))
    if kind is None:
        raise CampaignError(f"no recipe of a problem: {shown(text)}")
    return kind(**stated)


def _between(scene: Scene, group: str, start: Any, goal: Any, name: str) -> Problem:
    joints = scene.robot.group(group).joints
    if len(start) != len(joints) or len(goal) != len(joints):
        raise ProblemError(f"start and goal must have a position of each of {len(joints)} joints of {group}")
    at, to = (dict(zip(joints, map(float, each), strict=True)) for each in (start, goal))
    return Problem(scene=scene, start=at, goal=to, group=group, name=name)


def _with_base_at(scene: Scene, where: tuple[float, ...]) -> Scene:
    robot = scene.robot
    if robot.base.joints:
        raise ProblemError(f"the base of {robot.name} moves by itself: state its joints at the start")
    x, y, z, yaw = where
    change = placement((x, y, z), rpy=(0.0, 0.0, yaw)) * root_placement(robot.model).inverse()
    return replace(scene, robot=replace(robot, model=placed_model(robot.model, change)))
