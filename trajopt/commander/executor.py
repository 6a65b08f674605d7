"""What moves a robot: a small protocol that the simulated one keeps, and yours can."""

from typing import Protocol

from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel
from trajopt.model.trajectory import Trajectory


class Executor(Protocol):
    """Moves a robot, one motion at a time, and says where it is."""

    def positions(self) -> Floats:
        """Return where all joints are now, in the order of `Robot.joint_names` [rad | m]."""
        ...

    def start(self, reduced: ReducedModel, trajectory: Trajectory) -> None:
        """Begin to follow a trajectory and return at once.

        Args:
            reduced: The robot in its scene, the group's joints free.
            trajectory: Of the group's joints; it begins where the robot stands.
        """
        ...

    def moving(self) -> bool:
        """Say whether a motion is under way."""
        ...

    def wait(self) -> str:
        """Return when the motion has ended; say what went wrong on the way, nothing if nothing did."""
        ...

    def stop(self) -> None:
        """Bring the robot to rest where it is, and return when it is."""
        ...
