"""Tolerances of a trajectory that is followed: how far joints may be from where they should be."""

from collections.abc import Sequence
from dataclasses import dataclass

from trajopt.files.messages.control_msgs import FollowJointTrajectoryGoal, JointTolerance
from trajopt.files.messages.trajectory_msgs import JointTrajectoryPoint
from trajopt.values.errors import JointNotFound, ProblemError


@dataclass(frozen=True)
class Tolerances:
    """How far joints may be off; joints that are not named may be anywhere.

    Attributes:
        stated: What is stated of joints.
    """

    stated: Sequence[JointTolerance]

    def broken(
        self, joints: Sequence[str], desired: JointTrajectoryPoint, actual: JointTrajectoryPoint
    ) -> str:
        """Say which joint is too far from where it should be; nothing where none is.

        Args:
            joints: Names of the joints of both points.
            desired: Where they should be; how fast, where that is said.
            actual: Where they are, and how fast.
        """
        for each in self.stated:
            place = joints.index(each.name)
            for what, most, wanted, found in (
                ("position", each.position, desired.positions, actual.positions),
                ("velocity", each.velocity, desired.velocities, actual.velocities),
            ):
                off = abs(wanted[place] - found[place]) if wanted else 0.0
                if 0.0 < most < off:
                    return f"{each.name}: its {what} is off by {off:.3g}, and may be by {most:.3g}"
        return ""


def tolerances_of(goal: FollowJointTrajectoryGoal) -> tuple[Tolerances, Tolerances]:
    """Return the tolerances of a goal: on the way, and at its end.

    0 leaves it to the controller and -1 frees the joint: both mean no bound here.

    Raises:
        JointNotFound: If one is of a joint that the trajectory does not move.
        ProblemError: If one cannot be watched.
    """
    if goal.component_path_tolerance or goal.component_goal_tolerance:
        raise ProblemError("tolerances of joints of several degrees of freedom are not supported")
    for each in (*goal.path_tolerance, *goal.goal_tolerance):
        if each.name not in goal.trajectory.joint_names:
            raise JointNotFound("joint", each.name, goal.trajectory.joint_names)
        if each.acceleration > 0.0:
            raise ProblemError(f"{each.name}: the acceleration is not measured, so has no tolerance")
    return Tolerances(goal.path_tolerance), Tolerances(goal.goal_tolerance)
