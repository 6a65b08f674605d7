"""Services that clients offer: calls are relayed between clients."""

import asyncio
from dataclasses import dataclass
from itertools import count
from typing import Protocol

import msgspec

from trajopt.ros.rosbridge.wire import Incoming, Unusable, written

SERVICES = 64
"""Most services of one client."""


class Provider(Protocol):
    """A connection to a client that offers services."""

    async def call(self, message: bytes) -> None:
        """Send a message."""
        ...


@dataclass
class _Call:
    provider: Provider
    done: "asyncio.Future[bytes]"


class Offered:
    """The services that clients offer."""

    def __init__(self) -> None:
        """Start without services."""
        self._services: dict[str, tuple[Provider, str]] = {}
        self._calls: dict[str, _Call] = {}
        self._numbers = count(1)

    def kinds(self) -> dict[str, str]:
        """Return the types of the services by name."""
        return {name: kind for name, (_, kind) in self._services.items()}

    def offer(self, provider: Provider, name: str, kind: str) -> None:
        """Register a service.

        Raises:
            Unusable: If another client offers it, or this client offers too many.
        """
        owner = self._services.get(name)
        if owner is not None and owner[0] is not provider:
            raise Unusable(f"another client offers the service {name}")
        if sum(each is provider for each, _ in self._services.values()) >= SERVICES:
            raise Unusable(f"a client offers {SERVICES} services at most")
        self._services[name] = provider, kind

    def withdraw(self, provider: Provider, name: str) -> None:
        """Remove a service of a client."""
        if name in self._services and self._services[name][0] is provider:
            del self._services[name]

    async def call(self, name: str, arguments: msgspec.Raw, seconds: float) -> bytes:
        """Relay a call to a client; return its response, as JSON.

        Raises:
            Unusable: If the service does not exist, fails, or exceeds its time limit.
        """
        if name not in self._services:
            raise Unusable(f"there is no service {name}")
        provider, number = self._services[name][0], f"call_service:{name}:{next(self._numbers)}"
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

    def answered(self, provider: Provider, response: Incoming) -> None:
        """Pass on a client's response.

        Raises:
            Unusable: If it does not match a pending call.
        """
        call = self._calls.get(str(response.id))
        if call is None or call.provider is not provider:
            raise Unusable("service_response: nobody asked for it")
        if call.done.done():
            return
        if response.result:
            call.done.set_result(bytes(response.values))
        else:
            call.done.set_exception(Unusable(f"the service failed: {bytes(response.values).decode()[:1000]}"))

    def leave(self, provider: Provider) -> None:
        """Remove a client; its pending calls fail."""
        for name in [key for key, (owner, _) in self._services.items() if owner is provider]:
            del self._services[name]
        for call in self._calls.values():
            if call.provider is provider and not call.done.done():
                call.done.set_exception(Unusable("the client that offered the service has left"))
