"""Execution of a trajectory: what moves the robot, and how far from the end it is afterwards."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from trajopt.arrays import Floats
from trajopt.commander.moveit_msgs.msg import MoveItErrorCodes
from trajopt.commander.outcome import Outcome
from trajopt.errors import shown
from trajopt.model.description.pinocchio_model import joint_unit
from trajopt.model.printed import in_joint_position, in_unit
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


START_TOLERANCE = 0.01
"""Where the robot stands, a trajectory must begin, within this for each joint [rad | m] (MoveIt's)."""
REACHED = 1e-3
"""A joint this near to the end of the trajectory has reached it [rad | m]."""


@dataclass(frozen=True, eq=False)
class Execution:
    """A trajectory that is executed.

    Attributes:
        executor: What moves the robot.
        reduced: The robot in its scene, the group's joints free.
        trajectory: Joints in the group's order.
        tip: The end effector's link; empty for none.
    """

    executor: Executor
    reduced: ReducedModel
    trajectory: Trajectory
    tip: str

    def refusal(self) -> Outcome | None:
        """Say why the trajectory cannot be executed now, if it cannot."""
        if self.executor.moving():
            return _failed("another motion is under way; stop() it, or wait")
        here = self.executor.positions()[self.reduced.scene.robot.index(self.reduced.joint_names)]
        away = np.abs(self.trajectory(0.0) - here)
        worst = int(np.argmax(away))
        if away[worst] <= START_TOLERANCE:
            return None
        joint, begin = self.reduced.joint_names[worst], float(self.trajectory(0.0)[worst])
        unit = joint_unit(self.reduced.scene.robot.model, joint)
        return _failed(
            f"joint {shown(joint)} stands at {in_joint_position(float(here[worst]), unit)}, but the "
            f"trajectory begins at {in_joint_position(begin, unit)}; plan from the current state"
        )

    def measured(self, remark: str = "", *, stopped: bool = False) -> Outcome:
        """Compare where the robot is with where the trajectory ends.

        Args:
            remark: What went wrong on the way.
            stopped: Whether the motion was stopped before its end.
        """
        scene, positions = self.reduced.scene, self.executor.positions()
        wanted = self.reduced.all_positions(self.trajectory(self.trajectory.duration))
        group = scene.robot.index(self.reduced.joint_names)
        errors = np.abs(positions - wanted)[group]
        worst = int(errors.argmax())
        error, joint = float(errors[worst]), self.reduced.joint_names[worst]
        away = in_unit(error, joint_unit(scene.robot.model, joint))
        said = f"{joint} {away} from the goal" + (f"; {remark}" if remark else "")
        if stopped:
            code = MoveItErrorCodes(MoveItErrorCodes.PREEMPTED, f"stopped {said}", "execution")
        elif error <= REACHED:
            code = MoveItErrorCodes(MoveItErrorCodes.SUCCESS, f"ended {said}", "execution")
        else:
            code = MoveItErrorCodes(MoveItErrorCodes.CONTROL_FAILED, f"ended {said}", "execution")
        if not self.tip:
            return Outcome(code, error)
        between = scene.placement_of(self.tip, wanted).inverse() * scene.placement_of(self.tip, positions)
        angle = float(Rotation.from_matrix(between.rotation).magnitude())
        return Outcome(code, error, float(np.linalg.norm(between.translation)), angle)


def _failed(reason: str) -> Outcome:
    return Outcome(MoveItErrorCodes(MoveItErrorCodes.CONTROL_FAILED, reason, "execution"))
