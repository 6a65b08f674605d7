"""Sending and cancelling action goals, and reading their results, in ROS 2 and ROS 1."""

from collections.abc import Mapping
from typing import Protocol, cast

from trajopt.files.messages import (
    FollowJointTrajectoryActionResult,
    FollowJointTrajectoryGoal,
    Generation,
    GoalID,
    GoalStatus,
    Header,
    Time,
    decode,
    encode,
)
from trajopt.ros.driver.client import RosbridgeClient
from trajopt.ros.rosbridge.wire import Incoming, plain

SUCCEEDED = 4
"""Status of a goal that was reached (`action_msgs/GoalStatus`)."""


class TrajectoryAction(Protocol):
    """An action of the type FollowJointTrajectory."""

    def begin(self, client: RosbridgeClient) -> None:
        """Prepare a connection."""
        ...

    def send(self, client: RosbridgeClient, goal_id: str, goal: FollowJointTrajectoryGoal) -> str:
        """Send a goal; return the reason if it cannot be sent."""
        ...

    def cancel(self, client: RosbridgeClient, goal_id: str) -> None:
        """Cancel a goal."""
        ...

    def ended(self, incoming: Incoming) -> tuple[str, str] | None:
        """Return the id of the goal that a message ends, and why it failed; None if it ends none."""
        ...


class Ros2Action:
    """The operations of the rosbridge protocol, version 2, for actions of ROS 2."""

    def __init__(self, name: str) -> None:
        """Choose an action by its name."""
        self._name = name

    def begin(self, client: RosbridgeClient) -> None:
        """Do nothing; results arrive without a subscription."""

    def send(self, client: RosbridgeClient, goal_id: str, goal: FollowJointTrajectoryGoal) -> str:
        """Send a goal; return the reason if it cannot be sent."""
        return client.send(
            op="send_action_goal",
            id=goal_id,
            action=self._name,
            action_type="control_msgs/action/FollowJointTrajectory",
            args=encode(goal, Generation.ROS2),
            feedback=False,
        )

    def cancel(self, client: RosbridgeClient, goal_id: str) -> None:
        """Cancel a goal."""
        client.send(op="cancel_action_goal", id=goal_id, action=self._name)

    def ended(self, incoming: Incoming) -> tuple[str, str] | None:
        """Return the id of the goal that a message ends, and why it failed; None if it ends none."""
        if incoming.op != "action_result":
            return None
        done = incoming.result and incoming.status == SUCCEEDED
        reason = _reason(plain(incoming.values), f"its status is {incoming.status}")
        return str(incoming.id), "" if done else reason


class Ros1Action:
    """The topics of actionlib (ROS 1)."""

    def __init__(self, name: str) -> None:
        """Choose an action by its name."""
        self._name, self._result = name, f"{name}/result"

    def begin(self, client: RosbridgeClient) -> None:
        """Subscribe to results, and announce the topics of goals."""
        kind = "control_msgs/FollowJointTrajectoryAction"
        client.send(op="subscribe", topic=self._result, type=f"{kind}Result")
        client.send(op="advertise", topic=f"{self._name}/goal", type=f"{kind}Goal")
        client.send(op="advertise", topic=f"{self._name}/cancel", type="actionlib_msgs/GoalID")

    def send(self, client: RosbridgeClient, goal_id: str, goal: FollowJointTrajectoryGoal) -> str:
        """Send a goal; return the reason if it cannot be sent."""
        now = Time.now()
        message = {
            "header": encode(Header(stamp=now), Generation.ROS1),
            "goal_id": encode(GoalID(now, goal_id), Generation.ROS1),
            "goal": encode(goal, Generation.ROS1),
        }
        return client.send(op="publish", topic=f"{self._name}/goal", msg=message)

    def cancel(self, client: RosbridgeClient, goal_id: str) -> None:
        """Cancel a goal."""
        meant = encode(GoalID(id=goal_id), Generation.ROS1)
        client.send(op="publish", topic=f"{self._name}/cancel", msg=meant)

    def ended(self, incoming: Incoming) -> tuple[str, str] | None:
        """Return the id of the goal that a message ends, and why it failed; None if it ends none."""
        if incoming.op != "publish" or incoming.topic != self._result:
            return None
        status = decode(
            FollowJointTrajectoryActionResult, plain(incoming.msg), Generation.ROS1, name=self._result
        ).status
        reason = status.text or f"its status is {status.status}"
        return status.goal_id.id, "" if status.status == GoalStatus.SUCCEEDED else reason


def _reason(values: object, otherwise: str) -> str:
    """Return why a goal failed: the text of its result, or another text if it has none."""
    text = cast(Mapping[str, object], values).get("error_string") if isinstance(values, dict) else values
    return str(text) if text else otherwise
