"""A world of this process: it plans here, and a simulated robot or an executor is driven from here."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from trajopt.driving import Executor, SimulatedExecutor
from trajopt.driving.soonest_stop import StopTaken
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.move_group.driving import Drive, ScriptClock
from trajopt.server.move_group.execution import Execution
from trajopt.values.arrays import Floats

P = ParamSpec("P")
R = TypeVar("R")


class InProcess:
    """Backend of a world in this process.

    Attributes:
        robot: The robot.
        scene: Its surroundings.
    """

    def __init__(
        self, scene: Scene, start: Floats, executor: Executor | None, wait: Callable[[float], object]
    ) -> None:
        """Take over a robot at rest in a scene.

        Args:
            scene: Its surroundings.
            start: Positions of all joints, shape (number of joints,) [rad | m].
            executor: Its driver; by default a simulated robot whose clock advances only while it moves.
            wait: Waits for a number of seconds on the executor's clock.
        """
        self.robot: Robot = scene.robot
        self.scene, self._start = scene, start
        self._clock: ScriptClock | None = None
        self._drive = None if executor is None else Drive(self.robot, executor, start, wait)

    @property
    def positions(self) -> Floats:
        """Present positions of all joints, shape (number of joints,) [rad | m]."""
        return self._start if self._drive is None else self._drive.positions

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        moving = self._drive is not None and self._drive.moving
        if not moving and self._clock is not None:
            self._clock.stand()
        return moving

    @property
    def executor(self) -> Executor:
        """The driver of the joints."""
        return self._driving().executor

    def stand(self, positions: Floats) -> None:
        """Put the simulated robot somewhere, shape (number of joints,) [rad | m]."""
        self._start = positions

    def take(self, scene: Scene) -> None:
        """Replace the surroundings."""
        self.scene = scene

    def ask(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Call a function and return its result."""
        return function(*args, **kwargs)

    def begin(self, execution: Execution, *, paced: bool) -> str:
        """Start to drive a motion; return the reason if it is not driven."""
        drive, trajectory = self._driving(), execution.trajectory
        executor = drive.executor
        if self._clock is not None and isinstance(executor, SimulatedExecutor):
            begin = executor.now() + executor.latency
            executor.change(execution.reduced.scene, begin=begin, duration=trajectory.duration)
        refused = drive.start(execution.reduced, trajectory)
        if paced and not refused and self._clock is not None:
            self._clock.run()
        return refused

    def wait(self) -> str:
        """Wait until the robot is at rest; return faults in words."""
        drive = self._driving()
        remarks, executor = [drive.wait()], drive.executor
        if self._clock is not None and isinstance(executor, SimulatedExecutor):
            remarks += on_the_way(executor)
        return "; ".join(remark for remark in remarks if remark)

    def stop(self) -> StopTaken | None:
        """Stop the robot as soon as proven; None if it is at rest."""
        if self._clock is not None:
            self._clock.stand()
        return None if self._drive is None else self._drive.stop()

    def close(self) -> None:
        """Keep everything: the world may be entered again."""

    def _driving(self) -> Drive:
        """Return the drive; a simulated robot is created on first use, which takes a second."""
        if self._drive is None:
            self._clock = ScriptClock()
            simulated = SimulatedExecutor(self.scene, self._start, clock=self._clock)
            self._drive = Drive(self.robot, simulated, self._start, self._clock.skip)
        return self._drive


def on_the_way(executor: SimulatedExecutor) -> list[str]:
    """Return the simulated robot's disallowed contacts and saturated motors, in words."""
    contacts = [str(contact) for contact in executor.contacts if contact.allowance is None]
    return [*contacts, *(f"the motor of {joint} was at its limit" for joint in executor.saturated)]
