"""Operations of `trajopt.ros.commander.World(url=...)`, with whole values in the format of bundles.

Input may be hostile: only the kinds of a bundle are constructed, and every motion is judged by its reader.
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from inspect import signature
from typing import Any, TypeVar, cast

from trajopt.driving import SimulatedExecutor
from trajopt.files.bundle.codec import request_kinds
from trajopt.files.bundle.containers import message_of, value_of_message
from trajopt.planning.budget import Budget
from trajopt.problem.problem import Problem
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.server.move_group.driving import MotionDriver
from trajopt.server.move_group.functions import FUNCTIONS, Settings
from trajopt.server.move_group.outcome import Execution
from trajopt.server.operation import Answer, SessionState, Watch
from trajopt.server.operations.driving import drive_along
from trajopt.values.documents.document import Node
from trajopt.values.errors import ProblemError, TrajoptError, listed
from trajopt.values.errors.arguments import check_arguments
from trajopt.values.trajectory import Trajectory

Kind = TypeVar("Kind")
ANSWERING = 0.5
"""Time left for the answer when planning ends [s]: it must be there in the time of the request."""


def robot(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the whole robot of the session: the first request of `trajopt.ros.commander.World(url=...)`."""
    arguments.only(())
    return Answer(message_of(state.scene.robot, {}))


def scene(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the whole scene of the session without its robot, for a mirror."""
    arguments.only(())
    return Answer(message_of(state.scene, {"robot": state.scene.robot}))


def hold(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Replace the session's scene; the robot's positions stay."""
    return Answer({}, replace(state, scene=_scene(arguments.only(("scene",))["scene"], state, watch)))


def call(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Run a function of a `World`: plan, follow, pick or place, with whole values."""
    arguments.only(("function", "arguments", "settings"))
    name = arguments["function"].text()
    if name not in FUNCTIONS:
        raise arguments["function"].error(f"must be one of {', '.join(FUNCTIONS)}")
    known = _known(state)
    stated = cast("dict[str, Any]", _read(arguments["arguments"], known, Mapping, watch))
    settings = cast("dict[str, Any]", _read(arguments["settings"], {}, Mapping, watch))
    unknown = settings.keys() - {item.name for item in fields(Settings)}
    if unknown:
        raise arguments["settings"].error(f"unknown: {listed(sorted(map(str, unknown)))}")
    check_arguments(Settings, settings)
    stated["settings"] = Settings(**settings)
    for value in stated.values():
        if isinstance(value, Problem | Scene):
            _fitting(arguments["arguments"], value if isinstance(value, Scene) else value.scene, state)
    stated |= {"budget": Budget(max(watch.seconds_left - ANSWERING, 0.0)), "cancel": watch.cancel}
    check_arguments(FUNCTIONS[name], stated)
    try:
        signature(FUNCTIONS[name]).bind(**stated)
    except TypeError as error:
        raise arguments["arguments"].error(str(error)) from error
    return Answer(message_of(FUNCTIONS[name](**stated), known))


def drive(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Drive the simulated robot along a trajectory, in a scene that may differ from the session's.

    `speed` is the rate of simulated time: 1 for real time, 0 for as fast as possible. Cancellation stops the
    robot.
    """
    arguments.only(("scene", "group", "trajectory", "speed"))
    speed, names = arguments["speed"].number(1.0), state.scene.robot.joint_names
    if speed < 0.0:
        raise arguments["speed"].error("must not be negative")
    scene = _scene(arguments["scene"], state, watch)
    motion = _read(arguments["trajectory"], {}, Trajectory, watch)
    reduced = reduce_model(scene, arguments["group"].text(), state.positions)
    execution = Execution(reduced, motion.ordered(reduced.joint_names), "")
    refusal = execution.refusal(state.positions)
    if refusal is not None:
        raise ProblemError(refusal.error_code.message)

    def look(_: SimulatedExecutor, drive: MotionDriver, now: float) -> None:
        places = drive.positions.tolist()
        watch.tell({"time": now, "positions": dict(zip(names, places, strict=True))}, places)

    ended = drive_along(execution, state.positions, watch, look, speed=speed)
    return Answer(
        {
            "positions": dict(zip(names, ended.positions.tolist(), strict=True)),
            "refused": ended.reason,
            "remark": ended.remark,
            "stop": None if ended.stop is None else vars(ended.stop),
        },
        replace(state, positions=ended.positions),
    )


def _known(state: SessionState) -> dict[str, object]:
    return {"robot": state.scene.robot, "scene": state.scene}


def _read(node: Node, known: Mapping[str, object], kind: type[Kind], watch: Watch) -> Kind:
    most = {"triangles": watch.triangles, "rows": watch.points}
    return value_of_message(node, known, kind, kinds=request_kinds(), **most)


def _scene(node: Node, state: SessionState, watch: Watch) -> Scene:
    return _fitting(node, _read(node, _known(state), Scene, watch), state)


def _fitting(node: Node, scene: Scene, state: SessionState) -> Scene:
    if scene.robot is not state.scene.robot:
        raise node.error("is of another robot than the session's")
    try:
        for group in scene.robot.groups:
            reduce_model(scene, group, state.positions)
    except TrajoptError:
        raise
    except (ValueError, TypeError, LookupError, AttributeError, ArithmeticError) as error:
        # Each value was checked by itself; what does not fit together shows only here.
        raise node.error(f"robot and scene do not fit together: {type(error).__name__}: {error}") from error
    return scene
