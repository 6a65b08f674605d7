"""Data shared by all clients, from the robot's description to its state topics."""

import asyncio
import logging
from typing import Any

import msgspec

from trajopt.files import messages as msg
from trajopt.files.messages import encode, plain_name
from trajopt.optimise.methods import METHODS
from trajopt.ros.rosbridge.actions import ACTIONS, CLOUD, EDITS, SERVICES, OldActions
from trajopt.ros.rosbridge.cell import Cell
from trajopt.ros.rosbridge.description import RobotDescription
from trajopt.ros.rosbridge.offered import OfferedActions, OfferedServices
from trajopt.ros.rosbridge.options import RosbridgeOptions
from trajopt.ros.rosbridge.rosapi import RosApi
from trajopt.ros.rosbridge.topics import Topics
from trajopt.ros.rosbridge.wire import BridgeClient, Incoming, Unusable, plain, written
from trajopt.server.move_group.functions import PIPELINE
from trajopt.values.errors import TrajoptError

_LOG = logging.getLogger("trajopt.server")
PACE = 0.1
"""Period of the robot state and goal status topics [s]."""
SCENE = "/monitored_planning_scene"
PLANNED = "/display_planned_path"


class Bridge:
    """Data shared by the clients of one robot; `largest` limits a message [bytes]."""

    def __init__(self, cell: Cell, description: RobotDescription, options: RosbridgeOptions) -> None:
        self.cell, self.description, self.options = cell, description, options
        self.generation: msg.Generation = options.distro.generation
        self.largest = cell.service.limits.body
        self.topics, self.offered = Topics(self.generation), OfferedServices()
        self.offered_actions = OfferedActions()
        self._api, self._actions = (
            RosApi(self.topics, self.offered, self.offered_actions, description, options),
            OldActions(self.topics, cell),
        )
        self.clients: set[BridgeClient] = set()
        self._look, self._revision = asyncio.Event(), -1
        for name, text in (
            ("/robot_description", description.urdf),
            ("/robot_description_semantic", description.srdf),
        ):
            self.topics.announce(name, "std_msgs/String", {"data": text})
        self.topics.announce("/joint_states", "sensor_msgs/JointState")
        self.topics.announce(SCENE, "moveit_msgs/PlanningScene")
        self.topics.announce(PLANNED, "moveit_msgs/DisplayTrajectory")
        self._edits = {**EDITS, **dict.fromkeys(options.clouds, CLOUD)}
        for name, each in self._edits.items():
            self.topics.expect(name, each.kind)

    def leave(self, client: BridgeClient) -> None:
        self.topics.leave(client)
        self.offered.leave(client)
        self.offered_actions.leave(client)

    def look(self) -> None:
        self._look.set()

    def heard(self, topic: str) -> None:
        if topic == SCENE:
            self._revision = -1
        self.look()

    def offer_service(self, client: BridgeClient, name: str, kind: str) -> None:
        if name in SERVICES or name.startswith("/rosapi/"):
            raise Unusable(f"{name} is a service of the server itself")
        self.offered.offer(client, name, kind)

    @property
    def action_kinds(self) -> dict[str, str]:
        """Types of all actions by name, as ROS 1 writes them, without Action at the end."""
        offered = self.offered_actions.kinds().items()
        own = {name: server.kind for name, server in ACTIONS.items()}
        return {**{name: plain_name(kind).removesuffix("Action") for name, kind in offered}, **own}

    def offer_action(self, client: BridgeClient, name: str, kind: str) -> None:
        if name in ACTIONS:
            raise Unusable(f"{name} is an action of the server itself")
        self.offered_actions.offer(client, name, kind)

    async def call(self, name: str, incoming: Incoming) -> bytes:
        service = SERVICES.get(name)
        if service is not None:
            answer = await self.cell.ask(
                service.operation, incoming.args, self.generation, seconds=_seconds(incoming.timeout)
            )
            if name == "/plan_kinematic_path":
                self._show(answer)
            self.look()
            return answer
        if name.startswith("/rosapi/"):
            return written(self._api.answer(name.removeprefix("/rosapi/"), plain(incoming.args)))
        if name == "/file_server/get_file":
            return written(await self._api.file(plain(incoming.args)))
        if name == "/query_planner_interface":
            return msgspec.json.encode(encode(_planners(), self.generation))
        most = self.cell.service.limits.seconds
        return await self.offered.call(name, incoming.args, min(_seconds(incoming.timeout) or most, most))

    async def published(self, topic: str, message: msgspec.Raw) -> None:
        if self._actions.take(topic, message):
            self.look()
            return
        edit = self._edits.get(topic)
        if edit is not None:
            whole = b'{"scene":%s}' % bytes(message) if topic == "/planning_scene" else message
            await self.cell.ask(edit.operation, whole, self.generation)
            self.look()

    async def tell(self) -> None:
        while True:
            self._look.clear()
            self._actions.tell()
            if self.topics.heard("/joint_states"):
                state = msg.JointState(
                    msg.Header(stamp=msg.Time.now()),
                    list(self.cell.joint_names),
                    [float(each) for each in self.cell.session.positions],
                )
                self.topics.tell("/joint_states", encode(state, self.generation))
            if self.topics.heard(SCENE) and self.cell.session.revision != self._revision:
                await self._tell_scene()
            try:
                await asyncio.wait_for(self._look.wait(), PACE)
            except TimeoutError:
                continue

    def close(self) -> None:
        self._actions.close()

    async def _tell_scene(self) -> None:
        revision = self.cell.session.revision
        try:
            answer = await self.cell.ask("moveit/get_planning_scene", b"{}", self.generation)
        except TrajoptError as error:
            _LOG.warning("the scene could not be published", extra={"reason": str(error)})
            return
        self._revision = revision
        self.topics.tell(SCENE, msgspec.json.decode(answer)["scene"])

    def _show(self, answer: bytes) -> None:
        if not self.topics.heard(PLANNED):
            return
        plan: dict[str, Any] = msgspec.json.decode(answer)["motion_plan_response"]
        robot = self.cell.service.robots[self.cell.session.robot].name
        trajectories = [plan["trajectory"]]
        shown = {"model_id": robot, "trajectory": trajectories, "trajectory_start": plan["trajectory_start"]}
        self.topics.tell(PLANNED, shown)


def _planners() -> msg.QueryPlannerInterfacesResponse:
    return msg.QueryPlannerInterfacesResponse(
        [msg.PlannerInterfaceDescription(PIPELINE, PIPELINE, list(METHODS))]
    )


def _seconds(timeout: float | None) -> float | None:
    return timeout if timeout is not None and timeout > 0.0 else None
