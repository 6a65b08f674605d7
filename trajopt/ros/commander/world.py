"""World: the robot, scene and backend of a script's commanders."""

import logging
import time
from collections.abc import Callable, Mapping
from contextvars import ContextVar, Token
from dataclasses import dataclass, field
from threading import RLock
from typing import TYPE_CHECKING, ParamSpec, TypeVar

import numpy as np

from trajopt.driving import Executor
from trajopt.files.messages import MoveItErrorCodes
from trajopt.robot.configuration import initial_positions
from trajopt.robot.load import load
from trajopt.robot.loading.groups import Group
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.move_group.driving import InProcess
from trajopt.server.move_group.outcome import (
    Execution,
    ExecutionOutcome,
    MoveItCommanderException,
    as_moveit,
    not_executed,
)
from trajopt.values.arrays import Floats, one_of
from trajopt.values.errors import MissingExtra, ModelError, shown

if TYPE_CHECKING:
    from trajopt.ros.commander.served import ServerBackend

P = ParamSpec("P")
R = TypeVar("R")


OF_THE_ROBOT = ("robot_description", "robot_description_semantic")
"""Parameters that launch files set; the robot of the world is in their place."""
_LOG = logging.getLogger("trajopt.ros.commander")
_CURRENT: ContextVar["World"] = ContextVar("world")


@dataclass
class ScriptNode:
    """Parameters and shutdown hooks of a script."""

    name: str = "script"
    parameters: dict[str, object] = field(default_factory=dict[str, object])
    hooks: list[Callable[[], object]] = field(default_factory=list[Callable[[], object]])
    shut_down: bool = False

    def end(self) -> None:
        self.shut_down = True
        while self.hooks:
            self.hooks.pop(0)()

    def has(self, name: str) -> bool:
        key = name.removeprefix("/")
        return key in self.parameters or key in OF_THE_ROBOT

    def parameter(self, name: str) -> object:
        key = name.removeprefix("/")
        if key not in self.parameters and key in OF_THE_ROBOT:
            raise MoveItCommanderException(
                f"rospy.get_param({key!r}): the text of the robot's files is not kept; RobotCommander knows "
                "its groups, joints and links"
            )
        return self.parameters[key]


class World:
    """A robot in a scene, and its backend.

    `with World("panda"):` around a script selects the world of `MoveGroupCommander("panda_arm")` and the
    other commanders in the block; the argument `world=` does so for one commander.

    Attributes:
        node: Parameters and shutdown hooks of the script.
    """

    @as_moveit
    def __init__(
        self,
        robot: str | Robot = "",
        *,
        url: str = "",
        token: str = "",
        scene: Scene | None = None,
        start: str | Mapping[str, float] | None = None,
        executor: Executor | None = None,
        wait: Callable[[float], object] = time.sleep,
        seed: int = 0,
    ) -> None:
        """Put a robot into a scene.

        Args:
            robot: A robot, or the name of an installed robot; with `url` the name of a robot of the server,
                its first if empty.
            url: Address of a `trajopt serve`, such as "http://127.0.0.1:8080", which plans and moves its
                simulated robot; if empty, this process does.
            scene: Empty when None.
            start: Start of the simulated robot: a named state or joint -> position [rad | m]; every group in
                its first named state when None.
            executor: Executor of the robot. When None a simulated one, whose time advances only during
                motions, and immediately if the script waits.
            wait: Lets a duration [s] pass on the clock of a given executor.

        Raises:
            MoveItCommanderException: If the robot is unknown, the scene has another robot, a start is
                combined with an executor, which has its own, or the server does not answer.
        """
        if executor is not None and start is not None:
            raise ModelError("give a start or an executor: an executor has the positions of its robot")
        if url:
            self._backend: InProcess | ServerBackend = _served(url, token, robot, scene, executor)
        else:
            self._backend = _here(robot, scene, executor, wait)
        if start is not None:
            self._backend.stand(self._backend.robot.positions(start))
        self.robot, self._scene = self._backend.robot, self._backend.scene
        self.rng = np.random.default_rng(seed)
        self.node = ScriptNode()
        self._outcome: ExecutionOutcome | None = None
        self._execution: Execution | None = None
        self._lock = RLock()
        self._entered: list[Token[World]] = []

    @property
    def scene(self) -> Scene:
        """Current scene around the robot, an immutable value; edits replace it."""
        with self._lock:
            return self._scene

    def edit(self, change: Callable[[Scene], Scene]) -> None:
        """Replace the scene by a function of it; the next plan uses the result.

        If the function raises, nothing is changed.

        Raises:
            ModelError: If the new scene has another robot.
        """
        with self._lock:
            scene = change(self._scene)
            if scene.robot.joint_names != self.robot.joint_names:  # its links may have another size
                raise ModelError(f"the scene is of another robot than this world's {shown(self.robot.name)}")
            if scene is not self._scene:
                self._backend.take(scene)
            self._scene = scene

    def ask(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Call a function of `trajopt.server.move_group.functions` where the robot is planned for."""
        return self._backend.ask(function, *args, **kwargs)

    def group(self, name: str) -> Group:
        """Return a group by its name; the robot's name as a prefix is optional.

        Raises:
            GroupNotFound: If the group does not exist.
        """
        return group_named(self.robot, name)

    @property
    def executor(self) -> Executor:
        """Executor of the robot; raises if a server moves the robot."""
        return self._backend.executor

    @property
    def moving(self) -> bool:
        """Whether a motion is in progress."""
        return self._backend.moving

    @property
    def positions(self) -> Floats:
        return self._backend.positions

    @property
    def named_positions(self) -> dict[str, float]:
        """Current positions of all joints, by name [rad | m]."""
        return dict(zip(self.robot.joint_names, self.positions.tolist(), strict=True))

    def execute(self, execution: Execution, *, wait: bool) -> ExecutionOutcome:
        """Execute a trajectory.

        Args:
            execution: The trajectory, and the scene in which it is driven.
            wait: Whether to return after the motion, or after its start.
        """
        if self.moving:
            reason = "another motion is under way; stop() it, or wait"
            self._outcome = not_executed(reason)
            _LOG.info("execution: %s", reason)
            return self._outcome
        refusal = execution.refusal(self.positions) or self._begun(execution, paced=not wait)
        if refusal is not None:
            self.report(refusal)
            return refusal
        self._execution = execution
        if not wait:
            code = MoveItErrorCodes(MoveItErrorCodes.SUCCESS, "the motion is under way", "execution")
            self._outcome = ExecutionOutcome(code)
            return self._outcome
        remark = self._backend.wait()
        outcome = execution.measured(self.positions, remark)
        self.report(outcome)
        return outcome

    def _begun(self, execution: Execution, *, paced: bool) -> ExecutionOutcome | None:
        refused = self._backend.begin(execution, paced=paced)
        return not_executed(refused) if refused else None

    def stop(self) -> None:
        execution = self._execution
        if execution is None:
            return
        taken, remark = self._backend.stop(), self._backend.wait()
        self._outcome = execution.measured(self.positions, remark, stop=taken)
        self._execution = None

    def report(self, outcome: ExecutionOutcome) -> None:
        """Store and log the outcome of a motion; scripts may not query it."""
        self._execution, self._outcome = None, outcome
        _LOG.info("%s: %s", outcome.error_code.source, outcome.error_code.message)

    @property
    def outcome(self) -> ExecutionOutcome | None:
        """Outcome of the last motion; None before the first."""
        execution = self._execution
        if execution is not None and not self.moving:
            remark = self._backend.wait()
            self._outcome, self._execution = execution.measured(self.positions, remark), None
        return self._outcome

    def __enter__(self) -> "World":
        self._entered.append(_CURRENT.set(self))
        return self

    def __exit__(self, *raised: object) -> None:
        try:
            self.node.end()
        finally:
            self.stop()
            _CURRENT.reset(self._entered.pop())
            if not self._entered:
                self._backend.close()


def _here(
    robot: str | Robot, scene: Scene | None, executor: Executor | None, wait: Callable[[float], object]
) -> InProcess:
    if robot == "":
        raise ModelError("which robot? Give one, the name of an installed one, or the url= of a server")
    loaded = load(robot) if isinstance(robot, str) else robot
    around = Scene(loaded) if scene is None else scene
    if around.robot is not loaded:
        raise ModelError(f"the scene is one of {shown(around.robot.name)}, not of {shown(loaded.name)}")
    return InProcess(around, initial_positions(loaded), executor, wait)


def _served(
    url: str, token: str, robot: str | Robot, scene: Scene | None, executor: Executor | None
) -> "ServerBackend":
    if not isinstance(robot, str) or scene is not None or executor is not None:
        raise ModelError("a server has its own robot: with url= give its name, no scene and no executor")
    try:
        from trajopt.ros.commander.served import ServerBackend
    except ModuleNotFoundError as error:
        raise MissingExtra(str(error.name), "server") from error
    return ServerBackend(url, robot, token=token)


def group_named(robot: Robot, name: str) -> Group:
    prefix = f"{robot.name}_"
    alike = (one_of("group", name, str), f"{prefix}{name}", name.removeprefix(prefix))
    return robot.group(next((each for each in alike if each in robot.groups), name))


def current_world() -> World | None:
    """Return the world of the enclosing `with` block; None outside."""
    return _CURRENT.get(None)


def world_or_current(world: World | None) -> World:
    """Return the given world, or else the one of the enclosing `with` block."""
    found = world or current_world()
    if found is None:
        raise MoveItCommanderException(
            'which robot? Put the script into a block `with World("panda"):`, or give `world=`'
        )
    return found
