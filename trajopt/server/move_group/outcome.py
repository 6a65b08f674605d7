"""Execution of a motion, and its outcome."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from inspect import getmembers_static, isfunction
from typing import ParamSpec, TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from trajopt.driving.soonest_stop import StopTaken
from trajopt.files.messages import MoveItErrorCodes
from trajopt.planning.result import Result, Status
from trajopt.robot.joints import joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.errors import NameNotFound, TrajoptError, shown
from trajopt.values.printed import in_joint_position, in_unit
from trajopt.values.trajectory import Trajectory

CODES = {
    Status.SOLVED: MoveItErrorCodes.SUCCESS,
    Status.START_IN_COLLISION: MoveItErrorCodes.START_STATE_IN_COLLISION,
    Status.CLEARANCE_IMPOSSIBLE: MoveItErrorCodes.START_STATE_IN_COLLISION,
    Status.START_OUT_OF_LIMITS: MoveItErrorCodes.START_STATE_INVALID,
    Status.START_TOO_FAST: MoveItErrorCodes.START_STATE_INVALID,
    Status.START_CANNOT_BE_HELD: MoveItErrorCodes.START_STATE_INVALID,
    Status.START_BREAKS_CONSTRAINT: MoveItErrorCodes.START_STATE_VIOLATES_PATH_CONSTRAINTS,
    Status.GOAL_IN_COLLISION: MoveItErrorCodes.GOAL_IN_COLLISION,
    Status.GOAL_OUT_OF_LIMITS: MoveItErrorCodes.GOAL_STATE_INVALID,
    Status.GOAL_CANNOT_BE_HELD: MoveItErrorCodes.GOAL_STATE_INVALID,
    Status.GOAL_BREAKS_CONSTRAINT: MoveItErrorCodes.GOAL_VIOLATES_PATH_CONSTRAINTS,
    Status.NO_INVERSE_KINEMATICS: MoveItErrorCodes.NO_IK_SOLUTION,
    Status.NO_WAYPOINT: MoveItErrorCodes.NO_IK_SOLUTION,
    Status.METHOD_CANNOT: MoveItErrorCodes.PLANNING_FAILED,
    Status.CONFLICTING_CONSTRAINTS: MoveItErrorCodes.GOAL_CONSTRAINTS_VIOLATED,
    Status.STUCK: MoveItErrorCodes.PLANNING_FAILED,
    Status.PROVEN_INFEASIBLE: MoveItErrorCodes.PLANNING_FAILED,
    Status.TOO_LATE: MoveItErrorCodes.PLANNING_FAILED,
    Status.BLOCKED_IN_TIME: MoveItErrorCodes.PLANNING_FAILED,
    Status.INEVITABLE: MoveItErrorCodes.START_STATE_IN_COLLISION,
    Status.FIXED_LINK_MET: MoveItErrorCodes.START_STATE_IN_COLLISION,
    Status.GOAL_OCCUPIED: MoveItErrorCodes.GOAL_IN_COLLISION,
    Status.NO_SEED: MoveItErrorCodes.PLANNING_FAILED,
    Status.OUT_OF_TIME: MoveItErrorCodes.TIMED_OUT,
    Status.OUT_OF_WORK: MoveItErrorCodes.TIMED_OUT,
    Status.CANCELLED: MoveItErrorCodes.PREEMPTED,
    Status.COLLISION: MoveItErrorCodes.INVALID_MOTION_PLAN,
    Status.JOINT_LIMIT: MoveItErrorCodes.INVALID_MOTION_PLAN,
    Status.OUT_OF_REACH: MoveItErrorCodes.NO_IK_SOLUTION,
    Status.BRANCH_JUMP: MoveItErrorCodes.INVALID_MOTION_PLAN,
    Status.GRIPPER_CANNOT: MoveItErrorCodes.PLANNING_FAILED,
    Status.STAGE_LIMITS: MoveItErrorCodes.PLANNING_FAILED,
    Status.NO_TIMING: MoveItErrorCodes.INVALID_MOTION_PLAN,
    Status.NOT_VERIFIED: MoveItErrorCodes.INVALID_MOTION_PLAN,
}
"""MoveIt's number of every way in which planning ends."""


@dataclass(frozen=True)
class ExecutionOutcome:
    """Outcome of the last `go` or `execute`.

    Attributes:
        joint_error: Largest joint error at the end of the trajectory [rad | m]; None if
            nothing was executed, or the motion is in progress.
        position_error: Position error of the end effector [m]; None if the group has none.
        stopping_time: From `stop()` to rest [s]; None unless the motion was stopped.
    """

    error_code: MoveItErrorCodes
    joint_error: float | None = None
    position_error: float | None = None
    rotation_error: float | None = None
    stopping_time: float | None = None

    @property
    def reached(self) -> bool:
        """Whether the goal was reached."""
        return self.error_code.val == MoveItErrorCodes.SUCCESS and self.joint_error is not None


def code_of(result: Result) -> MoveItErrorCodes:
    """Return MoveIt's number of how planning ended, with the reason."""
    return MoveItErrorCodes(CODES[result.status], result.reason, "trajopt")


P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C", bound=type)


class MoveItCommanderException(TrajoptError):
    """An invalid request; the message names the offender."""


class NoStandIn(MoveItCommanderException, AttributeError):
    """A name of ROS or MoveIt that a script uses cannot be stood in for."""


def full_message(error: TrajoptError) -> str:
    if not isinstance(error, NameNotFound):
        return str(error)
    near = f" (did you mean {shown(error.near[0])}?)" if error.near else ""
    there = ", ".join(error.known) or "none"
    return f"no {error.kind} named {shown(error.name)}{near}; there are: {there}"


def as_moveit(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function with trajopt's errors raised as MoveIt's; the original is the `__cause__`."""

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except MoveItCommanderException:
            raise
        except TrajoptError as error:
            raise MoveItCommanderException(full_message(error)) from error

    return call


def speaks_moveit(cls: C) -> C:
    """Make every public method of a class, and its constructor, raise MoveIt's exception."""
    for name, function in getmembers_static(cls, isfunction):
        if name == "__init__" or not name.startswith("_"):
            setattr(cls, name, as_moveit(function))
    return cls


START_TOLERANCE = 0.01
"""Largest distance of a trajectory's start from the robot, for each joint [rad | m] (MoveIt's)."""
REACHED = 1e-3
"""A joint this near to the end of the trajectory has reached it [rad | m]."""


@dataclass(frozen=True, eq=False)
class Execution:
    """A trajectory that is executed."""

    reduced: ReducedModel
    trajectory: Trajectory
    tip: str

    def refusal(self, positions: Floats) -> ExecutionOutcome | None:
        """Return why the trajectory cannot be executed now from positions [rad | m], if any."""
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

    def measured(
        self, positions: Floats, remark: str = "", *, stop: StopTaken | None = None, met: bool = False
    ) -> ExecutionOutcome:
        """Compare the robot's positions [rad | m] with the end of the trajectory.

        Args:
            met: Whether it was stopped for a contact in a changed scene.
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
            changed = MoveItErrorCodes.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
            code = MoveItErrorCodes(changed if met else MoveItErrorCodes.PREEMPTED, words, "execution")
        elif error <= REACHED:
            code = MoveItErrorCodes(MoveItErrorCodes.SUCCESS, f"ended {said}", "execution")
        else:
            code = MoveItErrorCodes(MoveItErrorCodes.CONTROL_FAILED, f"ended {said}", "execution")
        took = None if stop is None else stop.duration
        if not self.tip:
            return ExecutionOutcome(code, error, stopping_time=took)
        between = scene.placement_of(self.tip, wanted).inverse() * scene.placement_of(self.tip, positions)
        angle = float(Rotation.from_matrix(between.rotation).magnitude())
        return ExecutionOutcome(code, error, float(np.linalg.norm(between.translation)), angle, took)


def _how(stop: StopTaken) -> str:
    path = "on its path" if stop.along else "off its path"
    return path if stop.proven else f"{path} and not proven"


def not_executed(reason: str) -> ExecutionOutcome:
    """Return the outcome of a motion that did not start."""
    return ExecutionOutcome(MoveItErrorCodes(MoveItErrorCodes.CONTROL_FAILED, reason, "execution"))
