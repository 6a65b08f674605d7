"""Goals of actions, processed as by MoveIt's action servers, for every client and transport."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import msgspec

from trajopt.files.messages import Generation, MoveGroupResult, MoveItErrorCodes, encode
from trajopt.ros.rosbridge.cell import Cell
from trajopt.ros.rosbridge.services import ActionServer
from trajopt.ros.rosbridge.wire import Unusable
from trajopt.server.requests import Cancellation


class GoalOutcome(Enum):
    """How a goal ended.

    Attributes:
        ros1: Number of the status in ROS 1.
        ros2: Number of the status in ROS 2.
    """

    SUCCEEDED = (3, 4)
    CANCELLED = (2, 5)
    ABORTED = (4, 6)

    def __init__(self, ros1: int, ros2: int) -> None:
        """Keep the numbers."""
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
    """A goal.

    Attributes:
        name: Its id.
        server: The action.
        message: The goal message, JSON.
        generation: Format of the goal, feedback and result.
        tell: Called with feedback, as plain data or JSON.
        cancellation: Ends it.
        cancelled: Whether cancellation was requested.
    """

    name: str
    server: ActionServer
    message: msgspec.Raw
    generation: Generation
    tell: Callable[[object], None]
    cancellation: Cancellation = field(default_factory=Cancellation)
    cancelled: bool = False

    def cancel(self) -> None:
        """Cancel the goal: the robot stops."""
        self.cancelled = True
        self.cancellation()

    async def run(self, cell: Cell) -> tuple[GoalOutcome, dict[str, Any]]:
        """Do it; return how it ended, and the result as plain data.

        Args:
            cell: The cell.

        Raises:
            Unusable: If the goal cannot be processed.
        """
        if self.server.operation:
            result = msgspec.json.decode(await self._driven(cell, self.server.operation, self.message))
        else:
            result = await self._moved(cell)
        return self._ending(result["error_code"]), result

    def _ending(self, code: int | dict[str, Any]) -> GoalOutcome:
        if self.cancelled:
            return GoalOutcome.CANCELLED
        done = code == 0 if isinstance(code, int) else code["val"] == MoveItErrorCodes.SUCCESS
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
        """Plan a motion, and drive it unless only the plan is requested."""
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
        result = encode(MoveGroupResult(planning_time=plan.planning_time), self.generation)
        assert isinstance(result, dict)
        found: dict[str, Any] = {
            **result,
            "error_code": plan.error_code,
            "trajectory_start": plan.trajectory_start,
            "planned_trajectory": plan.trajectory,
        }
        if plan.error_code["val"] != MoveItErrorCodes.SUCCESS or options.plan_only or self.cancelled:
            return found
        driven = msgspec.json.encode({"trajectory": plan.trajectory})
        executed = msgspec.json.decode(await self._driven(cell, "moveit/execute_trajectory", driven))
        self.tell({"state": "IDLE"})
        done = executed["error_code"]["val"] == MoveItErrorCodes.SUCCESS
        driven_path = plan.trajectory if done else found["executed_trajectory"]
        return {**found, "error_code": executed["error_code"], "executed_trajectory": driven_path}
