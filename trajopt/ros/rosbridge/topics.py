"""Topics: publishers, subscribers, and latched messages."""

import asyncio
import time
from collections.abc import Iterable
from dataclasses import dataclass, field

import msgspec

from trajopt.files.messages import Generation, decode, message_named, plain_name
from trajopt.ros.rosbridge.wire import BridgeClient, Unusable, plain, written
from trajopt.values.errors import FileFormatError, MessageNotFound, listed, shown

TOPICS = 256
"""Most topics that one client publishes and subscribes to."""
LARGEST_LATCHED = 2**20
"""Largest size of a latched message [bytes]."""
INLINE = 100_000
"""Size above which a message is checked in a thread [bytes], so that other messages need not wait."""
COMPRESSIONS = (None, "", "none")


@dataclass(eq=False)
class Subscription:
    """A client's subscription to a topic."""

    names: set[str | int | None] = field(default_factory=set[str | int | None])
    spacing: float = 0.0
    fragment_size: int | None = None
    last: float = -1e9


@dataclass(eq=False)
class RelayedTopic:
    """A topic.

    Attributes:
        ours: Whether only the server publishes it.
        kept: Whether it exists without clients.
        latched: The last message, sent to later subscribers.
    """

    name: str
    kind: str = ""
    ours: bool = False
    kept: bool = False
    latched: msgspec.Raw | None = None
    clients: set[BridgeClient] = field(default_factory=set[BridgeClient])
    heard: dict[BridgeClient, Subscription] = field(default_factory=dict[BridgeClient, Subscription])


class Topics:
    """All topics."""

    def __init__(self, generation: Generation) -> None:
        self.generation = generation
        self._all: dict[str, RelayedTopic] = {}

    def names(self) -> list[str]:
        return sorted(self._all)

    def kind(self, name: str) -> str:
        return self._all[name].kind if name in self._all else ""

    def announce(self, name: str, kind: str, latched: object = None) -> None:
        topic = self._topic(name, kind)
        topic.ours = True
        if latched is not None:
            topic.latched = msgspec.Raw(msgspec.json.encode(latched))

    def expect(self, name: str, kind: str) -> None:
        self._topic(name, kind).kept = True

    def heard(self, name: str) -> bool:
        return name in self._all and bool(self._all[name].heard)

    def unadvertise(self, client: BridgeClient, name: str) -> None:
        if name in self._all:
            self._all[name].clients.discard(client)
            self._forget(name)

    def subscribe(
        self,
        client: BridgeClient,
        name: str,
        kind: str,
        *,
        subscription: str | int | None = None,
        spacing: float = 0.0,
        fragment_size: int | None = None,
    ) -> None:
        """Subscribe a client to a topic; send it the latched message, if any.

        Args:
            spacing: Least time between two messages [s]; the shortest of several subscriptions applies.
        """
        self._count(client)
        topic = self._topic(name, kind)
        known = topic.heard.get(client)
        mine = topic.heard.setdefault(client, Subscription(spacing=spacing, fragment_size=fragment_size))
        mine.names.add(subscription)
        mine.spacing = spacing if known is None else min(known.spacing, spacing)
        if topic.latched is not None:
            client.offer(_published(topic, topic.latched), mine.fragment_size)

    def unsubscribe(self, client: BridgeClient, name: str, subscription: str | int | None) -> None:
        topic = self._all.get(name)
        if topic is None or client not in topic.heard:
            return
        names = topic.heard[client].names
        names.discard(subscription)
        if subscription is None or not names:
            del topic.heard[client]
            self._forget(name)

    async def publish(self, client: BridgeClient, name: str, message: msgspec.Raw, *, latch: bool) -> str:
        topic = self.advertise(client, name, "")
        if not topic.kind:
            raise Unusable(f"the type of {name} is unknown: advertise it first")
        if len(bytes(message)) > INLINE:
            await asyncio.to_thread(self._check, topic.kind, message)
        else:
            self._check(topic.kind, message)
        if latch and len(bytes(message)) <= LARGEST_LATCHED:
            topic.latched = msgspec.Raw(bytes(message))
        self._pass(topic, message)
        return topic.kind

    def tell(self, name: str, document: object) -> None:
        topic = self._all[name]
        if topic.heard:
            self._pass(topic, msgspec.Raw(msgspec.json.encode(document)))

    def leave(self, client: BridgeClient) -> None:
        for name, topic in list(self._all.items()):
            topic.clients.discard(client)
            topic.heard.pop(client, None)
            self._forget(name)

    def _check(self, kind: str, message: msgspec.Raw) -> None:
        document = plain(message)
        try:
            decode(message_named(kind), document, self.generation, name="msg")
        except MessageNotFound:
            return  # a type of the clients' own
        except FileFormatError as error:
            raise Unusable(str(error)) from error

    def _pass(self, topic: RelayedTopic, message: msgspec.Raw) -> None:
        now, text = time.monotonic(), b""
        for client, mine in topic.heard.items():
            if now - mine.last >= mine.spacing:
                mine.last = now
                text = text or _published(topic, message)
                client.offer(text, mine.fragment_size)

    def advertise(self, client: BridgeClient, name: str, kind: str) -> RelayedTopic:
        if name in self._all and self._all[name].ours:
            raise Unusable(f"{name} is published by the server itself")
        if name not in self._all or client not in self._all[name].clients:
            self._count(client)
        topic = self._topic(name, kind)
        topic.clients.add(client)
        return topic

    def _topic(self, name: str, kind: str) -> RelayedTopic:
        wanted = plain_name(kind)
        topic = self._all.setdefault(name, RelayedTopic(name))
        if wanted and topic.kind and wanted != topic.kind:
            raise Unusable(f"{name} is of the type {topic.kind}, not {shown(kind)}")
        topic.kind = topic.kind or wanted
        return topic

    def _count(self, client: BridgeClient) -> None:
        mine = sum(client in topic.clients or client in topic.heard for topic in self._all.values())
        if mine >= TOPICS:
            raise Unusable(f"a client has {TOPICS} topics at most")

    def _forget(self, name: str) -> None:
        topic = self._all[name]
        if not (topic.ours or topic.kept or topic.clients or topic.heard):
            del self._all[name]


def _published(topic: RelayedTopic, message: msgspec.Raw) -> bytes:
    return written({"op": "publish", "topic": topic.name, "msg": message})


def no_compression(compression: str | None) -> None:
    if compression not in COMPRESSIONS:
        known: Iterable[str] = ("none",)
        raise Unusable(f"compression {shown(compression)} is not spoken here; known: {listed(known)}")
