"""Sessions: the server's state of each client, in memory and on disk."""

import asyncio
import fcntl
import logging
import re
import secrets
import time
from collections.abc import AsyncGenerator, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace
from io import BufferedWriter
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

import msgspec

from trajopt.files.bundle.codec import fingerprint
from trajopt.files.bundle.containers import message_of, value_of_message
from trajopt.scene.scene import Scene
from trajopt.server.job import Assignment, Job
from trajopt.server.limits import Limits, RequestRefused, Why
from trajopt.server.messages import Answered, Hello
from trajopt.server.operation import Answer, Lane, Operation, PackedScene, SessionState, Watch
from trajopt.server.pool import WorkerPool
from trajopt.server.warehouse import EntryKind, StoredState, Warehouse
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError, ModelError

ID_BYTES = 16
"""Bytes of a session's id; 128 random bits cannot be guessed, so the id grants access."""
ID = re.compile("[A-Za-z0-9_-]{22}")
SHOWN = 6
"""Characters of an id in the log: enough to distinguish ids, too few to use one."""


@dataclass(eq=False)
class ServiceSession:
    """A robot in its own scene.

    Attributes:
        stamps: Measurement times of clouds in the scene, by name [s].
        kept: Whether it stays although unused.
        used: Time of last use, on the monotonic clock [s].
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
        """Name of the robot."""
        return self.scene.robot

    @asynccontextmanager
    async def change(self) -> AsyncGenerator[None]:
        self.editors += 1
        try:
            async with self._editing:
                yield
        finally:
            self.editors -= 1

    def stand(self) -> None:
        """End the run: the robot stands."""
        self.run = None

    def move(self, positions: list[float]) -> None:
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


_LOG = logging.getLogger("trajopt.server")
MODULE = "trajopt.server.session"
_JSON = msgspec.json.Encoder()
Arguments: TypeAlias = Mapping[str, Any]
Empty: TypeAlias = Mapping[str, tuple[PackedScene, Sequence[float]]]
"""Robot -> its empty scene and default configuration."""


class Keeper:
    """Stores the sessions of one service in a warehouse, by a worker of its own."""

    def __init__(self, warehouse: Warehouse, hello: Hello, limits: Limits) -> None:
        self._warehouse, self._limits, self._known = warehouse, limits, set[str]()
        self._claim: BufferedWriter | None = None
        self.pool = WorkerPool("keeping", msgspec.structs.replace(hello, modules=(MODULE,)), 1, limits)

    def claim(self) -> None:
        """Refuse other servers the file until `release`, or until this process ends.

        Raises:
            FileFormatError: If another server has it.
        """
        file = self._warehouse.path
        self._claim = open(file.with_name(f"{file.name}.lock"), "ab")
        try:
            fcntl.flock(self._claim, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            self.release()
            raise FileFormatError(str(file), "another server keeps its sessions in it") from error

    def release(self) -> None:
        if self._claim is not None:
            self._claim.close()

    async def keep(
        self, session: ServiceSession, scene: PackedScene | None, positions: Sequence[float] | None
    ) -> None:
        new = session.id not in self._known
        what = {
            "session": session.id,
            "face": session.face,
            "scene": new or scene is not None,
            "positions": new or positions is not None,
        }
        await self._written(session, "keep", what, scene or session.scene, positions or session.positions)
        self._known.add(session.id)

    async def forget(self, session: ServiceSession) -> None:
        self._known.discard(session.id)
        await self._written(session, "forget", {"session": session.id}, session.scene, session.positions)

    async def restored(self, empty: Empty, most: int) -> list[ServiceSession]:
        """Return the stored sessions of present robots; the log reports unusable ones, which stay."""
        found = list[ServiceSession]()
        for entry in self._warehouse.find(kind=EntryKind.STATE, tags=[SESSION]):
            if not re.fullmatch(ID, entry.name):
                continue
            if entry.robot not in empty:
                _left_out(entry.name, f"its robot {entry.robot!r} is not served")
                continue
            if len(found) >= most:
                _left_out(entry.name, f"there may be {most} sessions")
                continue
            scene, positions = empty[entry.robot]
            try:
                answered = await self._done(entry.name, "restore", {"session": entry.name}, scene, positions)
            except RequestRefused as refusal:
                _left_out(entry.name, refusal.reason)
                continue
            assert answered.scene is not None and answered.positions is not None
            session = ServiceSession(
                entry.name, PackedScene.of(entry.robot, answered.scene), answered.positions,
                revision=msgspec.json.decode(answered.body)["revision"],
                face=next((tag for tag in entry.tags if tag != SESSION), ""),
            )  # fmt: skip
            found.append(session)
            self._known.add(session.id)
        return found

    async def _written(
        self,
        session: ServiceSession,
        what: str,
        said: Arguments,
        scene: PackedScene,
        positions: Sequence[float],
    ) -> None:
        try:
            await self._done(session.id, what, said, scene, positions)
        except RequestRefused as refusal:
            _LOG.error("session not kept", extra={"session": session.id[:SHOWN], "reason": str(refusal)})
            if refusal.why not in (Why.MALFORMED, Why.UNKNOWN, Why.FAILED):
                raise
            raise RequestRefused(
                Why.FAILED, "the session cannot be kept on disk: the server's log has the reason"
            ) from refusal

    async def _done(
        self, owner: str, what: str, said: Arguments, scene: PackedScene, positions: Sequence[float]
    ) -> Answered:
        body = _JSON.encode({**said, "warehouse": str(self._warehouse.path.absolute())})
        assignment = Assignment(f"keeping/{what}", scene, positions, body, self._limits.seconds)
        return await self.pool.submit(owner, assignment).done


def _left_out(name: str, reason: str) -> None:
    _LOG.warning("session not restored", extra={"session": name[:SHOWN], "reason": reason})


SESSION = "session"
KINDS = (EntryKind.SCENE, EntryKind.STATE)


def keep(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Store the changed content of a session and remove the previous one, in one transaction."""
    name, face = arguments["session"].text(), arguments["face"].text("")
    tags = (SESSION, face) if face else (SESSION,)
    with _warehouse(arguments) as kept, kept.together():
        if arguments["scene"].value:
            kept.add(name, state.scene, tags=tags)
        if arguments["positions"].value:
            kept.add(name, StoredState(state.robot, state.named_positions), tags=tags)
        for kind in KINDS:
            # By version: a clock that was set back has what was kept last be older than what was before.
            versions = sorted(entry.version for entry in kept.find(kind=kind, name=name))
            for version in versions[:-1]:
                kept.remove(name, kind=kind, version=version)
    return Answer({})


def forget(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    name = arguments["session"].text()
    with _warehouse(arguments) as kept, kept.together():
        for kind in KINDS:
            if kept.find(kind=kind, name=name):
                kept.remove(name, kind=kind)
    return Answer({})


def restore(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the scene and the positions of a session, with this server's robot in the scene."""
    robot, name = state.scene.robot, arguments["session"].text()
    with _warehouse(arguments) as kept, TemporaryDirectory() as folder:
        entry = kept.entry(name, kind=EntryKind.SCENE)
        scene: Scene = kept.load(entry, meshes=folder)
        positions = kept.state(name).positions
        same = fingerprint(scene.robot) == fingerprint(robot)
    if not same:
        raise ModelError(f"robot {state.robot!r} has changed since the session was kept")
    message = Node(message_of(scene, {"robot": scene.robot}), name)
    held = value_of_message(message, {"robot": robot}, Scene)
    return Answer(
        {"revision": entry.version}, replace(state, scene=held, positions=robot.positions(positions))
    )


def _warehouse(arguments: Node) -> Warehouse:
    return Warehouse(arguments["warehouse"].text(), create=False)


OPERATIONS: Mapping[str, Operation] = {
    "keeping/keep": Operation(keep, Lane.KEEPING),
    "keeping/forget": Operation(forget, Lane.KEEPING),
    "keeping/restore": Operation(restore, Lane.KEEPING),
}
