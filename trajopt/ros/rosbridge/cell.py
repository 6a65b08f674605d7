"""The robot cell that all clients of the bridge share, as the nodes around one `move_group` do."""

import asyncio
from collections.abc import Callable

import msgspec

from trajopt.files.messages import Generation
from trajopt.ros.rosbridge.wire import Unusable
from trajopt.server.refusals import Refusal, Why
from trajopt.server.requests import Cancellation
from trajopt.server.service import Service

FACE = "rosbridge"
"""By this the session is found again after a restart."""
AGAIN = 0.05
"""Clients made for ROS do not ask again: what finds the queue full waits so long at least [s]."""
PATIENCE = 10.0
"""And no longer than that in all [s]."""


class Cell:
    """A session of the service.

    Attributes:
        service: The service.
        session: The session: its scene and where its robot stands.
    """

    def __init__(self, service: Service, robot: str = "") -> None:
        """Begin a session that stays, or go on with the one of before a restart.

        Args:
            service: The service, started.
            robot: Name of the robot; the first one where it is empty.

        Raises:
            RobotNotFound: If there is no such robot.
        """
        self.service, self.session = service, service.create(robot, face=FACE)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of all joints of the robot."""
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
        """Have a worker answer a message; return its message, as JSON.

        Args:
            operation: What is to be done.
            message: The message, JSON.
            generation: How it is written, and the answer.
            difference: A planning scene message, JSON: what is different for this request alone.
            seconds: Time that it may take [s].
            listener: Told, as JSON, how far it is.
            cancellation: Ends it from elsewhere.

        Raises:
            Unusable: If there is no answer; it says why.
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
            except Refusal as refusal:
                waited = asyncio.get_running_loop().time() - begin
                if refusal.why is not Why.FULL or waited > PATIENCE:
                    raise Unusable(refusal.reason) from refusal
                await asyncio.sleep(max(AGAIN, min(refusal.retry_after or 0.0, PATIENCE - waited)))
            else:
                return reply.body
