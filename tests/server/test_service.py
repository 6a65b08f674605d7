"""The core of the server: sessions, workers and the queue, without a protocol."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import msgspec
import pytest

import trajopt as to
from trajopt.server import Cancellation, Lane, Limits, RequestRefused, Service, Why

ROOMS = ("trajopt.server.operations", "tests.server.room")
SMALL = Limits(workers=1, waiting=8, waiting_per_session=4, grace=0.5, seconds=60.0, memory=256 * 2**20)


def served(test: Callable[[Service], Awaitable[None]], limits: Limits = SMALL) -> None:
    """Run a test with a service of a planar arm."""

    async def run() -> None:
        async with Service({"planar2": to.load("planar2")}, limits=limits, modules=ROOMS) as service:
            await test(service)

    asyncio.run(asyncio.wait_for(run(), 120.0))


async def why(asked: Awaitable[Any]) -> Why:
    with pytest.raises(RequestRefused) as refused:
        await asked
    return refused.value.why


JOINTS = [{"joint_name": "joint1", "position": 0.4}, {"joint_name": "joint2", "position": 0.3}]
GOAL = {"request": {"goal_constraints": [{"joint_constraints": JOINTS}]}}


def test_a_plan_with_feedback() -> None:
    async def test(service: Service) -> None:
        heard: list[msgspec.Raw] = []
        session = service.create()
        reply = await service.ask(session, "plan", GOAL, listener=heard.append)
        assert reply.document()["verified"]
        assert reply.cpu > 0.0
        stages = [msgspec.json.decode(bytes(each))["stage"] for each in heard]
        assert "optimise" in stages
        assert msgspec.json.decode(bytes(heard[-1]))["best"] == reply.document()["duration"]

    served(test)


def test_sessions_are_edited_and_forked_apart() -> None:
    async def test(service: Service) -> None:
        one = service.create("planar2")
        await service.ask(one, "add", {"name": "a"})
        other = service.fork(one)
        await service.ask(other, "add", {"name": "b"})
        assert (await service.ask(one, "echo")).document()["objects"] == ["a"]
        assert (await service.ask(other, "echo")).document()["objects"] == ["a", "b"]
        assert (one.revision, other.revision) == (1, 1)
        service.sessions.remove(one.id)
        with pytest.raises(RequestRefused):
            service.sessions.get(one.id)

    served(test)


def test_changes_of_one_session_wait_for_each_other() -> None:
    async def test(service: Service) -> None:
        session = service.create()
        await asyncio.gather(*(service.ask(session, "add", {"name": f"s{i}"}) for i in range(4)))
        assert (await service.ask(session, "echo")).document()["objects"] == ["s0", "s1", "s2", "s3"]

    served(test, Limits(workers=2))


def test_refuses_a_wrong_request_with_the_reason() -> None:
    async def test(service: Service) -> None:
        session = service.create()
        with pytest.raises(RequestRefused, match="gaol_constraints") as refused:
            await service.ask(session, "plan", {"gaol_constraints": []})
        assert refused.value.why is Why.MALFORMED
        for body in (b"{", b"[]", b"\xff", b'{"a": 1, "a": 2}', b"[" * 200 + b"]" * 200):
            assert await why(service.ask(session, "echo", body)) is Why.MALFORMED
        assert await why(service.ask(session, "ecko")) is Why.UNKNOWN
        assert await why(service.ask(session, "echo", b" " * (SMALL.body + 1))) is Why.TOO_LARGE
        with pytest.raises(to.TrajoptError, match="planar3"):
            service.create("planar3")

    served(test)


def test_a_fault_of_the_server_does_not_tell_of_its_files(capfd: pytest.CaptureFixture[str]) -> None:
    async def test(service: Service) -> None:
        with pytest.raises(RequestRefused) as refused:
            await service.ask(service.create(), "fault")
        assert refused.value.why is Why.FAILED
        assert "secret" not in refused.value.reason

    served(test)
    assert "secret" in capfd.readouterr().err


def test_a_worker_that_dies_takes_only_its_request_with_it() -> None:
    async def test(service: Service) -> None:
        session = service.create()
        assert await why(service.ask(session, "die")) is Why.WORKER_LOST
        assert (await service.ask(session, "plan", GOAL)).document()["verified"]
        assert service.pools[Lane.PLANNING].restarts == 1

    served(test)


def test_a_request_that_takes_too_much_memory_is_refused_and_the_next_is_done() -> None:
    async def test(service: Service) -> None:
        session = service.create()
        assert await why(service.ask(session, "grow", {"bytes": 2**30})) is Why.OUT_OF_MEMORY
        assert (await service.ask(session, "grow", {"bytes": 2**20})).document()["length"] == 2**20

    served(test)


def test_cancelling_ends_running_and_waiting_requests() -> None:
    async def test(service: Service) -> None:
        session, running, waiting = service.create(), Cancellation(), Cancellation()
        began = asyncio.Event()
        first = asyncio.create_task(
            service.ask(session, "wait", listener=lambda _: began.set(), cancellation=running)
        )
        await began.wait()
        second = asyncio.create_task(service.ask(session, "wait", cancellation=waiting))
        await asyncio.sleep(0)
        waiting()
        assert await why(second) is Why.CANCELLED
        running()
        assert (await first).document() == {"cancelled": True}

    served(test)


def test_kills_a_worker_that_does_not_end_on_request() -> None:
    async def test(service: Service) -> None:
        session = service.create()
        assert await why(service.ask(session, "stubborn", seconds=0.2)) is Why.OUT_OF_TIME
        began = asyncio.Event()
        task = asyncio.create_task(service.ask(session, "stubborn", listener=lambda _: began.set()))
        await began.wait()
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert (await service.ask(session, "wait", {"seconds": 0.0})).document() == {"cancelled": False}
        assert service.pools[Lane.PLANNING].restarts == 2

    served(test)


def test_a_full_queue_is_reported_and_no_session_fills_it_alone() -> None:
    async def test(service: Service) -> None:
        greedy, other = service.create(), service.create()
        began = asyncio.Event()
        tasks = [asyncio.create_task(service.ask(greedy, "wait", listener=lambda _: began.set()))]
        await began.wait()
        tasks += [asyncio.create_task(service.ask(greedy, "wait", {"seconds": 0.0})) for _ in range(4)]
        await asyncio.sleep(0)
        with pytest.raises(RequestRefused, match="of this session") as refused:
            await service.ask(greedy, "wait")
        assert refused.value.why is Why.FULL
        assert refused.value.retry_after is not None
        order: list[str] = []
        for task in tasks[1:3]:
            task.add_done_callback(lambda _: order.append("greedy"))
        late = asyncio.create_task(service.ask(other, "wait", {"seconds": 0.0}))
        late.add_done_callback(lambda _: order.append("other"))
        await asyncio.sleep(0)
        for task in tasks[:1]:
            task.cancel()
        await asyncio.gather(*tasks, late, return_exceptions=True)
        assert order.index("other") == 1

    served(test)


def test_closing_refuses_pending_requests() -> None:
    async def test(service: Service) -> None:
        session = service.create()
        running = asyncio.create_task(service.ask(session, "wait"))
        waiting = asyncio.create_task(service.ask(session, "wait"))
        await asyncio.sleep(0.05)
        await service.close(drain=0.1)
        assert await why(running) is Why.CLOSING
        assert await why(waiting) is Why.CLOSING
        assert await why(service.ask(session, "echo")) is Why.CLOSING

    served(test)


def test_sessions_are_bounded_and_the_unused_go() -> None:
    async def test(service: Service) -> None:
        kept = service.create(face="rosbridge")
        first = service.create()
        with pytest.raises(RequestRefused, match="in use"):
            service.create()
        first.used -= service.limits.idle
        service.create()
        service.sessions.get(kept.id)
        with pytest.raises(RequestRefused):
            service.sessions.get(first.id)

    served(test, Limits(workers=1, sessions=2))


@pytest.mark.parametrize("name", ["workers", "seconds", "memory"])
def test_limits_are_positive(name: str) -> None:
    with pytest.raises(to.TrajoptError, match=name):
        Limits(**{name: 0})


def test_a_scene_that_is_edited_while_the_robot_is_driven_leaves_it_where_it_has_got_to() -> None:
    async def test(service: Service) -> None:
        session = service.create()
        begun, moved = asyncio.Event(), asyncio.Event()
        finish, halt = Cancellation(), Cancellation()
        edit = asyncio.create_task(
            service.ask(session, "add_when_told", listener=lambda _: begun.set(), cancellation=finish)
        )
        await begun.wait()
        run = asyncio.create_task(
            service.ask(
                session, "move", {"to": [0.7, 0.2]}, listener=lambda _: moved.set(), cancellation=halt
            )
        )
        await moved.wait()
        finish()
        await edit
        assert session.revision == 1
        assert session.positions == [0.7, 0.2]
        with pytest.raises(RequestRefused, match="the robot is being driven") as refused:
            await service.ask(session, "edit", {"edits": [{"stand": [0.0, 0.0]}]})
        assert refused.value.why is Why.BUSY
        said = {"is_diff": True, "robot_state": {"joint_state": {"name": ["joint1"], "position": [-1.0]}}}
        noted = await service.ask(session, "planning_scene", said)
        assert "are ignored" in noted.document()["notes"][-1]
        assert session.positions == [0.7, 0.2]
        halt()
        await run
        await service.ask(session, "planning_scene", said)
        assert session.positions == [-1.0, 0.2]

    served(test)
