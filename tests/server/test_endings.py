"""What is left when something ends in the midst: a client, a start, the server, a listener."""

import asyncio
import json
import subprocess
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.server.test_service import ROOMS, SMALL, served, why
from trajopt.server import Lane, Limits, RequestRefused, Service, Why
from trajopt.server.messages import LENGTH
from trajopt.server.session import Keeper
from trajopt.server.warehouse import Warehouse


def test_no_other_client_drives_an_abandoned_robot_until_it_stops() -> None:
    async def test(service: Service) -> None:
        session = service.create()
        moving = asyncio.Event()
        said = {"to": [0.3, 0.1], "rest": [0.5, 0.2]}
        run = asyncio.create_task(service.ask(session, "brake", said, listener=lambda _: moving.set()))
        await moving.wait()
        run.cancel()
        await asyncio.gather(run, return_exceptions=True)
        assert session.run is not None
        assert await why(service.ask(session, "move", {"to": [0.0, 0.0]})) is Why.BUSY
        await service.ask(session, "add", {"name": "seen"})  # now it comes to rest
        while session.run is not None:
            await asyncio.sleep(0.01)
        assert session.positions == [0.5, 0.2]

    served(test)


@pytest.fixture
def processes(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[bytes]]:
    """All workers that are started."""
    started, popen = list[subprocess.Popen[bytes]](), subprocess.Popen

    def recorded(*arguments: Any, **options: Any) -> subprocess.Popen[bytes]:
        started.append(popen(*arguments, **options))
        return started[-1]

    monkeypatch.setattr("trajopt.server.worker_process.subprocess.Popen", recorded)
    return started


def test_closing_while_a_worker_is_starting_refuses_its_request_and_ends_it(
    processes: list[subprocess.Popen[bytes]],
) -> None:
    async def test(service: Service) -> None:
        up = len(processes)
        run = asyncio.create_task(service.ask(service.create(), "move", {"to": [0.0, 0.0]}))
        while len(processes) == up:
            await asyncio.sleep(0)
        await service.close(drain=0.0)
        assert await why(run) is Why.CLOSING
        assert all(each.poll() is not None for each in processes)

    served(test)


def test_a_change_that_waits_for_another_is_refused_when_the_server_closes() -> None:
    async def test(service: Service) -> None:
        session, begun = service.create(), asyncio.Event()
        first = asyncio.create_task(service.ask(session, "add_when_told", listener=lambda _: begun.set()))
        await begun.wait()
        second = asyncio.create_task(service.ask(session, "add", {"name": "a"}))
        await asyncio.sleep(0)
        await service.close(drain=0.0)
        assert await why(first) is Why.CLOSING
        assert await why(second) is Why.CLOSING

    served(test)


@pytest.mark.parametrize("ending", [OSError("the disk is gone"), asyncio.CancelledError()])
def test_a_start_that_fails_leaves_no_process(
    ending: BaseException,
    processes: list[subprocess.Popen[bytes]],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Any,
) -> None:
    async def restored(*_: object) -> None:
        raise ending

    async def run() -> None:
        with Warehouse(tmp_path / "cell.warehouse") as warehouse:
            service = Service(
                {"planar2": to.load("planar2")}, limits=SMALL, modules=ROOMS, warehouse=warehouse
            )
            with pytest.raises(type(ending)):
                await service.__aenter__()
        assert processes
        assert all(each.poll() is not None for each in processes)

    monkeypatch.setattr(Keeper, "restored", restored)
    asyncio.run(run())


def test_a_worker_that_cannot_be_started_is_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    popen, refused = subprocess.Popen, list[object]()

    def once(*arguments: Any, **options: Any) -> subprocess.Popen[bytes]:
        if not refused:
            refused.append(arguments)
            raise BlockingIOError("no more processes")
        return popen(*arguments, **options)

    async def test(service: Service) -> None:
        session = service.create()
        monkeypatch.setattr("trajopt.server.worker_process.subprocess.Popen", once)
        assert await why(service.ask(session, "die")) is Why.WORKER_LOST
        assert (await service.ask(session, "wait", {"seconds": 0.0})).document() == {"cancelled": False}
        assert refused

    served(test, Limits(workers=1, seconds=20.0))


def test_a_listener_that_fails_ends_its_own_request_and_no_worker() -> None:
    def listener(_: object) -> None:
        raise KeyError("nobody wrote this down")

    async def test(service: Service) -> None:
        session = service.create()
        pids = service.pools
        before = {lane: pool.pids for lane, pool in pids.items()}
        with pytest.raises(KeyError, match="wrote this down"):
            await service.ask(session, "wait", listener=listener)
        assert (await service.ask(session, "wait", {"seconds": 0.0})).document() == {"cancelled": False}
        assert {lane: pool.pids for lane, pool in service.pools.items()} == before

    served(test, Limits(workers=1, seconds=20.0))


def test_a_worker_that_hears_nothing_any_more_ends_and_another_takes_its_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def test(service: Service) -> None:
        session = service.create()
        before = service.pools[Lane.PLANNING].pids
        with monkeypatch.context() as patch:
            patch.setattr("trajopt.server.worker_process.framed", lambda _: LENGTH.pack(1) + b"?")
            assert await why(service.ask(session, "wait", {"seconds": 0.0})) is Why.WORKER_LOST
        assert (await service.ask(session, "wait", {"seconds": 0.0})).document() == {"cancelled": False}
        assert not set(before) & set(service.pools[Lane.PLANNING].pids)

    served(test, Limits(workers=1, seconds=10.0))


def test_a_fork_knows_how_old_its_clouds_are() -> None:
    points = np.full((4, 3), 2.0, dtype="<f4").tobytes()

    async def put(service: Service, session: Any, stamp: float) -> bool:
        said = {"name": "camera", "radius": 0.05, "stamp": stamp}
        reply = await service.ask(session, "cloud", json.dumps(said).encode(), attachment=points)
        return reply.document()["taken"]

    async def test(service: Service) -> None:
        session = service.create()
        assert await put(service, session, 5.0)
        fork = service.fork(session)
        assert not await put(service, fork, 4.0)
        assert await put(service, fork, 6.0)
        assert await put(service, session, 5.5)

    served(test)


def test_the_memory_limit_of_a_request_ignores_earlier_requests() -> None:
    async def test(service: Service) -> None:
        session, some = service.create(), 100 * 2**20
        assert some < SMALL.memory // 2 < 2 * some < SMALL.memory
        pids = service.pools[Lane.PLANNING].pids
        assert (await service.ask(session, "hoard", {"bytes": some})).document() == {"length": some}
        assert (await service.ask(session, "grow", {"bytes": 2 * some})).document() == {"length": 2 * some}
        assert service.pools[Lane.PLANNING].pids == pids
        assert await why(service.ask(session, "grow", {"bytes": SMALL.memory + some})) is Why.OUT_OF_MEMORY

    served(test)


def test_arguments_that_are_no_plain_data_are_refused() -> None:
    async def test(service: Service) -> None:
        with pytest.raises(RequestRefused, match="plain data") as refused:
            await service.ask(service.create(), "echo", {"goal": object()})
        assert refused.value.why is Why.MALFORMED

    served(test)
