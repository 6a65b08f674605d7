"""The clients, blocking and asynchronous, against a server in this process."""

import asyncio
from threading import Thread
from typing import Any

import numpy as np
import pytest

from tests.server.serving import Serving
from trajopt.client import AsyncClient, Client, ServerError, trajectory_of

REACH = {"goal": {"joint_positions": {"positions": {"joint1": 0.4, "joint2": 0.3}}}}
POST = {
    "add": {"name": "post", "shape": {"sphere": {"radius": 0.1}}, "placement": {"xyz": [0.75, -0.4, 0.14]}}
}


def test_a_client_plans_with_feedback(server: Serving) -> None:
    told: list[Any] = []
    with Client(server.url) as client, client.session("planar2") as session:
        assert client.robots()[0]["groups"]
        session.edit([POST])
        answer = session.plan(REACH, listener=told.append)
        assert answer["verified"]
        assert {"stage", "attempt", "best"} <= told[0].keys()
        trajectory = trajectory_of(answer)
        assert trajectory is not None
        np.testing.assert_allclose(trajectory.positions[-1], [0.4, 0.3], atol=1e-3)
        verdict = session.check(REACH, {key: answer[key] for key in ("joint_names", "points")})
        assert verdict["verified"]
        fork = session.fork()
        fork.edit([{"remove": {"name": "post"}}])
        assert list(session.read()["objects"]) == ["post"]
        assert fork.read()["objects"] == {}


def test_what_moveit_asks_is_planned(server: Serving) -> None:
    joints = [{"joint_name": "joint1", "position": 0.4}, {"joint_name": "joint2", "position": 0.3}]
    with Client(server.url) as client, client.session() as session:
        assert session.plan_request({"goal_constraints": [{"joint_constraints": joints}]})["verified"]


def test_a_refusal_has_a_reason(server: Serving) -> None:
    with Client(server.url) as client, client.session() as session:
        with pytest.raises(ServerError, match="did you mean") as refused:
            session.plan({"gaol": {}})
        assert (refused.value.status, refused.value.kind) == (400, "malformed")
        with pytest.raises(ServerError, match="gaol"):
            session.plan({"gaol": {}}, listener=lambda _: None)
        session.close()
        with pytest.raises(ServerError) as refused:
            session.read()
        assert refused.value.status == 404
        session.id = client.session().id
    with pytest.raises(ServerError, match="unreachable"), Client("http://127.0.0.1:9") as nobody:
        nobody.robots()


def test_the_robot_is_driven_and_stopped(server: Serving) -> None:
    with Client(server.url) as client, client.session() as session:
        answer = session.execute(REACH, speed=0)
        assert answer["reached"]
        assert session.read()["positions"]["joint1"] == pytest.approx(0.4, abs=5e-3)
        far = {"goal": {"joint_positions": {"positions": {"joint1": -2.5, "joint2": 0.3}}}}
        ended: list[Any] = []
        moving: list[Any] = []
        drive = Thread(target=lambda: ended.append(session.execute(far, speed=0.2, listener=moving.append)))
        drive.start()
        while not moving:
            drive.join(0.02)
        with pytest.raises(ServerError) as refused:
            session.execute(far)
        assert refused.value.status == 409
        session.edit([POST])
        assert list(session.read()["objects"]) == ["post"]
        seen = len(moving)
        while len(moving) < seen + 3 and drive.is_alive():
            drive.join(0.02)
        assert session.stop()["stopping"]
        drive.join(30.0)
        assert ended[0]["stopped"]
        assert "world changed" in [event["kind"] for event in ended[0]["events"]]
        assert not session.stop()["stopping"]


def test_a_request_is_cancelled_by_its_name(server: Serving) -> None:
    with Client(server.url) as client, client.session() as session:
        begun: list[Any] = []
        ended: list[Any] = []

        def wait() -> None:
            ended.append(session.ask("wait", {}, listener=begun.append, name="long"))

        thread = Thread(target=wait)
        thread.start()
        while not begun:
            thread.join(0.02)
        session.cancel("long")
        thread.join(30.0)
        assert ended == [{"cancelled": True}]
        with pytest.raises(ServerError):
            session.cancel("long")


def test_an_asynchronous_client_asks_many_things_at_once_and_comes_again_when_it_is_full(
    server: Serving,
) -> None:
    async def run() -> None:
        async with AsyncClient(server.url) as client:
            sessions = [await client.session() for _ in range(3)]
            asked = [each.plan(REACH) for each in sessions for _ in range(8)]
            answers = await asyncio.gather(*asked)
            assert all(answer["verified"] for answer in answers)
            told: list[Any] = []
            assert (await sessions[0].plan(REACH, listener=told.append))["verified"]
            assert told
            fork = await sessions[0].fork()
            await asyncio.gather(*(each.close() for each in [*sessions, fork]))

    asyncio.run(run())
    assert b'outcome="full"' in server.metrics.text()
