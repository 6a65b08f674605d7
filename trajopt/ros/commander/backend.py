"""Backend: what a world must answer; this process does, or a server in another."""

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
    """Plans for a world, and moves its robot.

    What can be asked of a world is answered by the world itself, from its robot, its scene and where its
    joints are; only what takes a planner or a robot is asked of this.
    """

    @property
    def robot(self) -> Robot:
        """The robot."""
        ...

    @property
    def scene(self) -> Scene:
        """What is around the robot."""
        ...

    @property
    def positions(self) -> Floats:
        """Where all joints are now, shape (number of joints,) [rad | m]."""
        ...

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        ...

    @property
    def executor(self) -> Executor:
        """What drives the joints.

        Raises:
            MoveItCommanderException: If that is in another process.
        """
        ...

    def stand(self, positions: Floats) -> None:
        """Put the simulated robot somewhere, shape (number of joints,) [rad | m]."""
        ...

    def take(self, scene: Scene) -> None:
        """Take note of what is around the robot from now on."""
        ...

    def ask(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Return what a function of `trajopt.server.move_group.functions` returns."""
        ...

    def begin(self, execution: Execution, *, paced: bool) -> str:
        """Begin to drive a motion, and return at once.

        Args:
            execution: The motion, and the scene in which it is driven.
            paced: Whether time passes as in the world: nobody waits for the end.

        Returns:
            Why it is not driven; empty if it is.
        """
        ...

    def wait(self) -> str:
        """Return when the robot has come to rest; say what went wrong on the way."""
        ...

    def stop(self) -> StopTaken | None:
        """Bring the robot to rest as soon as is proven; None where nothing moves."""
        ...

    def close(self) -> None:
        """Let go of everything."""
        ...
