"""Messages stay short whatever is given, and a wrong argument is never a raw Python error."""

import inspect
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.problem.requirements.kind import kinds
from trajopt.files.export import Movej, Servoj, exporter_named
from trajopt.tasks.cartesian import polyline
from trajopt.values.errors import UnitWarning, end_of, listed, shown
from trajopt.values.trajectory import Path
from trajopt.verify import Moment

LONGEST = 400
"""Characters of a message, whatever was given."""

WRONG: dict[str, object] = {
    "a long text": "x" * 100_000,
    "a text": "elbo",
    "many numbers": [0.5] * 100_000,
    "many names": ["y" * 50] * 5_000,
    "a large mapping": {f"k{index}": index for index in range(20_000)},
    "a large array": np.ones((300, 300)),
    "an object": object(),
    "nan": np.nan,
    "inf": np.inf,
    "none": None,
    "a negative number": -1.0,
    "a huge whole number": 10**4_000,
    "true": True,
}
AT = to.placement((0.4, 0.0, 0.4))
Call = tuple[Callable[..., object], dict[str, object]]


def calls() -> Iterator[Call]:
    """Public calls that work, with their arguments."""
    robot = to.load("planar2")
    scene = to.Scene(robot).add("box", to.Box(0.1, 0.1, 0.1), to.placement((1, 1, 1)))
    tip, link, joint = robot.links[-1], robot.links[1], robot.joint_names[0]
    group = next(iter(robot.groups))
    goal = to.joint_positions({joint: 0.2})
    problem: dict[str, object] = {
        "scene": scene, "start": {}, "goal": goal, "group": group, "constraints": [to.gravity_torque(0.5)],
        "waypoints": {"via": goal}, "costs": None, "knots": 24, "velocity_scaling": 1.0,
        "acceleration_scaling": 1.0, "tool_speed": (), "start_velocity": {},
    }  # fmt: skip
    made = to.Problem(**problem)  # type: ignore[arg-type]
    zeros = np.zeros(len(robot.joint_names))
    yield to.load, {"robot": "planar2"}
    yield to.Problem, problem
    for kind in kinds():
        for name, arguments in kind.calls.items():
            yield getattr(to, name), dict(arguments)
    yield to.any_of, {"goals": {"a": goal}}
    yield to.during, {"required": goal, "after": "via", "until": None}
    yield to.tool_speed, {"frame": tip, "linear": 0.1, "angular": 0.1, "steady": 0.1}
    yield polyline, {"poses": (AT, to.placement((0.5, 0.0, 0.4))), "blend": 0.01}
    yield to.placement, {"xyz": (0, 0, 0), "rpy": (0, 0, 0)}
    yield to.Box, {"x": 0.1, "y": 0.1, "z": 0.1}
    yield to.Cylinder, {"radius": 0.1, "length": 0.1}
    yield to.convex, {"points": np.eye(4, 3)}
    yield to.load_mesh, {"path": "nothing.stl"}
    yield to.Scene, {"robot": robot, "margin": 0.01}
    yield scene.add, {"name": "new", "shape": to.Sphere(0.1), "placement": AT, "frame": "world",
                      "touch_links": (), "mass": 0.1}  # fmt: skip
    yield scene.remove, {"name": "box"}
    yield scene.move, {"name": "box", "placement": AT, "frame": "world"}
    yield scene.attach, {"name": "box", "link": tip, "placement": AT, "touch_links": (), "mass": 0.1}
    yield scene.with_tool, {"name": "tip of it", "on": link, "placement": AT}
    yield scene.allow, {"a": "box", "b": link}
    yield scene.with_clearance, {"value": 0.01, "a": "box", "b": link}
    yield scene.with_margin, {"margin": 0.01, "a": "box", "b": link}
    yield scene.allow_contact, {"name": "n", "a": "box", "b": link, "depth": 0.001, "first": 0.1, "last": 0.1}
    yield scene.object, {"name": "box"}
    yield scene.placement_of, {"name": "box", "positions": zeros}
    yield scene.may_touch, {"a": "box", "b": link}
    yield robot.group, {"name": group}
    yield robot.frame, {"name": tip}
    yield robot.positions, {"values": {}}
    yield robot.state, {"name": "none", "group": group}
    yield to.plan_once, {"problem": made, "seed": np.zeros((24, 2)), "method": "sqp"}
    yield to.named_problem, {"name": "planar_fold"}
    yield to.explain, {"result": None}
    yield to.examine, {"reduced": made.reduced, "positions": zeros, "moment": Moment.START}
    yield to.judge, {"problem": made, "trajectory": None}
    yield to.goal_configurations, {"problem": made, "rng": None}
    yield Path, {"joint_names": ("a",), "knots": np.zeros((3, 1))}
    yield to.Trajectory, {"joint_names": ("a",), "times": np.arange(3.0), "positions": np.zeros((3, 1))}
    moving = to.Trajectory(("a",), np.arange(3.0), np.zeros((3, 1)))
    yield moving.sampled, {"hz": 2.0}
    yield exporter_named, {"name": "csv"}
    yield Servoj, {"lookahead_time": 0.1, "gain": 300.0}
    yield Movej, {"tolerance": 0.01, "blend": 0.005}
    yield to.Cost, {"residual": None, "weight": 1.0}


CALLS: dict[str, Call] = {call[0].__qualname__: call for call in calls()}


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.timeout(120)
def test_a_wrong_argument_is_a_typed_error_with_a_short_message(name: str) -> None:
    call, arguments = CALLS[name]
    assert set(arguments) <= set(inspect.signature(call).parameters), "the arguments of the call as it is"
    for argument in arguments:
        for kind, value in WRONG.items():
            given: dict[str, Any] = {**arguments, argument: value}
            try:
                call(**given)
            except (to.TrajoptError, UnitWarning) as error:
                assert len(str(error)) <= LONGEST, f"{argument} as {kind}: {str(error)[:200]}"
            except Exception as error:
                pytest.fail(f"{argument} as {kind}: a raw {type(error).__name__}: {str(error)[:200]}")


def test_printing_is_cut() -> None:
    assert shown(np.array((0.5, -1.0))) == "[0.5, -1]"
    assert shown(np.ones((40, 7))) == "array of shape (40, 7)"
    assert end_of("a/b.urdf") == "a/b.urdf"
    assert len(end_of("x" * 900)) == 200 and end_of("x" * 900 + "/a.urdf").endswith("/a.urdf")
    assert listed([f"j{index}" for index in range(13)]).endswith("j11, ...")
