"""Services and actions that clients offer: calls and goals are relayed between clients."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count

import msgspec

from trajopt.ros.rosbridge.wire import BridgeClient, Incoming, Unusable, written
from trajopt.values.errors import shown

OFFERS = 64
"""Most services, and most actions, of one client."""


class Offers:
    """Names that clients offer, with the client and the type of each."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._offers: dict[str, tuple[BridgeClient, str]] = {}
        self._numbers = count(1)

    def kinds(self) -> dict[str, str]:
        return {name: kind for name, (_, kind) in self._offers.items()}

    def offer(self, provider: BridgeClient, name: str, kind: str) -> None:
        owner = self._offers.get(name)
        if owner is not None and owner[0] is not provider:
            raise Unusable(f"another client offers the {self._what} {name}")
        if sum(each is provider for each, _ in self._offers.values()) >= OFFERS:
            raise Unusable(f"a client offers {OFFERS} {self._what}s at most")
        self._offers[name] = provider, kind

    def withdraw(self, provider: BridgeClient, name: str) -> None:
        if name in self._offers and self._offers[name][0] is provider:
            del self._offers[name]

    def leave(self, provider: BridgeClient) -> None:
        for name in [key for key, (owner, _) in self._offers.items() if owner is provider]:
            del self._offers[name]


@dataclass
class _Call:
    provider: BridgeClient
    done: "asyncio.Future[bytes]"


class OfferedServices(Offers):
    """The services that clients offer, and the calls in progress."""

    def __init__(self) -> None:
        super().__init__("service")
        self._calls: dict[str, _Call] = {}

    async def call(self, name: str, arguments: msgspec.Raw, seconds: float) -> bytes:
        if name not in self._offers:
            raise Unusable(f"there is no service {name}")
        provider, number = self._offers[name][0], f"call_service:{name}:{next(self._numbers)}"
        call = _Call(provider, asyncio.get_running_loop().create_future())
        self._calls[number] = call
        try:
            await provider.call(
                written({"op": "call_service", "id": number, "service": name, "args": arguments})
            )
            return await asyncio.wait_for(call.done, seconds)
        except TimeoutError as error:
            raise Unusable(f"the client that offers {name} did not answer within {seconds:g} s") from error
        finally:
            del self._calls[number]

    def answered(self, provider: BridgeClient, response: Incoming) -> None:
        call = self._calls.get(str(response.id))
        if call is None or call.provider is not provider:
            raise Unusable("service_response: does not match a pending request")
        if call.done.done():
            return
        if response.result:
            call.done.set_result(bytes(response.values))
        else:
            call.done.set_exception(Unusable(f"the service failed: {bytes(response.values).decode()[:1000]}"))

    def leave(self, provider: BridgeClient) -> None:
        super().leave(provider)
        for call in self._calls.values():
            if call.provider is provider and not call.done.done():
                call.done.set_exception(Unusable("the client that offered the service has left"))


@dataclass(eq=False)
class RelayedGoal:
    """A goal that another client pursues.

    Attributes:
        number: The goal's id between the server and that client.
    """

    provider: BridgeClient
    number: str
    action: str
    kind: str
    tell: Callable[[msgspec.Raw], None]
    done: "asyncio.Future[Incoming]"

    def cancel(self) -> None:
        message = {"op": "cancel_action_goal", "id": self.number, "action": self.action}
        self.provider.offer(written(message))


class OfferedActions(Offers):
    """The actions that clients offer, and the goals in progress."""

    def __init__(self) -> None:
        super().__init__("action")
        self._goals: dict[str, RelayedGoal] = {}

    def goal(self, name: str, tell: Callable[[msgspec.Raw], None]) -> RelayedGoal:
        (provider, kind), number = self._offers[name], f"send_action_goal:{name}:{next(self._numbers)}"
        return RelayedGoal(provider, number, name, kind, tell, asyncio.get_running_loop().create_future())

    async def pursue(self, goal: RelayedGoal, arguments: msgspec.Raw) -> Incoming:
        """Have a client pursue a goal; return its result. If this is cancelled, so is the goal."""
        self._goals[goal.number] = goal
        message = {
            "op": "send_action_goal",
            "id": goal.number,
            "action": goal.action,
            "action_type": goal.kind,
            "args": arguments,
            "feedback": True,
        }
        try:
            await goal.provider.call(written(message))
            return await goal.done
        except asyncio.CancelledError:
            goal.cancel()
            raise
        finally:
            del self._goals[goal.number]

    def feedback(self, provider: BridgeClient, incoming: Incoming) -> None:
        self._of(provider, incoming).tell(incoming.values)

    def result(self, provider: BridgeClient, incoming: Incoming) -> None:
        goal = self._of(provider, incoming)
        if not goal.done.done():
            goal.done.set_result(incoming)

    def leave(self, provider: BridgeClient) -> None:
        super().leave(provider)
        for goal in self._goals.values():
            if goal.provider is provider and not goal.done.done():
                goal.done.set_exception(Unusable("the client that offered the action has left"))

    def _of(self, provider: BridgeClient, incoming: Incoming) -> RelayedGoal:
        goal = self._goals.get(str(incoming.id))
        if goal is None or goal.provider is not provider:
            raise Unusable(f"no goal {shown(incoming.id)} of an action of this client is under way")
        return goal
