"""World: the robot, the scene and what moves it, that the names of a script belong to."""

import logging
import time
from collections.abc import Callable, Mapping
from contextvars import ContextVar, Token
from threading import RLock
from types import TracebackType

import numpy as np

from trajopt.arrays import Floats, one_of
from trajopt.commander.driving import Drive, ScriptClock
from trajopt.commander.exception import MoveItCommanderException, as_moveit
from trajopt.commander.execution import Execution, not_executed
from trajopt.commander.moveit_msgs.msg import MoveItErrorCodes
from trajopt.commander.node import Node
from trajopt.commander.outcome import Outcome
from trajopt.errors import ModelError, shown
from trajopt.execution import Executor, SimulatedExecutor
from trajopt.model.description.groups import Group
from trajopt.model.initial_positions import initial_positions
from trajopt.model.load import load
from trajopt.model.robot import Robot
from trajopt.model.scene import Scene

_LOG = logging.getLogger("trajopt.commander")
_CURRENT: ContextVar["World"] = ContextVar("world")


class World:
    """A robot among objects, and what moves it.

    `with World("panda"):` around a script says what `MoveGroupCommander("panda_arm")` and the others in
    it are about; `world=` says the same to one of them.

    Attributes:
        robot: The robot.
        rng: Draws random targets.
        node: What a script has set that is neither robot nor scene.
    """

    @as_moveit
    def __init__(
        self,
        robot: str | Robot,
        *,
        scene: Scene | None = None,
        start: str | Mapping[str, float] | None = None,
        executor: Executor | None = None,
        wait: Callable[[float], object] = time.sleep,
        seed: int = 0,
    ) -> None:
        """Put a robot into a scene.

        Args:
            robot: A robot, or the name of an installed one.
            scene: What is around it; nothing when None.
            start: Where the simulated robot stands: a named state or joint -> position [rad | m]; every
                group in its first named state when None.
            executor: What moves the robot; when None a simulated one, whose time stands while the robot does,
                and passes at once where a script waits for a motion.
            wait: Lets so many seconds of the executor's clock pass, for one that is given.
            seed: Draws random targets: the same ones every time.

        Raises:
            MoveItCommanderException: If the robot is unknown, the scene is another robot's, or the
                executor, which knows where its robot stands, comes with a start.
        """
        self.robot = load(robot) if isinstance(robot, str) else robot
        self._scene = Scene(self.robot) if scene is None else scene
        if self._scene.robot is not self.robot:
            raise ModelError(
                f"the scene is one of {shown(self._scene.robot.name)}, not of {shown(self.robot.name)}"
            )
        if executor is not None and start is not None:
            raise ModelError("give a start or an executor: an executor knows where its robot stands")
        self._clock: ScriptClock | None = None
        self._start = initial_positions(self.robot) if start is None else self.robot.positions(start)
        self._drive: Drive | None = None
        if executor is not None:
            self._drive = Drive(self.robot, executor, self._start, wait)
        self.rng = np.random.default_rng(seed)
        self.node = Node()
        self._outcome: Outcome | None = None
        self._execution: Execution | None = None
        self._lock = RLock()
        self._entered: list[Token[World]] = []

    @property
    def scene(self) -> Scene:
        """What is around the robot now: a value, which an edit replaces."""
        with self._lock:
            return self._scene

    def edit(self, change: Callable[[Scene], Scene]) -> None:
        """Replace the scene by what a function makes of it; the next plan sees it.

        If the function raises, nothing is changed.
        """
        with self._lock:
            self._scene = change(self._scene)

    def group(self, name: str) -> Group:
        """Return a group by its name, which may have the robot's name in front or leave it out.

        MoveIt's own Panda has called its hand `hand` and `panda_hand`, and scripts are of either time.

        Raises:
            GroupNotFound: If there is no such group.
        """
        groups, prefix = self.robot.groups, f"{self.robot.name}_"
        alike = (one_of("group", name, str), f"{prefix}{name}", name.removeprefix(prefix))
        return self.robot.group(next((each for each in alike if each in groups), name))

    @property
    def executor(self) -> Executor:
        """What moves the robot."""
        return self._driving().executor

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        moving = self._drive is not None and self._drive.moving
        if not moving and self._clock is not None:
            self._clock.stand()
        return moving

    @property
    def positions(self) -> Floats:
        """Where all joints are now, shape (number of joints,) [rad | m]."""
        return self._start if self._drive is None else self._drive.positions

    def _driving(self) -> Drive:
        """Return what drives the robot; a simulated one is made when it is needed: it takes a second."""
        if self._drive is None:
            self._clock = ScriptClock()
            simulated = SimulatedExecutor(self._scene, self._start, clock=self._clock)
            self._drive = Drive(self.robot, simulated, self._start, self._clock.skip)
        return self._drive

    @property
    def named_positions(self) -> dict[str, float]:
        """Where all joints are now, by name [rad | m]."""
        return dict(zip(self.robot.joint_names, self.positions.tolist(), strict=True))

    def execute(self, execution: Execution, *, wait: bool) -> Outcome:
        """Execute a trajectory.

        Args:
            execution: The trajectory, and what moves the robot.
            wait: Whether to return when the motion has ended, or when it has begun.
        """
        if self.moving:
            reason = "another motion is under way; stop() it, or wait"
            self._outcome = not_executed(reason)
            _LOG.info("execution: %s", reason)
            return self._outcome
        drive = self._driving()
        refusal = execution.refusal(drive.positions) or self._begun(drive, execution)
        if refusal is not None:
            self.report(refusal)
            return refusal
        self._execution = execution
        if not wait:
            if self._clock is not None:
                self._clock.run()
            code = MoveItErrorCodes(MoveItErrorCodes.SUCCESS, "the motion is under way", "execution")
            self._outcome = Outcome(code)
            return self._outcome
        remark = self._ended(drive)
        outcome = execution.measured(drive.positions, remark)
        self.report(outcome)
        return outcome

    def _begun(self, drive: Drive, execution: Execution) -> Outcome | None:
        """Begin to drive a motion; return why not, if it cannot be."""
        executor, trajectory = drive.executor, execution.trajectory
        if self._clock is not None and isinstance(executor, SimulatedExecutor):
            begin = executor.now() + executor.latency
            executor.change(execution.reduced.scene, begin=begin, duration=trajectory.duration)
        refused = drive.start(execution.reduced, trajectory)
        return not_executed(refused) if refused else None

    def stop(self) -> None:
        """Bring the robot to rest as soon as is proven to be clear of everything, and return when it is."""
        drive, execution = self._drive, self._execution
        if drive is None or execution is None:
            return
        if self._clock is not None:
            self._clock.stand()
        taken = drive.stop()
        self._outcome = execution.measured(drive.positions, self._ended(drive), stop=taken)
        self._execution = None

    def _ended(self, drive: Drive) -> str:
        """Wait for the end of a motion; say what went wrong on the way."""
        remarks = [drive.wait()]
        executor = drive.executor
        if self._clock is not None and isinstance(executor, SimulatedExecutor):
            remarks += [str(contact) for contact in executor.contacts if contact.allowance is None]
            remarks += [f"the motor of {joint} was at its limit" for joint in executor.saturated]
        return "; ".join(remark for remark in remarks if remark)

    def report(self, outcome: Outcome) -> None:
        """Keep how an attempt to move ended, and log it: scripts may not ask."""
        self._execution, self._outcome = None, outcome
        _LOG.info("%s: %s", outcome.error_code.source, outcome.error_code.message)

    @property
    def outcome(self) -> Outcome | None:
        """How the last attempt to move ended; None before the first."""
        execution, drive = self._execution, self._drive
        if execution is not None and drive is not None and not self.moving:
            remark = self._ended(drive)
            self._outcome, self._execution = execution.measured(drive.positions, remark), None
        return self._outcome

    def __enter__(self) -> "World":
        """Let the names in the block belong to this world."""
        self._entered.append(_CURRENT.set(self))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Do what is left for the end, stop a motion, and give the names back to the world around, if any."""
        try:
            self.node.end()
        finally:
            self.stop()
            _CURRENT.reset(self._entered.pop())


def current_world() -> World | None:
    """Return the world of the block around; None outside of one."""
    return _CURRENT.get(None)


def world_or_current(world: World | None) -> World:
    """Return the world that is given, or else the one of the block around.

    Raises:
        MoveItCommanderException: If there is neither.
    """
    found = world or current_world()
    if found is None:
        raise MoveItCommanderException(
            'which robot? Put the script into a block `with World("panda"):`, or give `world=`'
        )
    return found
