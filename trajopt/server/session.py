"""Sessions: the server's state of each client."""

import asyncio
import re
import secrets
import time
from collections.abc import AsyncGenerator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from trajopt.server.job import Job
from trajopt.server.limits import Limits, RequestRefused, Why
from trajopt.server.operation import PackedScene

ID_BYTES = 16
"""Bytes of a session's id; 128 random bits cannot be guessed, so the id grants access."""
ID = re.compile("[A-Za-z0-9_-]{22}")
"""Format of ids."""
SHOWN = 6
"""Characters of an id in the log: enough to distinguish ids, too few to use one."""


@dataclass(eq=False)
class ServiceSession:
    """A robot in its own scene.

    Attributes:
        scene: Its scene, packed by workers.
        positions: Of the joints [rad | m].
        stamps: Measurement times of clouds in the scene, by name [s].
        revision: Number of changes of the scene.
        kept: Whether it stays although unused.
        used: Time of last use, on the monotonic clock [s].
        editors: Number of running and waiting changes of the scene.
        run: The request that drives the robot, if any.
    """

    id: str
    scene: PackedScene
    positions: list[float]
    stamps: dict[str, float] = field(default_factory=dict[str, float])
    revision: int = 0
    face: str = ""
    used: float = field(default_factory=time.monotonic)
    editors: int = 0
    run: Job | None = None
    _editing: asyncio.Lock = field(default_factory=asyncio.Lock)

    @property
    def robot(self) -> str:
        return self.scene.robot

    @asynccontextmanager
    async def change(self) -> AsyncGenerator[None]:
        """Wait for the turn to change the scene: one change at a time."""
        self.editors += 1
        try:
            async with self._editing:
                yield
        finally:
            self.editors -= 1

    def stand(self) -> None:
        self.run = None

    def move(self, positions: list[float]) -> None:
        """Record the robot's positions [rad | m]."""
        self.positions = positions

    def replace(
        self, scene: PackedScene | None, positions: list[float] | None, stamps: dict[str, float]
    ) -> None:
        """Store a worker's result: a new scene with its clouds' stamps, or new positions."""
        if scene is not None:
            self.stamps = stamps
        if scene is not None and scene.key != self.scene.key:
            self.scene, self.revision = scene, self.revision + 1
            if self.run is not None:
                self.run.change(scene)
        if positions is not None:
            self.positions = positions


class Sessions:
    """All sessions, up to a limit."""

    def __init__(self, limits: Limits) -> None:
        """Have none yet."""
        self._limits, self._all = limits, dict[str, ServiceSession]()
        self._gone: list[ServiceSession] = []

    def __len__(self) -> int:
        return len(self._all)

    def __contains__(self, session: ServiceSession) -> bool:
        return self._all.get(session.id) is session

    def put(self, session: ServiceSession) -> None:
        self._all[session.id] = session

    def of_face(self, face: str, robot: str) -> ServiceSession | None:
        return next((each for each in self._all.values() if (each.face, each.robot) == (face, robot)), None)

    def taken_gone(self) -> list[ServiceSession]:
        gone, self._gone = self._gone, []
        return gone

    def add(
        self,
        scene: PackedScene,
        positions: list[float],
        *,
        face: str = "",
        stamps: Mapping[str, float] | None = None,
    ) -> ServiceSession:
        if len(self._all) >= self._limits.sessions:
            self._forget_one()
        name = secrets.token_urlsafe(ID_BYTES)
        session = ServiceSession(name, scene, list(positions), dict(stamps or {}), face=face)
        self._all[session.id] = session
        return session

    def get(self, name: str) -> ServiceSession:
        session = self._all.get(name)
        if session is None:
            raise RequestRefused(Why.UNKNOWN, "there is no such session, or it was unused for too long")
        session.used = time.monotonic()
        return session

    def remove(self, name: str) -> None:
        session = self.get(name)
        if session.run is not None:
            session.run.cancel()
        self._forget(session)

    def _forget_one(self) -> None:
        free = [each for each in self._all.values() if not each.face and each.run is None]
        oldest = min(free, key=lambda each: each.used, default=None)
        idle = 0.0 if oldest is None else time.monotonic() - oldest.used
        if oldest is None or idle < self._limits.idle:
            raise RequestRefused(
                Why.FULL,
                f"there are {len(self._all)} sessions, all in use: close one that is not needed",
                retry_after=max(self._limits.idle - idle, 1.0),
            )
        self._forget(oldest)

    def _forget(self, session: ServiceSession) -> None:
        del self._all[session.id]
        self._gone.append(session)
