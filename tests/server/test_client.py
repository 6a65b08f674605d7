"""The clients, blocking and asynchronous, against a server in this process."""

import asyncio
import io
from threading import Thread
from typing import Any

import httpx
import numpy as np
import pytest

import trajopt as to
from tests.server.serving import Serving
from trajopt.server.client import AsyncClient, Client, ServerError, task_result_of, trajectory_of

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


def test_an_unknown_parameter_of_the_address_is_refused(server: Serving) -> None:
    with Client(server.url) as client, client.session("planar2") as session:
        address = f"{server.url}/sessions/{session.id}/plan"
        assert httpx.post(address, json={"problem": REACH}, params={"timeout": 20}).json()["verified"]
        refused = httpx.post(address, json={"problem": REACH}, params={"timout": 20})
        assert refused.status_code == 400 and "'timout'" in refused.json()["error"]["reason"]


def test_a_task_is_planned_and_its_result_read_here(server: Serving) -> None:
    job = {
        "stages": [{"move_to": {"joint1": 0.4, "joint2": 0.3}, "name": "there"}, {"dwell": 0.1}],
        "name": "rounds",
    }
    told: list[Any] = []
    with Client(server.url) as client, client.session("planar2") as session:
        session.edit([POST])
        answer = session.task(job, result=True, listener=told.append)
        assert answer["verified"] and told
        assert [stage["name"] for stage in answer["stages"]] == ["there", "dwell"]
        result = task_result_of(answer, to.load("planar2"))
        assert result.certificate.verified and list(result.scene.objects) == ["post"]
        assert "result" not in session.task(job)
        with pytest.raises(ServerError, match="is for tasks in files"):
            session.task({"stages": [{"follow": "tool", "file": "/etc/passwd"}]})
        with pytest.raises(ServerError, match=r"stages\[0\]: seconds must be positive"):
            session.task({"stages": [{"dwell": -1}]})


def test_a_cloud_replaces_the_previous_cloud(server: Serving) -> None:
    wall = np.stack(np.meshgrid([0.75], np.linspace(-0.5, -0.3, 9), [0.14]), axis=-1).reshape(-1, 3)
    with Client(server.url) as client, client.session("planar2") as session:
        told = session.with_cloud("camera", np.vstack((wall, [[np.nan, 0, 0]])), radius=0.03, stamp=2.0)
        assert told["taken"] and (told["points"], told["balls"]) == (10, 9)
        (part,) = session.read()["objects"]["camera"]["parts"]
        assert np.allclose(part["shape"]["points"]["points"], wall, atol=1e-6)
        assert not session.ask("validity", {"positions": [-0.49, 0.0]})["valid"]
        late = session.with_cloud("camera", wall + 1.0, radius=0.03, stamp=1.0)
        assert not late["taken"] and late["newest"] == 2.0
        assert not session.ask("validity", {"positions": [-0.49, 0.0]})["valid"]
        session.edit([POST])
        assert not session.with_cloud("camera", wall + 1.0, radius=0.03, stamp=1.5)["taken"]
        session.edit([{"remove": {"name": "post"}}])
        assert session.with_cloud("camera", None, radius=0.03, stamp=3.0)["balls"] == 0
        assert session.ask("validity", {"positions": [-0.49, 0.0]})["valid"]
        with pytest.raises(to.TrajoptError, match="shape"):
            session.with_cloud("camera", [[1.0, 2.0]])


def test_a_cloud_of_a_sensor_leaves_out_the_robot(server: Serving) -> None:
    scene = to.Scene(to.load("planar2"))
    on_the_arm = [scene.placement_of("tool", np.zeros(2)).translation.tolist()]
    with Client(server.url) as client, client.session("planar2") as session:
        session.edit([{"stand": [0.0, 0.0]}])
        told = session.with_cloud("lidar", [*on_the_arm, [2.0, 2.0, 0.1]], cell=0.01, spacing=0.002)
        assert (told["balls"], told["cells taken for the robot"]) == (1, 1)
        assert session.ask("validity", {"positions": [0.0, 0.0]})["valid"]
        elsewhere = session.with_cloud("lidar", on_the_arm, positions=[1.5, 0.0], cell=0.01)
        assert elsewhere["balls"] == 1
        assert not session.ask("validity", {"positions": [0.0, 0.0]})["valid"]


def test_accepts_clouds_in_numpy_format(server: Serving) -> None:
    with Client(server.url) as client, client.session("planar2") as session:
        for kind in ("<f4", "<f8"):
            file = io.BytesIO()
            np.save(file, np.ones((5, 4), dtype=kind))
            address = f"{server.url}/sessions/{session.id}/cloud?name=camera&radius=0.02"
            headers = {"content-type": "application/octet-stream"}
            answer = httpx.post(address, content=file.getvalue(), headers=headers)
            assert answer.status_code == 200 and answer.json()["balls"] == 5


def test_a_cloud_enters_an_execution(server: Serving) -> None:
    far = {"goal": {"joint_positions": {"positions": {"joint1": 1.4, "joint2": 0.3}}}}

    def told(moving: list[Any]) -> list[Any]:
        return [event for each in moving for event in each["events"]]

    with Client(server.url) as client, client.session("planar2") as session:
        moving: list[Any] = []
        ended: list[Any] = []
        drive = Thread(target=lambda: ended.append(session.execute(far, speed=0.05, listener=moving.append)))
        drive.start()
        while not moving:
            drive.join(0.02)
        session.with_cloud("camera", [[-0.75, -0.4, 0.14]], radius=0.1, stamp=1.0)
        while drive.is_alive() and not any(event["kind"] == "world changed" for event in told(moving)):
            drive.join(0.02)
        session.stop()
        drive.join(60.0)
        assert "world changed" in [event["kind"] for event in ended[0]["events"]]
        assert list(session.read()["objects"]) == ["camera"]


def test_plans_a_moveit_request(server: Serving) -> None:
    joints = [{"joint_name": "joint1", "position": 0.4}, {"joint_name": "joint2", "position": 0.3}]
    with Client(server.url) as client, client.session() as session:
        assert session.ask("plan", {"request": {"goal_constraints": [{"joint_constraints": joints}]}})[
            "verified"
        ]


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


def test_an_asynchronous_client_sends_concurrent_requests_and_retries(
    server: Serving,
) -> None:
    async def run() -> None:
        async with AsyncClient(server.url) as client:
            sessions = [await client.session() for _ in range(3)]
            begun = asyncio.Event()
            held = asyncio.create_task(
                sessions[0].ask("wait", listener=lambda _: begun.set(), name="the only worker")
            )
            await begun.wait()
            asked = [asyncio.create_task(each.plan(REACH)) for each in sessions for _ in range(8)]
            while b'outcome="full"' not in server.metrics.text():
                await asyncio.sleep(0.02)
            await sessions[0].cancel("the only worker")
            await held
            answers = await asyncio.gather(*asked)
            assert all(answer["verified"] for answer in answers)
            told: list[Any] = []
            assert (await sessions[0].plan(REACH, listener=told.append))["verified"]
            assert told
            fork = await sessions[0].fork()
            await asyncio.gather(*(each.close() for each in [*sessions, fork]))

    asyncio.run(run())


def test_an_edit_that_is_refused_names_its_place_once(server: Serving) -> None:
    with Client(server.url) as client, client.session("planar2") as session:
        assert repr(session) == f"Session('planar2', id {session.id!r})"
        with pytest.raises(ServerError) as refused:
            session.edit([{"add": {"name": "box", "shape": {"box": {"x": 0.1, "y": 0.1}}}}])
        assert str(refused.value).count("edits[0]") == 1
        assert "edits[0].add.shape.box: missing a required argument: 'z'" in str(refused.value)
