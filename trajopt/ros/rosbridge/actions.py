"""MoveIt's services and actions for clients made for ROS, and the goals that they send."""

import asyncio
import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from itertools import count
from typing import Any

import msgspec

from trajopt.files import messages as msg
from trajopt.files.messages import decode, encode, plain_name
from trajopt.ros.rosbridge.cell import Cell
from trajopt.ros.rosbridge.topics import Topics
from trajopt.ros.rosbridge.wire import Unusable
from trajopt.server.job import Cancellation
from trajopt.values.errors import TrajoptError, shown


@dataclass(frozen=True)
class Endpoint:
    """A topic, service or action of MoveIt, and the operation that processes its messages.

    Attributes:
        kind: Type of its messages, without the suffixes of requests, responses and goals.
        operation: Operation of a worker; empty for an action whose goal is planned first.
    """

    kind: str
    operation: str


EDITS: Mapping[str, Endpoint] = {
    "/planning_scene": Endpoint("moveit_msgs/PlanningScene", "moveit/apply_planning_scene"),
    "/collision_object": Endpoint("moveit_msgs/CollisionObject", "moveit/collision_object"),
    "/attached_collision_object": Endpoint(
        "moveit_msgs/AttachedCollisionObject", "moveit/attached_collision_object"
    ),
}
"""Topics that change the scene."""
CLOUD = Endpoint("sensor_msgs/PointCloud2", "moveit/point_cloud")
"""The topic of a camera."""
SERVICES: Mapping[str, Endpoint] = {
    f"/{name}": Endpoint(f"moveit_msgs/{kind}", f"moveit/{name}")
    for name, kind in {
        "compute_fk": "GetPositionFK",
        "compute_ik": "GetPositionIK",
        "plan_kinematic_path": "GetMotionPlan",
        "compute_cartesian_path": "GetCartesianPath",
        "check_state_validity": "GetStateValidity",
        "get_planning_scene": "GetPlanningScene",
        "apply_planning_scene": "ApplyPlanningScene",
    }.items()
}
_EXECUTE = Endpoint("moveit_msgs/ExecuteTrajectory", "moveit/execute_trajectory")
_FOLLOW = Endpoint("control_msgs/FollowJointTrajectory", "moveit/follow_joint_trajectory")
_MOVE = Endpoint("moveit_msgs/MoveGroup", "")
ACTIONS: Mapping[str, Endpoint] = {
    "/execute_trajectory": _EXECUTE,
    "/move_action": _MOVE,
    "/move_group": _MOVE,
    "/joint_trajectory_action": _FOLLOW,
    "/follow_joint_trajectory": _FOLLOW,
}
"""The actions by name; `/move_group` is ROS 1's name of `/move_action`."""


def same_type(named: str | None, kind: str) -> bool:
    return not named or plain_name(named).removesuffix("Action") == kind


class GoalOutcome(Enum):
    """A final status of a goal, as numbered in ROS 1 and in ROS 2."""

    SUCCEEDED = (3, 4)
    CANCELLED = (2, 5)
    ABORTED = (4, 6)

    def __init__(self, ros1: int, ros2: int) -> None:
        self.ros1, self.ros2 = ros1, ros2


class _Options(msgspec.Struct, forbid_unknown_fields=True):
    planning_scene_diff: msgspec.Raw = msgspec.Raw(b"null")
    plan_only: bool = False
    look_around: bool = False
    look_around_attempts: int = 0
    max_safe_execution_cost: float = 0.0
    replan: bool = False
    replan_attempts: int = 0
    replan_delay: float = 0.0


class _MoveGoal(msgspec.Struct, forbid_unknown_fields=True):
    request: msgspec.Raw = msgspec.Raw(b"{}")
    planning_options: _Options = msgspec.field(default_factory=_Options)


class _Planned(msgspec.Struct):
    trajectory_start: dict[str, Any]
    trajectory: dict[str, Any]
    planning_time: float
    error_code: dict[str, Any]


class _Plan(msgspec.Struct):
    motion_plan_response: _Planned


@dataclass(eq=False)
class ActionGoal:
    """A goal, with the listener of its feedback, plain data or JSON."""

    name: str
    server: Endpoint
    message: msgspec.Raw
    generation: msg.Generation
    tell: Callable[[object], None]
    cancellation: Cancellation = field(default_factory=Cancellation)
    cancelled: bool = False

    def cancel(self) -> None:
        self.cancelled = True
        self.cancellation()

    async def run(self, cell: Cell) -> tuple[GoalOutcome, dict[str, Any]]:
        if self.server.operation:
            result = msgspec.json.decode(await self._driven(cell, self.server.operation, self.message))
        else:
            result = await self._moved(cell)
        return self._ending(result["error_code"]), result

    def _ending(self, code: int | dict[str, Any]) -> GoalOutcome:
        if self.cancelled:
            return GoalOutcome.CANCELLED
        done = code == 0 if isinstance(code, int) else code["val"] == msg.MoveItErrorCodes.SUCCESS
        return GoalOutcome.SUCCEEDED if done else GoalOutcome.ABORTED

    async def _driven(self, cell: Cell, operation: str, message: msgspec.Raw | bytes) -> bytes:
        return await cell.ask(
            operation, message, self.generation, listener=self._heard, cancellation=self.cancellation
        )

    def _heard(self, told: msgspec.Raw) -> None:
        feedback = msgspec.json.decode(told).get("feedback")
        if feedback is not None:
            self.tell(feedback)

    async def _moved(self, cell: Cell) -> dict[str, Any]:
        try:
            goal = msgspec.json.decode(self.message, type=_MoveGoal)
        except (msgspec.MsgspecError, RecursionError) as error:
            raise Unusable(f"no goal of MoveGroup: {error}") from error
        options = goal.planning_options
        self.tell({"state": "PLANNING"})
        answer = await cell.ask(
            "moveit/plan_kinematic_path",
            b'{"motion_plan_request":%s}' % bytes(goal.request),
            self.generation,
            difference=bytes(options.planning_scene_diff),
            cancellation=self.cancellation,
        )
        plan = msgspec.json.decode(answer, type=_Plan).motion_plan_response
        result = encode(msg.MoveGroupResult(planning_time=plan.planning_time), self.generation)
        assert isinstance(result, dict)
        found: dict[str, Any] = {
            **result,
            "error_code": plan.error_code,
            "trajectory_start": plan.trajectory_start,
            "planned_trajectory": plan.trajectory,
        }
        if plan.error_code["val"] != msg.MoveItErrorCodes.SUCCESS or options.plan_only or self.cancelled:
            return found
        driven = msgspec.json.encode({"trajectory": plan.trajectory})
        executed = msgspec.json.decode(await self._driven(cell, "moveit/execute_trajectory", driven))
        self.tell({"state": "IDLE"})
        done = executed["error_code"]["val"] == msg.MoveItErrorCodes.SUCCESS
        driven_path = plan.trajectory if done else found["executed_trajectory"]
        return {**found, "error_code": executed["error_code"], "executed_trajectory": driven_path}


_LOG = logging.getLogger("trajopt.server")
GOALS = 8
"""Most goals of an action in progress at a time."""
REMEMBERED = 5.0
"""Time for which the status of a finished goal is published [s], as in actionlib."""
OLD = msg.Generation.ROS1


class _Goal(msgspec.Struct):
    goal_id: msgspec.Raw = msgspec.Raw(b"{}")
    header: msgspec.Raw = msgspec.Raw(b"{}")
    goal: msgspec.Raw = msgspec.Raw(b"{}")


class OldActions:
    """The topics of all actions."""

    def __init__(self, topics: Topics, cell: Cell) -> None:
        self._topics, self._cell, self._numbers = topics, cell, count(1)
        self._goals: dict[str, dict[str, tuple[msg.GoalStatus, ActionGoal]]] = {name: {} for name in ACTIONS}
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
        taker = self._takers.get(topic)
        if taker is not None:
            taker(message)
        return taker is not None

    def tell(self) -> None:
        now = time.monotonic()
        for action, goals in self._goals.items():
            for name in [key for key in goals if now - self._over.get(f"{action}#{key}", now) > REMEMBERED]:
                del goals[name], self._over[f"{action}#{name}"]
            if self._topics.heard(f"{action}/status"):
                statuses = [status for status, _ in goals.values()]
                array = msg.GoalStatusArray(msg.Header(stamp=msg.Time.now()), statuses)
                self._topics.tell(f"{action}/status", encode(array, OLD))

    def close(self) -> None:
        for goals in self._goals.values():
            for _, goal in goals.values():
                goal.cancel()
        for task in self._tasks:
            task.cancel()

    def _goal_taker(self, action: str, server: Endpoint) -> Callable[[msgspec.Raw], None]:
        def take(message: msgspec.Raw) -> None:
            try:
                whole = msgspec.json.decode(message, type=_Goal)
                mine = decode(msg.GoalID, msgspec.json.decode(whole.goal_id), OLD, name="goal_id")
            except (msgspec.MsgspecError, RecursionError) as error:
                raise Unusable(f"no goal of {action}: {error}") from error
            except TrajoptError as error:
                raise Unusable(str(error)) from error
            goals = self._goals[action]
            mine.id = mine.id or f"{action}-{next(self._numbers)}"
            running = sum(status.status == msg.GoalStatus.ACTIVE for status, _ in goals.values())
            if mine.id in goals or running >= GOALS:
                raise Unusable(f"a goal {shown(mine.id)} is known already, or {GOALS} are under way")
            status = msg.GoalStatus(mine, msg.GoalStatus.ACTIVE)

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
                meant = decode(msg.GoalID, msgspec.json.decode(message), OLD, name="cancel")
            except TrajoptError as error:
                raise Unusable(str(error)) from error
            for name, (status, goal) in self._goals[action].items():
                if meant.id in ("", name) and status.status == msg.GoalStatus.ACTIVE:
                    status.status = msg.GoalStatus.PREEMPTING
                    goal.cancel()

        return take

    async def _pursue(self, action: str, goal: ActionGoal, status: msg.GoalStatus) -> None:
        result: dict[str, Any] = {}
        try:
            ending, result = await goal.run(self._cell)
            status.status = ending.ros1
        except TrajoptError as error:
            cancelled = goal.cancelled
            status.status = GoalOutcome.CANCELLED.ros1 if cancelled else msg.GoalStatus.REJECTED
            status.text = str(error)
            _LOG.info("goal refused", extra={"action": action, "reason": str(error)})
        self._over[f"{action}#{goal.name}"] = time.monotonic()
        self.tell()
        self._publish(f"{action}/result", status, "result", result)

    def _publish(self, topic: str, status: msg.GoalStatus, what: str, document: object) -> None:
        header = encode(msg.Header(stamp=msg.Time.now()), OLD)
        self._topics.tell(topic, {"header": header, "status": encode(status, OLD), what: document})
