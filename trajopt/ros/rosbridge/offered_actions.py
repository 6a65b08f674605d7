"""Actions that clients offer: goals, feedback and results are relayed between clients."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import Protocol

import msgspec

from trajopt.ros.rosbridge.wire import Incoming, Unusable, written
from trajopt.values.errors import shown

ACTIONS = 64
"""Most actions of one client."""


class ActionProvider(Protocol):
    """A connection to a client that offers actions."""

    def offer(self, message: bytes, fragment_size: int | None = None) -> None:
        """Queue a message, or drop it if the client is too slow."""
        ...

    async def call(self, message: bytes) -> None:
        """Send a message that must arrive."""
        ...


@dataclass(eq=False)
class RelayedGoal:
    """A goal that another client pursues.

    Attributes:
        provider: The client that offers the action.
        number: The goal's id between the server and that client.
        action: Name of the action.
        kind: Type of the action, as sent by the client.
        tell: Called with feedback, as JSON.
        done: Future of the result.
    """

    provider: ActionProvider
    number: str
    action: str
    kind: str
    tell: Callable[[msgspec.Raw], None]
    done: "asyncio.Future[Incoming]"

    def cancel(self) -> None:
        """Send a cancellation of the goal to the client."""
        message = {"op": "cancel_action_goal", "id": self.number, "action": self.action}
        self.provider.offer(written(message))


class OfferedActions:
    """The actions that clients offer, and the goals that are under way."""

    def __init__(self) -> None:
        """Start without actions."""
        self._actions: dict[str, tuple[ActionProvider, str]] = {}
        self._goals: dict[str, RelayedGoal] = {}
        self._numbers = count(1)

    def kinds(self) -> dict[str, str]:
        """Return the types of the actions by name."""
        return {name: kind for name, (_, kind) in self._actions.items()}

    def offer(self, provider: ActionProvider, name: str, kind: str) -> None:
        """Register an action of a client.

        Raises:
            Unusable: If another client offers it, or this client offers too many.
        """
        owner = self._actions.get(name)
        if owner is not None and owner[0] is not provider:
            raise Unusable(f"another client offers the action {name}")
        if sum(each is provider for each, _ in self._actions.values()) >= ACTIONS:
            raise Unusable(f"a client offers {ACTIONS} actions at most")
        self._actions[name] = provider, kind

    def withdraw(self, provider: ActionProvider, name: str) -> None:
        """Remove an action of a client; its goals go on."""
        if name in self._actions and self._actions[name][0] is provider:
            del self._actions[name]

    def goal(self, name: str, tell: Callable[[msgspec.Raw], None]) -> RelayedGoal:
        """Return a new goal of an action, which `pursue` sends."""
        (provider, kind), number = self._actions[name], f"send_action_goal:{name}:{next(self._numbers)}"
        return RelayedGoal(provider, number, name, kind, tell, asyncio.get_running_loop().create_future())

    async def pursue(self, goal: RelayedGoal, arguments: msgspec.Raw) -> Incoming:
        """Have a client pursue a goal; return its result. If this is cancelled, so is the goal.

        Raises:
            Unusable: If the client leaves.
        """
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

    def feedback(self, provider: ActionProvider, incoming: Incoming) -> None:
        """Pass on the feedback of a client.

        Raises:
            Unusable: If its goal is not under way.
        """
        self._of(provider, incoming).tell(incoming.values)

    def result(self, provider: ActionProvider, incoming: Incoming) -> None:
        """Pass on the result of a client.

        Raises:
            Unusable: If its goal is not under way.
        """
        goal = self._of(provider, incoming)
        if not goal.done.done():
            goal.done.set_result(incoming)

    def leave(self, provider: ActionProvider) -> None:
        """Remove a client; goals that it pursues fail."""
        for name in [key for key, (owner, _) in self._actions.items() if owner is provider]:
            del self._actions[name]
        for goal in self._goals.values():
            if goal.provider is provider and not goal.done.done():
                goal.done.set_exception(Unusable("the client that offered the action has left"))

    def _of(self, provider: ActionProvider, incoming: Incoming) -> RelayedGoal:
        goal = self._goals.get(str(incoming.id))
        if goal is None or goal.provider is not provider:
            raise Unusable(f"no goal {shown(incoming.id)} of an action of this client is under way")
        return goal
