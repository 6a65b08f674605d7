"""Sessions that are kept in a warehouse, and found there again by a server that is started anew."""

import asyncio
import logging
import os
import signal
import sqlite3
from collections.abc import Awaitable, Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.server.serving import MODULES
from trajopt.ros.rosbridge.cell import Cell
from trajopt.server import Lane, Limits, RequestRefused, Service, ServiceSession, SessionState, Watch, Why
from trajopt.server.session import keep
from trajopt.server.warehouse import EntryKind, StoredState, Warehouse
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError

ANSWERS = "trajopt.ros.rosbridge.answers"
LIMITS = Limits(workers=1, seconds=60.0)
BALL = {"name": "ball", "shape": {"sphere": {"radius": 0.05}}, "placement": {"xyz": [0.75, -0.4, 0.14]}}


def served(
    file: Path,
    test: Callable[[Service], Awaitable[None]],
    robot: to.Robot | None = None,
    limits: Limits = LIMITS,
) -> None:
    """Run a test with a service that keeps its sessions in a file."""

    async def run() -> None:
        served_robot = robot or to.load("planar2")
        robots = {served_robot.name: served_robot}
        with Warehouse(file) as kept:
            service = Service(robots, limits=limits, modules=(*MODULES, ANSWERS), warehouse=kept)
            async with service:
                await test(service)

    asyncio.run(asyncio.wait_for(run(), 120.0))


async def edit(service: Service, session: ServiceSession, *edits: dict[str, object]) -> None:
    await service.ask(session, "edit", {"edits": list(edits)})


async def objects(service: Service, session: ServiceSession) -> list[str]:
    return (await service.ask(session, "echo")).document()["objects"]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "cell.warehouse"


def test_sessions_are_there_again_after_a_restart(file: Path) -> None:
    ids = list[str]()

    async def before(service: Service) -> None:
        one, empty = service.create(), service.create()
        for each in (one, empty):
            await service.keep(each)
        await edit(service, one, {"add": BALL}, {"stand": [0.7, 0.2]})
        await edit(service, one, {"with_clearance": {"value": 0.01}})
        other = service.fork(one)
        await service.keep(other)
        await edit(service, other, {"remove": {"name": "ball"}})
        gone = service.create()
        await service.keep(gone)
        await service.remove(gone.id)
        ids.extend(each.id for each in (one, empty, other, gone))

    async def after(service: Service) -> None:
        one, empty, other = (service.sessions.get(each) for each in ids[:3])
        assert await objects(service, one) == ["ball"]
        assert await objects(service, empty) == await objects(service, other) == []
        assert one.positions == other.positions == [0.7, 0.2]
        assert one.revision >= 2
        with pytest.raises(RequestRefused, match="no such session"):
            service.sessions.get(ids[3])
        assert len(service.sessions) == 3
        goal = {"joint_positions": {"positions": {"joint1": 0.4, "joint2": 0.3}}}
        assert (await service.ask(one, "plan", {"problem": {"goal": goal}})).document()["verified"]

    served(file, before)
    with Warehouse(file) as kept:
        assert kept.scene(ids[0]).clearances
    served(file, after)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_sessions_of_robots_with_meshes_survive_a_restart(name: str, file: Path) -> None:
    try:
        robot = to.load(name)
    except to.MissingExtra as missing:
        pytest.skip(str(missing))
    ids = list[str]()

    async def before(service: Service) -> None:
        session = service.create()
        await service.keep(session)
        await edit(service, session, {"add": BALL})
        ids.append(session.id)

    async def after(service: Service) -> None:
        assert await objects(service, service.sessions.get(ids[0])) == ["ball"]

    served(file, before, robot)
    served(file, after, robot)


def test_a_second_server_may_not_use_the_file(file: Path) -> None:
    async def test(service: Service) -> None:
        with Warehouse(file) as kept, pytest.raises(FileFormatError, match="another server"):
            await Service(service.robots, limits=LIMITS, warehouse=kept).__aenter__()
        await service.keep(service.create())

    served(file, test)
    served(file, test)


def test_keeps_only_the_current_state(file: Path) -> None:
    async def test(service: Service) -> None:
        session = service.create()
        await service.keep(session)
        for x in (0.1, 0.2, 0.3):
            await edit(service, session, {"stand": [x, 0.0]})
        with Warehouse(file) as kept:
            assert sorted(each.kind.name for each in kept.find()) == ["SCENE", "STATE"]
            assert kept.state(session.id).positions["joint1"] == 0.3

    served(file, test)


def test_a_scene_is_kept_with_its_positions_or_not_at_all(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = to.load("planar2")
    state = SessionState("planar2", to.Scene(robot), np.zeros(2))
    said: dict[str, Any] = {"session": "s", "scene": True, "positions": True, "warehouse": str(file)}
    add = Warehouse.add

    def dying(kept: Warehouse, name: str, what: Any, **options: Any) -> Any:
        if isinstance(what, StoredState):
            raise KeyboardInterrupt
        return add(kept, name, what, **options)

    Warehouse(file).close()
    with monkeypatch.context() as patch:
        patch.setattr(Warehouse, "add", dying)
        with pytest.raises(KeyboardInterrupt):
            keep(state, Node(said, "request"), Watch(1.0))
    assert Warehouse(file).find() == ()
    keep(state, Node(said, "request"), Watch(1.0))
    assert {entry.kind for entry in Warehouse(file).find()} == {EntryKind.SCENE, EntryKind.STATE}


def test_a_change_is_kept_though_the_clock_was_set_back(file: Path) -> None:
    async def test(service: Service) -> None:
        session = service.create()
        await edit(service, session, {"add": BALL})
        with closing(sqlite3.connect(file)) as later, later:
            later.execute("UPDATE entries SET made = '2999-01-01T00:00:00.000000+00:00'")
        await edit(service, session, {"remove": {"name": "ball"}})
        with Warehouse(file) as kept:
            assert not kept.scene(session.id).objects
            assert len(kept.find(kind=EntryKind.SCENE)) == 1

    served(file, test)


def test_a_change_that_cannot_be_kept_is_not_made(file: Path, caplog: pytest.LogCaptureFixture) -> None:
    async def test(service: Service) -> None:
        session = service.create()
        await service.keep(session)
        for each in file.parent.iterdir():
            each.unlink()
        with pytest.raises(RequestRefused, match="cannot be kept") as refused:
            await edit(service, session, {"add": BALL})
        assert refused.value.why is Why.FAILED
        assert str(file.parent) not in refused.value.reason
        assert await objects(service, session) == []

    with caplog.at_level(logging.ERROR, "trajopt.server"):
        served(file, test)
    assert any("no such file" in vars(each).get("reason", "") for each in caplog.records)


def test_where_a_robot_was_driven_is_kept(file: Path) -> None:
    ids = list[str]()
    goal = {"joint_positions": {"positions": {"joint1": 0.4, "joint2": 0.3}}}

    async def before(service: Service) -> None:
        session = service.create()
        await service.ask(session, "execute", {"problem": {"goal": goal}, "speed": 0})
        await service.keep(session)
        await service.ask(session, "execute", {"problem": {"start": [0, 0], "goal": goal}, "speed": 0})
        ids.append(session.id)

    async def after(service: Service) -> None:
        assert service.sessions.get(ids[0]).positions == pytest.approx([0.4, 0.3], abs=5e-3)

    served(file, before)
    served(file, after)


def test_sessions_of_another_robot_stay_in_the_file(file: Path, caplog: pytest.LogCaptureFixture) -> None:
    async def before(service: Service) -> None:
        await service.keep(service.create())

    async def after(service: Service) -> None:
        assert len(service.sessions) == 0

    served(file, before)
    robot = to.load("planar2")
    with caplog.at_level(logging.WARNING, "trajopt.server"):
        served(
            file, after, replace(robot, limits=replace(robot.limits, velocity=0.5 * robot.limits.velocity))
        )
    assert any("has changed since" in vars(each).get("reason", "") for each in caplog.records)
    with Warehouse(file) as kept:
        assert len(kept.find(kind=EntryKind.SCENE)) == 1


def test_an_unrelated_warehouse_entry_is_not_a_session(file: Path) -> None:
    async def test(service: Service) -> None:
        assert len(service.sessions) == 0

    with Warehouse(file) as kept:
        kept.add("cell", to.Scene(to.load("planar2")), tags=["session"])
    served(file, test)


def test_expired_sessions_are_deleted_from_the_disk(file: Path) -> None:
    async def test(service: Service) -> None:
        old = service.create()
        await service.keep(old)
        old.used -= service.limits.idle
        new = service.create()
        await service.keep(new)
        with Warehouse(file) as kept:
            assert {each.name for each in kept.find()} == {new.id}

    served(file, test, limits=Limits(workers=1, sessions=1))


def test_clients_made_for_ros_find_their_scene_again(file: Path) -> None:
    ids = list[str]()

    async def before(service: Service) -> None:
        cell = Cell(service)
        await edit(service, cell.session, {"add": BALL})
        ids.append(cell.session.id)

    async def after(service: Service) -> None:
        cell = Cell(service)
        assert cell.session.id == ids[0]
        assert await objects(service, cell.session) == ["ball"]

    served(file, before)
    served(file, after)


def test_a_worker_that_dies_keeps_nothing_from_being_kept(file: Path) -> None:
    async def test(service: Service) -> None:
        session = service.create()
        (pid,) = service.pools[Lane.KEEPING].pids
        os.kill(pid, signal.SIGKILL)
        for _ in range(2):  # the first may find the process gone
            try:
                await edit(service, session, {"add": BALL})
                break
            except RequestRefused as refusal:
                assert refusal.why is Why.WORKER_LOST
        with Warehouse(file) as kept:
            assert list(kept.scene(session.id).objects) == ["ball"]

    served(file, test)
