"""Backend: plans and moves a world's robot, in this process or through a server."""

from collections.abc import Callable
from typing import ParamSpec, Protocol, TypeVar

from trajopt.driving import Executor
from trajopt.driving.soonest_stop import StopTaken
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.move_group.execution import Execution
from trajopt.values.arrays import Floats

P = ParamSpec("P")
R = TypeVar("R")


class Backend(Protocol):
    """Plans for a world and moves its robot.

    The world itself answers queries that need only its robot, scene and joint positions; planning and motion
    are delegated to the backend.
    """

    @property
    def robot(self) -> Robot:
        """The robot."""
        ...

    @property
    def scene(self) -> Scene:
        """Scene around the robot."""
        ...

    @property
    def positions(self) -> Floats:
        """Current positions of all joints, shape (number of joints,) [rad | m]."""
        ...

    @property
    def moving(self) -> bool:
        """Whether a motion is in progress."""
        ...

    @property
    def executor(self) -> Executor:
        """Executor that drives the joints.

        Raises:
            MoveItCommanderException: If the executor belongs to another process.
        """
        ...

    def stand(self, positions: Floats) -> None:
        """Set the simulated robot's positions, shape (number of joints,) [rad | m]."""
        ...

    def take(self, scene: Scene) -> None:
        """Replace the scene around the robot."""
        ...

    def ask(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Call a function of `trajopt.server.move_group.functions` and return its result."""
        ...

    def begin(self, execution: Execution, *, paced: bool) -> str:
        """Start a motion and return immediately.

        Args:
            execution: The motion, and the scene in which it is driven.
            paced: Whether simulated time passes in real time, since the script does not wait for the end.

        Returns:
            The reason if the motion cannot start; else empty.
        """
        ...

    def wait(self) -> str:
        """Wait until the robot is at rest; return the fault, or an empty text."""
        ...

    def stop(self) -> StopTaken | None:
        """Stop the robot as soon as a proven stop allows; None if it is at rest."""
        ...

    def close(self) -> None:
        """Release all resources."""
        ...
