"""Every public function with every argument spoilt in turn: a typed error in words, or a sound answer."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Event

import numpy as np
import pytest

import trajopt as to
from tests.problem.requirements.kind import kinds
from tests.robot.test_robot import tetrahedron
from trajopt.optimise.solvers import Effort
from trajopt.optimise.terms import Velocity
from trajopt.simulation import Layout, SimulationOptions
from trajopt.tasks import MoveTo
from trajopt.tasks.cartesian import FollowOptions, polyline
from trajopt.tasks.grasping import GraspingOptions, Place, grasps_of, gripper_of

JUNK: tuple[object, ...] = (
    None, float("nan"), float("inf"), -1, 0, "no such thing", "", b"bytes", [], {}, (), object(), 3 + 1j,
    [float("nan")] * 3, [1, 2], ["a", "b", "c"], np.full((3, 3), np.nan), np.zeros((0, 3)), [[1], [2, 3]],
    True,
)  # fmt: skip
TIP = "panda_hand_tcp"


@dataclass(frozen=True, eq=False)
class Sound:
    """A call that is sound.

    Attributes:
        function: What is called.
        given: Its arguments, by name.
    """

    function: Callable[..., object]
    given: Mapping[str, object]


def calls(folder: Path) -> dict[str, Sound]:
    robot = to.load("panda")
    scene = to.Scene(robot).add("box", to.Box(0.1, 0.1, 0.1), to.placement((0.6, 0.0, 0.3)))
    there = to.placement((0.4, 0.0, 0.4), rpy=(np.pi, 0.0, 0.0))
    problem = to.Problem(scene=scene, group="panda_arm", start="ready", goal=to.frame_placement(TIP, there))
    ready = problem.reduced.start_positions
    motion = to.Trajectory(problem.reduced.joint_names, np.array((0.0, 1.0)), np.stack((ready, ready)))
    (folder / "one.stl").write_text(tetrahedron())
    point, axis = (0.1, 0.0, 0.2), (0.0, 0.0, 1.0)
    still = to.Track.constant_velocity(there, point)
    return {
        **steps_of_a_motion(folder),
        **taking(),
        "Constraint": Sound(
            to.Constraint,
            {
                "residual": Velocity(),
                "lower": np.zeros(1),
                "upper": np.ones(1),
                "tolerance": 0.1,
                "reach": 0.1,
            },
        ),
        "Cost": Sound(to.Cost, {"residual": Velocity(), "weight": 1.0}),
        "MeshPolicy": Sound(to.MeshPolicy, {"exact": True}),
        **{name: Sound(getattr(to, name), given) for kind in kinds() for name, given in kind.calls.items()},
        "Budget": Sound(
            to.Budget, {"seconds": 1.0, "work": 10, "attempts": 2, "workers": 1, "improve": True}
        ),
        "any_of": Sound(to.any_of, {"goals": {"a": to.joint_positions({"panda_joint1": 0.1})}}),
        "compare": Sound(
            to.compare, {"problems": ["planar_fold"], "methods": ["sqp"], "attempts": 1, "cpu_seconds": 5.0}
        ),
        "convex": Sound(to.convex, {"points": np.random.default_rng(0).normal(size=(9, 3))}),
        "during": Sound(to.during, {"required": to.joint_positions({"panda_joint1": 0.1}), "after": "a"}),
        "examine": Sound(to.examine, {"reduced": problem.reduced, "positions": ready}),
        "goal_configurations": Sound(to.goal_configurations, {"problem": problem}),
        "judge": Sound(to.judge, {"problem": problem, "trajectory": motion}),
        "load": Sound(to.load, {"robot": "planar2"}),
        "load_mesh": Sound(to.load_mesh, {"path": folder / "one.stl"}),
        "named_problem": Sound(to.named_problem, {"name": "planar_fold"}),
        "Track": Sound(to.Track, vars(still)),
        "Prediction": Sound(to.Prediction, {"track": still, "error": (0.01, 0.0, 0.0), "until": 4.0}),
        "placement": Sound(to.placement, {"xyz": point, "rpy": axis}),
        "plan": Sound(to.plan, {"problem": problem, "method": None, "budget": to.Budget(attempts=3)}),
        "plan_many": Sound(
            to.plan_many, {"problems": [problem], "workers": 2, "planner": to.plan, "bar": False}
        ),
        "tool_speed": Sound(to.tool_speed, {"frame": TIP, "linear": 0.2, "angular": 1.0}),
        "Box": Sound(to.Box, {"x": 0.1, "y": 0.1, "z": 0.1}),
        "Sphere": Sound(to.Sphere, {"radius": 0.1}),
        "Cylinder": Sound(to.Cylinder, {"radius": 0.1, "length": 0.1}),
        "Capsule": Sound(to.Capsule, {"radius": 0.1, "length": 0.1}),
        "Cone": Sound(to.Cone, {"radius": 0.1, "length": 0.1}),
        "Mesh": Sound(to.Mesh, {"vertices": np.eye(3), "faces": [(0, 1, 2)]}),
        "Points": Sound(to.Points, {"points": np.eye(3), "radius": 0.01}),
        "Voxels": Sound(to.Voxels, {"keys": np.eye(3, dtype=int), "size": 0.02}),
        "Problem": Sound(
            to.Problem,
            {
                "scene": scene, "group": "panda_arm", "start": "ready", "goal": problem.goal,
                "constraints": [], "waypoints": [], "knots": 24, "velocity_scaling": 1.0,
            },
        ),
        "Task": Sound(
            to.Task,
            {
                "scene": scene, "group": "panda_arm", "start": "ready", "stages": [MoveTo("ready")],
                "constraints": [], "blend": 0.0, "name": "task",
            },
        ),
        "Trajectory": Sound(
            to.Trajectory,
            {"joint_names": motion.joint_names, "times": motion.times, "positions": motion.positions},
        ),
    }  # fmt: skip


def steps_of_a_motion(folder: Path) -> dict[str, Sound]:
    """Everything from a first plan to its picture, with two rods."""
    robot = to.load("planar2")
    tip, (shoulder, elbow) = robot.links[-1], robot.joint_names
    scene = to.Scene(robot).add("thing", to.Box(0.02, 0.02, 0.02), to.placement((0.2, 0.0, 0.5)), mass=0.1)
    start, goal = {shoulder: 0.0, elbow: 1.0}, {shoulder: 0.3, elbow: 1.0}
    problem = to.Problem(scene=scene, start=start, goal=to.joint_positions(goal), knots=4)
    seed = np.linspace(tuple(start.values()), tuple(goal.values()), 4)
    result = to.plan_once(problem, seed)
    first = scene.placement_of(tip, robot.positions(start))
    away = to.placement(first.translation + 0.01 * first.rotation[:, 0])
    curve = to.follows_curve(tip, polyline((first, away)), rotation_tolerance=np.inf)
    return {
        "explain": Sound(to.explain, {"result": result, "plan_again": False, "plan": to.plan}),
        "follow": Sound(
            to.follow,
            {
                "scene": scene,
                "required": curve,
                "start": start,
                "group": "",
                "options": FollowOptions(),
                **shared(),
            },
        ),
        "plan_once": Sound(
            to.plan_once,
            {"problem": problem, "seed": seed, "method": "sqp", "waypoint_knots": (), "effort": Effort.FULL},
        ),
        "render": Sound(
            to.render,
            {
                "subject": result,
                "motion": folder / "motion.png",
                "width": 32,
                "height": 32,
                "fps": 20.0,
                "moments": [0.0],
                "layout": Layout.FILM_STRIP,
                "camera": None,
                "highlight": ["thing"],
                "progress": silent,
            },
        ),
        "simulate": Sound(to.simulate, {"motion": result, "options": SimulationOptions(settling_time=0.0)}),
        "view": Sound(
            lambda **given: to.view(**given).close(), {"motion": result, "port": 0, "host": "127.0.0.1"}
        ),
    }


def taking() -> dict[str, Sound]:
    panda = to.load("panda")
    gripper = gripper_of(panda)
    table = to.Scene(panda).add("box", to.Box(0.05, 0.05, 0.1), to.placement((0.5, 0.0, 0.3)))
    place = Place(placement=to.placement((0.5, 0.2, 0.3)))
    return {
        "pick_and_place": Sound(
            to.pick_and_place,
            {
                "scene": table,
                "name": "box",
                "start": "ready",
                "grasps": grasps_of(table, "box", gripper)[:1],
                "places": place,
                "group": "",
                "gripper": gripper,
                "constraints": (),
                "options": GraspingOptions(),
                **shared(),
            },
        ),
    }


def shared() -> dict[str, object]:
    return {
        "rng": np.random.default_rng(0),
        "budget": to.Budget(work=1),
        "cancel": Event(),
        "progress": silent,
    }


def silent(*_: object) -> None:
    pass


TYPED = {"scene", "reduced", "problem", "trajectory", "joint_names"}
"""Arguments that are our own values, made by nothing that is not checked: types are for type checkers."""
NOT_CALLED = {
    "RotationCoordinates": "an enumeration",
    "Status": "an enumeration",
    "Plane": "takes nothing",
    "Requirement": "the base of the kinds, without a field",
    "Placement": "made by `placement`",
    "Certificate": "made by the judge",
    "Path": "made by the optimiser",
    "Plan": "made by planning",
    "Result": "made by planning",
    "Robot": "made by `load`; its files are spoilt in tests/robot/test_junk_descriptions.py",
    "Scene": "its methods are spoilt in tests/test_messages.py",
}
"""Public classes and functions whose arguments are not spoilt here, and why."""


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Sound]:
    return calls(tmp_path_factory.mktemp("junk"))


def names() -> list[str]:
    return sorted(
        name
        for name in dir(to)
        for value in (getattr(to, name),)
        if not name.startswith("_")
        and (inspect.isfunction(value) or inspect.isclass(value))
        and name not in NOT_CALLED
        and not (inspect.isclass(value) and issubclass(value, Exception))
    )


@pytest.mark.parametrize("name", names())
def test_spoilt_arguments_are_refused_in_words_or_taken_soundly(name: str, sound: dict[str, Sound]) -> None:
    call = sound[name]
    call.function(**call.given)
    for argument in call.given:
        if argument in TYPED:
            continue
        for junk in JUNK:
            try:
                call.function(**{**call.given, argument: junk})
            except to.TrajoptError as error:
                assert str(error).strip(), f"{name}({argument}={junk!r}): an error without words"
            except Exception as error:
                pytest.fail(f"{name}({argument}={junk!r}) raised {type(error).__name__}: {error}")
