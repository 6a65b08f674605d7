"""Actions in ROS 1's way: five topics each, `NAME/goal`, `cancel`, `status`, `feedback` and `result`."""

import asyncio
import logging
import time
from collections.abc import Callable
from itertools import count
from typing import Any

import msgspec

from trajopt.files.messages import (
    Generation,
    GoalID,
    GoalStatus,
    GoalStatusArray,
    Header,
    Time,
    decode,
    encode,
)
from trajopt.ros.rosbridge.cell import Cell
from trajopt.ros.rosbridge.goals import ActionGoal, GoalOutcome
from trajopt.ros.rosbridge.services import ACTIONS, ActionServer
from trajopt.ros.rosbridge.topics import Topics
from trajopt.ros.rosbridge.wire import Unusable
from trajopt.values.errors import TrajoptError, shown

_LOG = logging.getLogger("trajopt.server")
GOALS = 8
"""Most goals of an action in progress at a time."""
REMEMBERED = 5.0
"""Time for which the status of a finished goal is published [s], as in actionlib."""
OLD = Generation.ROS1


class _Goal(msgspec.Struct):
    goal_id: msgspec.Raw = msgspec.Raw(b"{}")
    header: msgspec.Raw = msgspec.Raw(b"{}")
    goal: msgspec.Raw = msgspec.Raw(b"{}")


class OldActions:
    """The topics of all actions."""

    def __init__(self, topics: Topics, cell: Cell) -> None:
        """Announce the status, feedback and result topics, and expect goals and cancellations."""
        self._topics, self._cell, self._numbers = topics, cell, count(1)
        self._goals: dict[str, dict[str, tuple[GoalStatus, ActionGoal]]] = {name: {} for name in ACTIONS}
        self._over: dict[str, float] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._takers: dict[str, Callable[[msgspec.Raw], None]] = {}
        for name, server in ACTIONS.items():
            topics.expect(f"{name}/goal", f"{server.kind}ActionGoal")
            topics.expect(f"{name}/cancel", "actionlib_msgs/GoalID")
            topics.announce(f"{name}/status", "actionlib_msgs/GoalStatusArray")
            topics.announce(f"{name}/feedback", f"{server.kind}ActionFeedback")
            topics.announce(f"{name}/result", f"{server.kind}ActionResult")
            self._takers[f"{name}/goal"] = self._goal_taker(name, server)
            self._takers[f"{name}/cancel"] = self._cancel_taker(name)

    def take(self, topic: str, message: msgspec.Raw) -> bool:
        """Process a message of one of the topics; return whether the topic is one of them.

        Raises:
            Unusable: If the message cannot be processed.
        """
        taker = self._takers.get(topic)
        if taker is not None:
            taker(message)
        return taker is not None

    def tell(self) -> None:
        """Publish the status of all goals."""
        now = time.monotonic()
        for action, goals in self._goals.items():
            for name in [key for key in goals if now - self._over.get(f"{action}#{key}", now) > REMEMBERED]:
                del goals[name], self._over[f"{action}#{name}"]
            if self._topics.heard(f"{action}/status"):
                statuses = [status for status, _ in goals.values()]
                array = GoalStatusArray(Header(stamp=Time.now()), statuses)
                self._topics.tell(f"{action}/status", encode(array, OLD))

    def close(self) -> None:
        """End all goals."""
        for goals in self._goals.values():
            for _, goal in goals.values():
                goal.cancel()
        for task in self._tasks:
            task.cancel()

    def _goal_taker(self, action: str, server: ActionServer) -> Callable[[msgspec.Raw], None]:
        def take(message: msgspec.Raw) -> None:
            try:
                whole = msgspec.json.decode(message, type=_Goal)
                mine = decode(GoalID, msgspec.json.decode(whole.goal_id), OLD, name="goal_id")
            except (msgspec.MsgspecError, RecursionError) as error:
                raise Unusable(f"no goal of {action}: {error}") from error
            except TrajoptError as error:
                raise Unusable(str(error)) from error
            goals = self._goals[action]
            mine.id = mine.id or f"{action}-{next(self._numbers)}"
            running = sum(status.status == GoalStatus.ACTIVE for status, _ in goals.values())
            if mine.id in goals or running >= GOALS:
                raise Unusable(f"a goal {shown(mine.id)} is known already, or {GOALS} are under way")
            status = GoalStatus(mine, GoalStatus.ACTIVE)

            def tell(feedback: object) -> None:
                self._publish(f"{action}/feedback", status, "feedback", feedback)

            goal = ActionGoal(mine.id, server, whole.goal, OLD, tell)
            goals[mine.id] = status, goal
            task = asyncio.get_running_loop().create_task(self._pursue(action, goal, status))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

        return take

    def _cancel_taker(self, action: str) -> Callable[[msgspec.Raw], None]:
        def take(message: msgspec.Raw) -> None:
            try:
                meant = decode(GoalID, msgspec.json.decode(message), OLD, name="cancel")
            except TrajoptError as error:
                raise Unusable(str(error)) from error
            for name, (status, goal) in self._goals[action].items():
                if meant.id in ("", name) and status.status == GoalStatus.ACTIVE:
                    status.status = GoalStatus.PREEMPTING
                    goal.cancel()

        return take

    async def _pursue(self, action: str, goal: ActionGoal, status: GoalStatus) -> None:
        result: dict[str, Any] = {}
        try:
            ending, result = await goal.run(self._cell)
            status.status = ending.ros1
        except TrajoptError as error:
            cancelled = goal.cancelled
            status.status = GoalOutcome.CANCELLED.ros1 if cancelled else GoalStatus.REJECTED
            status.text = str(error)
            _LOG.info("goal refused", extra={"action": action, "reason": str(error)})
        self._over[f"{action}#{goal.name}"] = time.monotonic()
        self.tell()
        self._publish(f"{action}/result", status, "result", result)

    def _publish(self, topic: str, status: GoalStatus, what: str, document: object) -> None:
        header = encode(Header(stamp=Time.now()), OLD)
        self._topics.tell(topic, {"header": header, "status": encode(status, OLD), what: document})
