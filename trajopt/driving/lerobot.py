"""LeRobot's robots behind a guard, and as executors.

https://huggingface.co/docs/lerobot/integrate_hardware describes the interface.
"""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from trajopt.driving.guard import Decision, Guard
from trajopt.values.arrays import Floats, Value, number, positive
from trajopt.values.errors import NameNotFound, ProblemError, shown
from trajopt.values.errors.arguments import checked, checked_class


class LeRobotArm(Protocol):
    """The part of LeRobot's `Robot` that drives it."""

    @property
    def action_features(self) -> Mapping[str, Any]:
        """Type of each value of an action."""
        ...

    def get_observation(self) -> dict[str, Any]:
        """Return positions and images by feature."""
        ...

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Move to positions by feature; return those that were sent."""
        ...


@checked
@dataclass(frozen=True)
class MotorJoint(Value):
    """The joint of a motor: its position is scale * value + offset.

    Attributes:
        scale: Per unit of the motor's value [rad | m]; LeRobot's default unit is the degree. Negative if the
            motor turns the other way.
        offset: Position at the motor's zero [rad | m].
    """

    joint: str
    scale: float = math.pi / 180.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        if not number("scale", self.scale):
            raise ProblemError("scale must not be 0")


@checked_class
class LeRobotController:
    """The motors of a LeRobot robot, as a controller for `StreamingExecutor`.

    Attributes:
        others: Actions sent with each command, by feature without guarded joint, such as a gripper's.
    """

    def __init__(
        self,
        robot: LeRobotArm,
        motors: Mapping[str, MotorJoint],
        *,
        resolution: float = 2e-3,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Take over a connected robot.

        Args:
            motors: Feature -> its joint.
            resolution: Changes of a measured position up to this are noise [rad | m]; LeRobot's robots
                measure no velocities, which are differences. A step of 12 bits is 1.5 mrad.

        Raises:
            NameNotFound: If the robot has no such feature.
            ProblemError: If two motors drive the same joint.
        """
        joints = [motor.joint for motor in motors.values()]
        if twice := [joint for joint in joints if joints.count(joint) > 1]:
            raise ProblemError(f"motors: several drive joint {shown(twice[0])}; name one for each joint")
        self.observation, features = robot.get_observation(), robot.action_features
        for feature in motors:
            if feature not in features:
                raise NameNotFound("feature of the robot", feature, features)
        self.others = {name: self.observation[name] for name in features if name not in motors}
        self.motors, self._robot = dict(motors), robot
        self._resolution, self._clock = resolution, clock
        self._scale = np.array([motor.scale for motor in motors.values()])
        self._offset = np.array([motor.offset for motor in motors.values()])
        self._last = clock(), self.positions(self.observation)

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(motor.joint for motor in self.motors.values())

    def positions(self, values: Mapping[str, Any]) -> Floats:
        for feature in self.motors:
            if feature not in values:
                raise NameNotFound("feature", feature, values)
        return self._scale * [_number(values[feature]) for feature in self.motors] + self._offset

    def values(self, positions: Floats) -> dict[str, Any]:
        """Return joint positions, shape (n,) [rad | m], as features."""
        return dict(zip(self.motors, ((positions - self._offset) / self._scale).tolist(), strict=True))

    def measured(self) -> tuple[Floats, Floats]:
        self.observation = self._robot.get_observation()
        (before, old), now, new = self._last, self._clock(), self.positions(self.observation)
        moved, self._last = new - old, (now, new)
        moved[np.abs(moved) <= self._resolution] = 0.0
        return new, moved / (now - before) if now > before else np.zeros(len(new))

    def command(self, positions: Floats, velocities: Floats) -> None:
        del velocities
        self._robot.send_action({**self.values(positions), **self.others})

    def brake(self) -> None:
        self._robot.send_action({**self.values(self.measured()[0]), **self.others})

    def error(self) -> str:
        return ""

    def reset(self) -> None:
        """Do nothing."""


def _number(value: Any) -> float:
    """Return the value; NaN if it is not a number, which the guard and the executor refuse."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan


@checked_class
class GuardedArm:
    """A LeRobot robot behind a guard: actions in, and those that were really sent out.

    An action is reached after 1 / `fps` and the times of a decision and of two commands, so that the next
    action comes before the robot brakes; so the arm is about 0.05 s behind the policy.

    Attributes:
        guard: The guard; `guard.see` reports the world.
        decision: The last decision; None before the first action.
    """

    def __init__(self, controller: LeRobotController, guard: Guard, *, fps: float) -> None:
        """Take over the executor of a guard, driven by the controller, at `fps` actions per second [Hz].

        Raises:
            ProblemError: If the joints of the motors differ from the joints of the guard's group, or `fps` is
                not positive.
        """
        if set(controller.joint_names) != set(guard.problem.reduced.joint_names):
            raise ProblemError(
                f"motors: their joints ({', '.join(controller.joint_names)}) must be those of the group "
                f"({', '.join(guard.problem.reduced.joint_names)})"
            )
        positive("fps", fps)
        self.guard, self._controller = guard, controller
        self.decision: Decision | None = None
        executor = guard.executor
        self._ahead = 1.0 / fps + guard.options.lead + executor.latency + executor.period
        names = controller.joint_names
        self._columns = [names.index(name) for name in guard.problem.reduced.joint_names]

    def observe(self) -> dict[str, Any]:
        """Return the last observation of the robot."""
        return dict(self._controller.observation)

    def send(self, action: Mapping[str, Any]) -> dict[str, Any]:
        """Drive to an action as far as it is proven.

        Features without a joint, such as a gripper's, are sent as they are; their motion is not proven.

        Args:
            action: Values by feature; values of joints that are not numbers stop the robot.

        Returns:
            The action sent: the committed positions at the time of the action.

        Raises:
            NameNotFound: If the value of a joint is missing.
        """
        controller, executor = self._controller, self.guard.executor
        target, now = controller.positions(action)[self._columns], executor.now()
        others = {name: value for name, value in action.items() if name not in controller.motors}
        controller.others = {**controller.others, **others}
        self.decision = self.guard.act(target[None], rate=1.0 / self._ahead, stamp=now)
        committed = self.guard.committed(now + self._ahead)[0]
        return {**controller.values(committed), **controller.others}
