"""The bridge: what all clients share, from the robot's description to its state on topics."""

import asyncio
import logging
from typing import Any, Protocol

import msgspec

from trajopt.files.messages import (
    Generation,
    Header,
    JointState,
    PlannerInterfaceDescription,
    QueryPlannerInterfacesResponse,
    Time,
    encode,
    plain_name,
)
from trajopt.optimise.methods import METHODS
from trajopt.ros.rosbridge.cell import Cell
from trajopt.ros.rosbridge.description import RobotDescription
from trajopt.ros.rosbridge.offered import Offered, Provider
from trajopt.ros.rosbridge.offered_actions import OfferedActions
from trajopt.ros.rosbridge.old_actions import OldActions
from trajopt.ros.rosbridge.options import RosbridgeOptions
from trajopt.ros.rosbridge.rosapi import RosApi
from trajopt.ros.rosbridge.services import ACTIONS, CLOUD, EDITS, SERVICES
from trajopt.ros.rosbridge.topics import TopicClient, Topics
from trajopt.ros.rosbridge.wire import Incoming, Unusable, plain, written
from trajopt.values.errors import TrajoptError

_LOG = logging.getLogger("trajopt.server")
PACE = 0.1
"""Where the robot is, and how its goals are going, is published so often [s]."""
SCENE = "/monitored_planning_scene"
PLANNED = "/display_planned_path"
PIPELINE = "trajopt"


class Connected(TopicClient, Provider, Protocol):
    """A client, as far as the bridge knows it."""


class Bridge:
    """What the clients of one robot share.

    Attributes:
        cell: The robot among its objects.
        description: The robot's files.
        options: Whom it lets in, and which ROS it answers as.
        generation: How it writes messages.
        largest: Size of a message [bytes].
        topics: The topics.
        offered: Services that clients offer.
        offered_actions: Actions that clients offer.
        clients: Who is connected.
    """

    def __init__(self, cell: Cell, description: RobotDescription, options: RosbridgeOptions) -> None:
        """Begin with no clients."""
        self.cell, self.description, self.options = cell, description, options
        self.generation: Generation = options.distro.generation
        self.largest = cell.service.limits.body
        self.topics, self.offered = Topics(self.generation), Offered()
        self.offered_actions = OfferedActions()
        self._api, self._actions = (
            RosApi(self.topics, self.offered, self.offered_actions, description, options),
            OldActions(self.topics, cell),
        )
        self.clients: set[Connected] = set()
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
        for name, (kind, _) in self._edits.items():
            self.topics.expect(name, kind)

    def leave(self, client: Connected) -> None:
        """Forget a client."""
        self.topics.leave(client)
        self.offered.leave(client)
        self.offered_actions.leave(client)

    def look(self) -> None:
        """Publish the state soon: it may have changed."""
        self._look.set()

    def heard(self, topic: str) -> None:
        """Tell soon who has begun to hear a topic."""
        if topic == SCENE:
            self._revision = -1
        self.look()

    def offer_service(self, client: Connected, name: str, kind: str) -> None:
        """Take note of a service that a client offers.

        Raises:
            Unusable: If the server itself, or another client, has one of that name.
        """
        if name in SERVICES or name.startswith("/rosapi/"):
            raise Unusable(f"{name} is a service of the server itself")
        self.offered.offer(client, name, kind)

    @property
    def action_kinds(self) -> dict[str, str]:
        """Types of all actions by name, as ROS 1 writes them, without Action at the end."""
        offered = self.offered_actions.kinds().items()
        own = {name: server.kind for name, server in ACTIONS.items()}
        return {**{name: plain_name(kind).removesuffix("Action") for name, kind in offered}, **own}

    def offer_action(self, client: Connected, name: str, kind: str) -> None:
        """Add an action that a client offers.

        Raises:
            Unusable: If the server itself, or another client, has one of that name.
        """
        if name in ACTIONS:
            raise Unusable(f"{name} is an action of the server itself")
        self.offered_actions.offer(client, name, kind)

    async def call(self, name: str, incoming: Incoming) -> bytes:
        """Call a service; return what it answers, as JSON.

        Raises:
            Unusable: If it cannot answer; it says why.
        """
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
        """Do what a client published, where that is more than to pass it on.

        Raises:
            Unusable: If it cannot be done.
        """
        if self._actions.take(topic, message):
            self.look()
            return
        edit = self._edits.get(topic)
        if edit is not None:
            whole = b'{"scene":%s}' % bytes(message) if topic == "/planning_scene" else message
            await self.cell.ask(edit[1], whole, self.generation)
            self.look()

    async def tell(self) -> None:
        """Publish where the robot is, how goals are going, and the scene where it was changed; for ever."""
        while True:
            self._look.clear()
            self._actions.tell()
            if self.topics.heard("/joint_states"):
                state = JointState(
                    Header(stamp=Time.now()),
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
        """End what is under way."""
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
        """Publish a motion that was planned, for who shows such."""
        if not self.topics.heard(PLANNED):
            return
        plan: dict[str, Any] = msgspec.json.decode(answer)["motion_plan_response"]
        robot = self.cell.service.robots[self.cell.session.robot].name
        trajectories = [plan["trajectory"]]
        shown = {"model_id": robot, "trajectory": trajectories, "trajectory_start": plan["trajectory_start"]}
        self.topics.tell(PLANNED, shown)


def _planners() -> QueryPlannerInterfacesResponse:
    return QueryPlannerInterfacesResponse([PlannerInterfaceDescription(PIPELINE, PIPELINE, list(METHODS))])


def _seconds(timeout: float | None) -> float | None:
    """Return the time that a call may take: none that is positive is the server's own."""
    return timeout if timeout is not None and timeout > 0.0 else None
