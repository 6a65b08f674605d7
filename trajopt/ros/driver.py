"""An executor for `FollowJointTrajectory`: joint trajectory controllers of ros2_control and ros_control."""

import time
import uuid
from collections.abc import Callable, Mapping
from contextlib import suppress
from copy import copy
from dataclasses import dataclass
from itertools import count
from math import inf
from threading import Event, Lock, Thread
from typing import cast

import numpy as np
from numpy.typing import ArrayLike
from websockets.exceptions import ConnectionClosed, WebSocketException
from websockets.sync.client import connect

from trajopt.driving import CommittedMotion, RobotState
from trajopt.files import messages as msg
from trajopt.files.messages import decode, encode
from trajopt.files.moveit.trajectories import planar_joints, trajectory_message
from trajopt.ros.rosbridge.wire import Incoming, parsed, plain, written
from trajopt.values.arrays import Floats, floats, positive
from trajopt.values.documents.document import Node
from trajopt.values.errors import ExecutionError, ProblemError, TrajoptError, shown
from trajopt.values.errors.arguments import checked_class
from trajopt.values.trajectory import Trajectory

DRIFT = 1e-4
"""Bound on the relative drift of two clocks; quartz keeps 1e-4."""
SETTLING = 0.5
"""Time during which stamps are compared with this machine's clock before the first motion [s]."""


class RosClock:
    """The clock of stamps, estimated from their arrival times; it starts at 0 with the first.

    The shortest delay is assumed to be zero (the minimum filter of NTP: RFC 5905, section 10), and grows by
    `DRIFT`.
    """

    def __init__(self, first: msg.Time) -> None:
        self._origin, now = first.to_nsec(), time.monotonic()
        self._estimate = now, now

    def __call__(self) -> float:
        made, begin = self._estimate
        now = time.monotonic()
        return now - begin - DRIFT * (now - made)

    def heard(self, stamp: msg.Time) -> float:
        since = 1e-9 * (stamp.to_nsec() - self._origin)
        made, begin = self._estimate
        now = time.monotonic()
        self._estimate = now, min(begin + DRIFT * (now - made), now - since)
        return since

    def stamp(self, moment: float) -> msg.Time:
        return msg.Time(0, self._origin + round(1e9 * moment))


@dataclass(frozen=True, eq=False)
class _Measured:
    """A message of joint states: when it was measured [s], positions and velocities, shape (n,)."""

    stamp: float
    positions: Floats
    velocities: Floats


@checked_class
class FollowJointTrajectoryExecutor:
    """Drives a robot through rosbridge, by the action `FollowJointTrajectory` and the topic of joint states.

    Its clock is the ROS stamps', which must run in real time. See docs/drivers.md#a-robot-in-ros.
    """

    def __init__(
        self,
        url: str,
        joint_names: tuple[str, ...],
        *,
        tolerance: float | Floats,
        action: str = "/joint_trajectory_controller/follow_joint_trajectory",
        joint_states: str = "/joint_states",
        generation: msg.Generation = msg.Generation.ROS2,
        period: float = 0.01,
        latency: float = 0.1,
        silence: float = 0.5,
        timeout: float = 5.0,
    ) -> None:
        """Connect, and wait for joint states; the robot must be at rest.

        Args:
            tolerance: Largest tracking error of each joint, one number for all or shape (n,) [rad | m].
            joint_states: Name of the topic of `sensor_msgs/JointState`; messages of other joints are ignored.
            generation: ROS 2 with actions, or ROS 1 with the topics of actionlib.
            period: Control period of the controller [s].
            latency: Longest time from `splice` until the controller has the goal [s].
            silence: Longest age of joint states before a fault is reported [s].

        Raises:
            ExecutionError: If no server answers, or no stamped joint states arrive.
            ProblemError: If a time is not positive, a tolerance is negative, or a joint belongs to a base.
            ShapeError: If the tolerance is not one finite number for each joint.
        """
        named = {"period": period, "latency": latency, "silence": silence, "timeout": timeout}
        for name, value in named.items():
            positive(name, value)
        if planar := list(planar_joints(joint_names)):
            raise ProblemError(
                f"joint_names: a joint trajectory controller does not drive a base ({planar[0]})"
            )
        size = len(joint_names)
        allowed = np.full(size, tolerance) if isinstance(tolerance, float | int) else tolerance
        self.joint_names, self.period, self.latency = joint_names, period, latency
        self.tolerance: Floats = floats("tolerance", allowed, (size,))
        if self.tolerance.min(initial=0.0) < 0.0:
            raise ProblemError(f"tolerance must not be negative, is {shown(self.tolerance.tolist())}")
        self._silence, self._topic, self._generation = silence, joint_states, generation
        kind = Ros2Action if generation is msg.Generation.ROS2 else Ros1Action
        self._action = kind(action)
        self._failure, self._goal = "", ""
        self._numbers, self._name = count(1), uuid.uuid4().hex
        self._lock, self._first = Lock(), Event()
        self._clock: RosClock | None = None
        self._measured: _Measured | None = None
        self._client = RosbridgeClient(url, timeout=timeout, heard=self._heard)
        self._action.begin(self._client)
        self._client.send(op="subscribe", topic=joint_states, type="sensor_msgs/JointState", queue_length=1)
        if not self._first.wait(timeout):
            reason = self._client.failure or f"no message with all joints and a stamp came in {timeout:g} s"
            self._client.close()
            raise ExecutionError(f"{joint_states}: {reason}")
        time.sleep(SETTLING)
        self.committed = CommittedMotion(joint_names, self._last.positions)

    def now(self) -> float:
        clock = self._clock
        assert clock is not None  # the constructor waits for it
        return clock()

    def state(self) -> RobotState:
        last = self._last
        commanded, _, accelerations = self.committed(last.stamp)
        return RobotState(last.stamp, last.positions, last.velocities, accelerations, commanded)

    def splice(self, trajectory: Trajectory, at: float) -> str:
        with self._lock:
            now, planned = self.now(), copy(self.committed)
            refused = self.fault() or planned.refusal(trajectory, at, earliest=now + self.latency)
            if refused:
                return refused
            planned.splice(trajectory, at, now=now)
            refused = self._send(planned, now)
            if not refused:
                self.committed = planned
            return refused

    def stop(self) -> None:
        """Cancel the goal: the controller brings the robot to rest in its own way."""
        with self._lock:
            self._failure = self._failure or "it was stopped"
            if self._goal:
                self._action.cancel(self._client, self._goal)

    def fault(self) -> str:
        age = self.now() - self._last.stamp
        old = f"the last message of {self._topic} is {age:.2f} s old" if age > self._silence else ""
        return self._failure or self._client.failure or old

    def clear_fault(self) -> None:
        with self._lock:
            self._failure, self._goal = "", ""
            if fault := self.fault():
                raise ExecutionError(f"the fault stays: {fault}; make another executor")
            self.committed = CommittedMotion(self.joint_names, self._last.positions)

    def close(self) -> None:
        self.stop()
        self._client.close()

    def __enter__(self) -> "FollowJointTrajectoryExecutor":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def _last(self) -> _Measured:
        measured = self._measured
        assert measured is not None  # the constructor waits for it
        return measured

    def _send(self, planned: CommittedMotion, now: float) -> str:
        motion = planned.ahead(now, self.joint_names)
        if motion is None:
            return ""
        message = trajectory_message(motion).joint_trajectory
        assert self._clock is not None
        message.header.stamp = self._clock.stamp(now)
        goal_id = f"{self._name}-{next(self._numbers)}"
        before, self._goal = self._goal, goal_id
        refused = self._action.send(self._client, goal_id, msg.FollowJointTrajectoryGoal(message))
        if refused:
            self._goal = before
        return refused

    def _heard(self, incoming: Incoming) -> None:
        if incoming.op == "publish" and incoming.topic == self._topic:
            self._measure(plain(incoming.msg))
            return
        ended = self._action.ended(incoming)
        if incoming.op == "status" and incoming.level == "error":
            ended = str(incoming.id), str(plain(incoming.msg))
        if ended is not None and ended[0] == self._goal:  # nothing follows from the end of a replaced goal
            self._goal = ""
            if ended[1]:
                self._failure = self._failure or f"the controller gave up: {ended[1]}"

    def _measure(self, document: object) -> None:
        node = Node(document, self._topic)
        stated = {key: node[key].value for key in ("header", "name")}
        state = decode(msg.JointState, stated, self._generation, name=self._topic)
        stamp = state.header.stamp
        if not stamp.to_nsec() or not set(self.joint_names) <= set(state.name):
            return
        columns = [state.name.index(name) for name in self.joint_names]
        positions = _chosen("position", node["position"].value, columns)
        if positions is None:
            raise ExecutionError(f"{self._topic}: a position is missing, or is not a number")
        if self._clock is None:
            self._clock = RosClock(stamp)
        moment, before = self._clock.heard(stamp), self._measured
        if before is not None and moment <= before.stamp:
            return
        velocities = _chosen("velocity", node["velocity"].value, columns)
        if velocities is None:
            span = inf if before is None else moment - before.stamp
            velocities = (positions - (positions if before is None else before.positions)) / span
        self._measured = _Measured(moment, positions, velocities)
        self._first.set()


def _chosen(name: str, stated: object, columns: list[int]) -> Floats | None:
    if not isinstance(stated, list) or len(cast(list[object], stated)) <= max(columns):
        return None
    values = [cast(list[object], stated)[column] for column in columns]
    return None if None in values else floats(name, cast(ArrayLike, values), (len(columns),))


class RosbridgeClient:
    """A connection; `failure` is empty while it works."""

    def __init__(self, url: str, *, timeout: float, heard: Callable[[Incoming], None]) -> None:
        """Connect to a server such as "ws://robot:9090"; `heard` gets each operation, in a thread."""
        try:
            self._socket = connect(url, open_timeout=timeout, close_timeout=timeout)
        except (OSError, WebSocketException, ValueError) as error:
            raise ExecutionError(f"cannot connect to {shown(url)}: {error}") from error
        self.failure, self._heard = "", heard
        self._reader = Thread(target=self._read, name="rosbridge", daemon=True)
        self._reader.start()

    def send(self, **operation: object) -> str:
        if not self.failure:
            try:
                self._socket.send(written(operation).decode())
            except ConnectionClosed as error:
                self.failure = f"the connection to rosbridge is closed: {error}"
        return self.failure

    def close(self) -> None:
        self.failure = self.failure or "the connection to rosbridge was closed here"
        with suppress(WebSocketException, OSError):
            self._socket.close()
        self._reader.join()

    def _read(self) -> None:
        try:
            for text in self._socket:
                self._heard(parsed(text))
        except ConnectionClosed as error:
            self.failure = self.failure or f"the connection to rosbridge is closed: {error}"
        except TrajoptError as error:
            self.failure = self.failure or f"rosbridge sent a message that cannot be read: {error}"
        self.failure = self.failure or "the rosbridge server has closed the connection"


SUCCEEDED = 4
"""Status of a goal that was reached (`action_msgs/GoalStatus`)."""


class Ros2Action:
    """The operations of the rosbridge protocol, version 2, for actions of ROS 2."""

    def __init__(self, name: str) -> None:
        self._name = name

    def begin(self, client: RosbridgeClient) -> None:
        """Do nothing; results arrive without a subscription."""

    def send(self, client: RosbridgeClient, goal_id: str, goal: msg.FollowJointTrajectoryGoal) -> str:
        return client.send(
            op="send_action_goal",
            id=goal_id,
            action=self._name,
            action_type="control_msgs/action/FollowJointTrajectory",
            args=encode(goal, msg.Generation.ROS2),
            feedback=False,
        )

    def cancel(self, client: RosbridgeClient, goal_id: str) -> None:
        client.send(op="cancel_action_goal", id=goal_id, action=self._name)

    def ended(self, incoming: Incoming) -> tuple[str, str] | None:
        if incoming.op != "action_result":
            return None
        done = incoming.result and incoming.status == SUCCEEDED
        values = plain(incoming.values)
        text = cast(Mapping[str, object], values).get("error_string") if isinstance(values, dict) else values
        reason = str(text) if text else f"its status is {incoming.status}"
        return str(incoming.id), "" if done else reason


class Ros1Action:
    """The topics of actionlib (ROS 1)."""

    def __init__(self, name: str) -> None:
        self._name, self._result = name, f"{name}/result"

    def begin(self, client: RosbridgeClient) -> None:
        kind = "control_msgs/FollowJointTrajectoryAction"
        client.send(op="subscribe", topic=self._result, type=f"{kind}Result")
        client.send(op="advertise", topic=f"{self._name}/goal", type=f"{kind}Goal")
        client.send(op="advertise", topic=f"{self._name}/cancel", type="actionlib_msgs/GoalID")

    def send(self, client: RosbridgeClient, goal_id: str, goal: msg.FollowJointTrajectoryGoal) -> str:
        now = msg.Time.now()
        message = {
            "header": encode(msg.Header(stamp=now), msg.Generation.ROS1),
            "goal_id": encode(msg.GoalID(now, goal_id), msg.Generation.ROS1),
            "goal": encode(goal, msg.Generation.ROS1),
        }
        return client.send(op="publish", topic=f"{self._name}/goal", msg=message)

    def cancel(self, client: RosbridgeClient, goal_id: str) -> None:
        meant = encode(msg.GoalID(id=goal_id), msg.Generation.ROS1)
        client.send(op="publish", topic=f"{self._name}/cancel", msg=meant)

    def ended(self, incoming: Incoming) -> tuple[str, str] | None:
        if incoming.op != "publish" or incoming.topic != self._result:
            return None
        status = decode(
            msg.FollowJointTrajectoryActionResult, plain(incoming.msg), msg.Generation.ROS1, name=self._result
        ).status
        reason = status.text or f"its status is {status.status}"
        return status.goal_id.id, "" if status.status == msg.GoalStatus.SUCCEEDED else reason
