"""A connection: requests of one client, and the messages sent to it."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterable
from contextlib import suppress
from typing import Protocol

import msgspec
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from trajopt.ros.rosbridge.actions import ACTIONS, ActionGoal, same_type
from trajopt.ros.rosbridge.bridge import Bridge
from trajopt.ros.rosbridge.offered import RelayedGoal
from trajopt.ros.rosbridge.topics import no_compression
from trajopt.ros.rosbridge.wire import Fragments, Incoming, Unusable, named, parsed, pieces, status, written
from trajopt.values.errors import TrajoptError, listed, shown

_LOG = logging.getLogger("trajopt.server")
WAITING = 256
"""Messages queued for a slow client; further messages of topics are dropped."""
FULL = 1013
"""WebSocket close code "try again later"."""
ABORTED = 6
LEVELS = ("error", "warning", "info", "none")
NOT_HERE = {
    "png": "messages are not written as pictures here",
    "auth": "there is nothing to log in to: the port is for this machine, or open to everyone who reaches it",
}
"""Unsupported operations of the protocol, and the reasons."""


class Socket(Protocol):
    """Transport of messages."""

    async def send(self, message: str) -> None: ...


class ClientConnection:
    """One client."""

    def __init__(self, bridge: Bridge, socket: Socket) -> None:
        self.bridge, self._socket = bridge, socket
        self._out: asyncio.Queue[Iterable[bytes]] = asyncio.Queue(WAITING)
        self._fragments = Fragments(bridge.largest)
        self._tasks: set[asyncio.Task[None]] = set()
        self._goals: dict[str, ActionGoal | RelayedGoal] = {}
        self._level = LEVELS[0]
        self._handlers: dict[str, Callable[[Incoming], Awaitable[None] | None]] = {
            "call_service": self._call_service,
            "service_response": lambda said: bridge.offered.answered(self, said),
            "advertise_service": self._advertise_service,
            "unadvertise_service": lambda said: bridge.offered.withdraw(self, named(said.service, "service")),
            "subscribe": self._subscribe,
            "unsubscribe": lambda said: bridge.topics.unsubscribe(self, named(said.topic, "topic"), said.id),
            "advertise": self._advertise,
            "unadvertise": lambda said: bridge.topics.unadvertise(self, named(said.topic, "topic")),
            "publish": self._publish,
            "send_action_goal": self._send_goal,
            "cancel_action_goal": self._cancel_goal,
            "advertise_action": self._advertise_action,
            "unadvertise_action": lambda said: bridge.offered_actions.withdraw(
                self, named(said.action, "action")
            ),
            "action_feedback": lambda said: bridge.offered_actions.feedback(self, said),
            "action_result": lambda said: bridge.offered_actions.result(self, said),
            "fragment": self._fragment,
            "set_level": self._set_level,
            "status_level": self._set_level,
            "status": lambda _: None,
        }

    async def write(self) -> None:
        while True:
            for piece in await self._out.get():
                await self._socket.send(piece.decode())

    def offer(self, message: bytes, fragment_size: int | None = None) -> None:
        with suppress(asyncio.QueueFull):
            self._out.put_nowait(pieces(message, fragment_size, "publish"))  # all of them, or none

    async def take(self, text: str | bytes) -> None:
        name: str | int | None = None
        try:
            incoming = parsed(text)
            name = incoming.id
            await self._do(incoming)
        except Unusable as error:
            await self._say("error", str(error), name)

    async def leave(self) -> None:
        self.bridge.leave(self)
        for goal in self._goals.values():
            goal.cancel()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def call(self, message: bytes) -> None:
        await self._out.put((message,))

    async def _do(self, incoming: Incoming) -> None:
        if incoming.op in NOT_HERE:
            raise Unusable(f"{incoming.op} is not supported: {NOT_HERE[incoming.op]}")
        handler = self._handlers.get(incoming.op)
        if handler is None:
            known = listed(sorted(self._handlers))
            raise Unusable(f"unknown operation {shown(incoming.op)}; known: {known}")
        done = handler(incoming)
        if done is not None:
            await done

    async def _say(self, level: str, reason: str, name: str | int | None) -> None:
        if self._level != "none" and LEVELS.index(level) <= LEVELS.index(self._level):
            await self.call(status(level, reason, name))

    def _begin(self, task: Awaitable[None]) -> None:
        begun = asyncio.ensure_future(task)
        self._tasks.add(begun)
        begun.add_done_callback(self._done)

    def _done(self, task: asyncio.Future[None]) -> None:
        self._tasks.discard(task)  # pyright: ignore[reportArgumentType]
        if not task.cancelled() and (error := task.exception()) is not None:
            _LOG.error("a request of rosbridge failed", exc_info=error)

    async def _call_service(self, incoming: Incoming) -> None:
        service = named(incoming.service, "service")
        if len(self._tasks) >= self.bridge.options.calls:
            await self._respond(
                incoming, service, f"{len(self._tasks)} requests are under way already", ok=False
            )
            return
        self._begin(self._called(incoming, service))

    async def _called(self, incoming: Incoming, service: str) -> None:
        try:
            no_compression(incoming.compression)
            values = await self.bridge.call(service, incoming)
        except TrajoptError as error:
            await self._respond(incoming, service, str(error), ok=False)
        else:
            await self._respond(incoming, service, msgspec.Raw(values), ok=True)

    async def _respond(self, incoming: Incoming, service: str, values: object, *, ok: bool) -> None:
        response = {"op": "service_response", "service": service, "values": values, "result": ok}
        whole = written(response if incoming.id is None else {**response, "id": incoming.id})
        await self._out.put(pieces(whole, incoming.fragment_size, str(incoming.id)))

    async def _advertise_service(self, incoming: Incoming) -> None:
        self.bridge.offer_service(self, named(incoming.service, "service"), incoming.type or "")

    async def _subscribe(self, incoming: Incoming) -> None:
        no_compression(incoming.compression)
        spacing = (incoming.throttle_rate or 0.0) / 1e3
        if not 0.0 <= spacing < 1e6:
            raise Unusable("throttle_rate counts milliseconds")
        self.bridge.topics.subscribe(
            self,
            named(incoming.topic, "topic"),
            incoming.type or "",
            subscription=incoming.id,
            spacing=spacing,
            fragment_size=incoming.fragment_size,
        )
        self.bridge.heard(named(incoming.topic, "topic"))

    async def _advertise(self, incoming: Incoming) -> None:
        topic = named(incoming.topic, "topic")
        if not incoming.type:
            raise Unusable(f"advertise names no type of {topic}")
        self.bridge.topics.advertise(self, topic, incoming.type)

    async def _publish(self, incoming: Incoming) -> None:
        topic = named(incoming.topic, "topic")
        await self.bridge.topics.publish(self, topic, incoming.msg, latch=bool(incoming.latch))
        await self.bridge.published(topic, incoming.msg)

    async def _send_goal(self, incoming: Incoming) -> None:
        action, name = named(incoming.action, "action"), str(incoming.id or "")
        kinds = self.bridge.action_kinds
        if action not in kinds or not same_type(incoming.action_type, kinds[action]):
            about = f"{action} is of the type {kinds[action]}" if action in kinds else f"no action {action}"
            await self._result(name, action, 0, f"{about}; there are {listed(sorted(kinds))}", ok=False)
            return
        if name in self._goals or len(self._tasks) >= self.bridge.options.calls:
            await self._result(name, action, 0, f"a goal {shown(name)} is under way, or too many", ok=False)
            return

        def tell(feedback: object) -> None:
            self.offer(written({"op": "action_feedback", "id": name, "action": action, "values": feedback}))

        if action in ACTIONS:
            goal = ActionGoal(name, ACTIONS[action], incoming.args, self.bridge.generation, tell)
            self._goals[name] = goal
            self._begin(self._pursued(goal, action))
        else:
            relayed = self.bridge.offered_actions.goal(action, tell)
            self._goals[name] = relayed
            self._begin(self._relayed(relayed, name, incoming.args))

    async def _relayed(self, goal: RelayedGoal, name: str, arguments: msgspec.Raw) -> None:
        try:
            ended = await self.bridge.offered_actions.pursue(goal, arguments)
        except Unusable as error:
            await self._result(name, goal.action, ABORTED, str(error), ok=False)
        else:
            await self._result(name, goal.action, ended.status, ended.values, ok=ended.result)
        finally:
            self._goals.pop(name, None)

    async def _pursued(self, goal: ActionGoal, action: str) -> None:
        try:
            ending, result = await goal.run(self.bridge.cell)
        except TrajoptError as error:
            number = 5 if goal.cancelled else 0
            await self._result(goal.name, action, number, str(error), ok=False)
        else:
            await self._result(goal.name, action, ending.ros2, result, ok=True)
        finally:
            self._goals.pop(goal.name, None)

    async def _result(self, name: str, action: str, number: int, values: object, *, ok: bool) -> None:
        told = {"op": "action_result", "id": name, "action": action, "values": values}
        await self.call(written({**told, "status": number, "result": ok}))

    async def _cancel_goal(self, incoming: Incoming) -> None:
        goal = self._goals.get(str(incoming.id or ""))
        if goal is None:
            raise Unusable(f"no goal {shown(incoming.id)} is under way")
        goal.cancel()

    async def _advertise_action(self, incoming: Incoming) -> None:
        action = named(incoming.action, "action")
        if not incoming.type:
            raise Unusable(f"advertise_action names no type of {action}")
        self.bridge.offer_action(self, action, incoming.type)

    async def _fragment(self, incoming: Incoming) -> None:
        whole = self._fragments.add(incoming)
        if whole is not None:
            inner = parsed(whole)
            if inner.op == "fragment":
                raise Unusable("a fragment of fragments")
            await self._do(inner)

    async def _set_level(self, incoming: Incoming) -> None:
        if incoming.level not in LEVELS:
            raise Unusable(f"no level {shown(incoming.level)}; known: {listed(LEVELS)}")
        self._level = incoming.level


async def converse(bridge: Bridge, socket: ServerConnection) -> None:
    if len(bridge.clients) >= bridge.options.connections:
        await socket.close(FULL, "there are too many connections")
        return
    client = ClientConnection(bridge, socket)
    bridge.clients.add(client)
    # Stop reading once writing fails: otherwise queued messages would wait for ever.
    both = [asyncio.create_task(each) for each in (_heard(client, socket), client.write())]
    try:
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        for task in both:
            if task.done():
                task.result()
    except ConnectionClosed:
        _LOG.info("a client of rosbridge has gone without a word")
    finally:
        bridge.clients.discard(client)
        for task in both:
            task.cancel()
        await asyncio.gather(client.leave(), *both, return_exceptions=True)


async def _heard(client: ClientConnection, socket: ServerConnection) -> None:
    async for message in socket:
        await client.take(message)
