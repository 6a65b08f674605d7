"""The robot cell shared by all clients of the bridge."""

import asyncio
from collections.abc import Callable

import msgspec

from trajopt.files.messages import Generation
from trajopt.ros.rosbridge.wire import Unusable
from trajopt.server.job import Cancellation
from trajopt.server.limits import RequestRefused, Why
from trajopt.server.service import Service

FACE = "rosbridge"
"""Key by which the session is found after a restart."""
AGAIN = 0.05
"""Least delay before a retry if the queue is full [s]; clients made for ROS do not retry."""
PATIENCE = 10.0
"""Longest total delay of the retries [s]."""


class Cell:
    """A session of the service: its scene and the state of its robot."""

    def __init__(self, service: Service, robot: str = "") -> None:
        """Open a persistent session of a robot, or resume the one from before a restart."""
        self.service, self.session = service, service.create(robot, face=FACE)

    @property
    def joint_names(self) -> tuple[str, ...]:
        return self.service.robots[self.session.robot].joint_names

    async def ask(
        self,
        operation: str,
        message: msgspec.Raw | bytes,
        generation: Generation,
        *,
        difference: bytes | None = None,
        seconds: float | None = None,
        listener: Callable[[msgspec.Raw], None] | None = None,
        cancellation: Cancellation | None = None,
    ) -> bytes:
        """Have a worker process a message; return its response, as JSON.

        Args:
            difference: A planning scene message, JSON: changes for this request alone.
            listener: Called with progress, as JSON.
        """
        other = b"" if difference is None else b',"difference":' + difference
        body = b'{"ros":"%s","args":%s%s}' % (generation.name.encode(), bytes(message), other)
        begin = asyncio.get_running_loop().time()
        while True:
            try:
                reply = await self.service.ask(
                    self.session,
                    operation,
                    body,
                    seconds=seconds,
                    listener=listener,
                    cancellation=cancellation,
                )
            except RequestRefused as refusal:
                waited = asyncio.get_running_loop().time() - begin
                if refusal.why is not Why.FULL or waited > PATIENCE:
                    raise Unusable(refusal.reason) from refusal
                await asyncio.sleep(max(AGAIN, min(refusal.retry_after or 0.0, PATIENCE - waited)))
            else:
                return reply.body
