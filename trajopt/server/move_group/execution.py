"""Execution of a trajectory: whether it can start, and the final error."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from trajopt.driving.soonest_stop import StopTaken
from trajopt.files.messages import MoveItErrorCodes
from trajopt.robot.joints import joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.server.move_group.outcome import Outcome
from trajopt.values.arrays import Floats
from trajopt.values.errors import shown
from trajopt.values.printed import in_joint_position, in_unit
from trajopt.values.trajectory import Trajectory

START_TOLERANCE = 0.01
"""Largest distance of a trajectory's start from the robot, for each joint [rad | m] (MoveIt's)."""
REACHED = 1e-3
"""A joint this near to the end of the trajectory has reached it [rad | m]."""


@dataclass(frozen=True, eq=False)
class Execution:
    """A trajectory that is executed.

    Attributes:
        reduced: The robot in its scene, the group's joints free.
        trajectory: Joints in the group's order.
        tip: The end effector's link; empty for none.
    """

    reduced: ReducedModel
    trajectory: Trajectory
    tip: str

    def refusal(self, positions: Floats) -> Outcome | None:
        """Return the reason why the trajectory cannot be executed now, if any.

        Args:
            positions: Present positions of all joints [rad | m].
        """
        here = positions[self.reduced.scene.robot.index(self.reduced.joint_names)]
        away = np.abs(self.trajectory(0.0) - here)
        worst = int(np.argmax(away))
        if away[worst] <= START_TOLERANCE:
            return None
        joint, begin = self.reduced.joint_names[worst], float(self.trajectory(0.0)[worst])
        unit = joint_unit(self.reduced.scene.robot.model, joint)
        return not_executed(
            f"joint {shown(joint)} stands at {in_joint_position(float(here[worst]), unit)}, but the "
            f"trajectory begins at {in_joint_position(begin, unit)}; plan from the current state"
        )

    def measured(self, positions: Floats, remark: str = "", *, stop: StopTaken | None = None) -> Outcome:
        """Compare the robot with the end of the trajectory.

        Args:
            positions: Present positions of all joints [rad | m].
            remark: Faults during the motion.
            stop: The stop that ended the motion early.
        """
        scene = self.reduced.scene
        wanted = self.reduced.all_positions(self.trajectory(self.trajectory.duration))
        group = scene.robot.index(self.reduced.joint_names)
        errors = np.abs(positions - wanted)[group]
        worst = int(errors.argmax())
        error, joint = float(errors[worst]), self.reduced.joint_names[worst]
        away = in_unit(error, joint_unit(scene.robot.model, joint))
        said = f"{joint} {away} from the goal" + (f"; {remark}" if remark else "")
        if stop is not None:
            words = f"stopped within {1e3 * stop.duration:.0f} ms, {_how(stop)}, {said}"
            code = MoveItErrorCodes(MoveItErrorCodes.PREEMPTED, words, "execution")
        elif error <= REACHED:
            code = MoveItErrorCodes(MoveItErrorCodes.SUCCESS, f"ended {said}", "execution")
        else:
            code = MoveItErrorCodes(MoveItErrorCodes.CONTROL_FAILED, f"ended {said}", "execution")
        took = None if stop is None else stop.duration
        if not self.tip:
            return Outcome(code, error, stopping_time=took)
        between = scene.placement_of(self.tip, wanted).inverse() * scene.placement_of(self.tip, positions)
        angle = float(Rotation.from_matrix(between.rotation).magnitude())
        return Outcome(code, error, float(np.linalg.norm(between.translation)), angle, took)


def _how(stop: StopTaken) -> str:
    """Describe a stop, and whether it was proven."""
    path = "on its path" if stop.along else "off its path"
    return path if stop.proven else f"{path} and not proven"


def not_executed(reason: str) -> Outcome:
    """Return the outcome of a motion that did not start."""
    return Outcome(MoveItErrorCodes(MoveItErrorCodes.CONTROL_FAILED, reason, "execution"))
