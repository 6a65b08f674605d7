"""Malformed and hostile messages: each is answered with a reason or cut off, and the server goes on."""

import asyncio
import json
from collections.abc import AsyncGenerator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from websockets.exceptions import ConnectionClosed, ConnectionClosedError

from tests.ros.rosbridge.bridged import FEW, Client, bridged, talk
from tests.ros.rosbridge.test_moveit_services import STRAIGHT, goal, motion
from trajopt.ros.rosbridge.connection import WAITING, converse

DEEP = "[" * 20_000 + "]" * 20_000
MESH = {"vertices": [{"x": 0.0}] * 3, "triangles": [{"vertex_indices": [0, 1, 2]}] * 4000}

TOLD: list[str] = [
    "",
    "no JSON",
    "[]",
    "3",
    "null",
    '"op"',
    "{}",
    '{"op": null}',
    '{"op": 3}',
    '{"op": "hop"}',
    '{"op": "png", "data": ""}',
    '{"op": "auth", "mac": "x"}',
    '{"op": "advertise_action", "action": "/execute_trajectory", "type": "a/B"}',
    '{"op": "advertise_action"}',
    '{"op": "unadvertise_action", "action": 3}',
    '{"op": "action_feedback", "id": "x", "action": "/x", "values": {}}',
    '{"op": "action_result", "id": "x", "action": "/x", "values": {}}',
    '{"op": "action_result", "id": "x", "action": "/x", "values": {}, "status": "done"}',
    '{"op": "publish"}',
    '{"op": "publish", "topic": ""}',
    '{"op": "publish", "topic": 3, "msg": {}}',
    '{"op": "publish", "topic": "/a b", "msg": {}}',
    '{"op": "publish", "topic": "/unknown", "msg": {}}',
    '{"op": "publish", "topic": "/joint_states", "msg": {}}',
    '{"op": "publish", "topic": "/robot_description", "msg": {"data": "mine"}}',
    '{"op": "publish", "topic": "/collision_object", "msg": {"id": 3}}',
    '{"op": "publish", "topic": "/collision_object", "msg": {"id": "x", "operation": 3}}',
    '{"op": "publish", "topic": "/collision_object", "msg": {"id": "x", "pose": {"position": {"x": NaN}}}}',
    '{"op": "publish", "topic": "/collision_object", "msg": {"id": "x", "pose": {"position": {"x": 1e999}}}}',
    '{"op": "publish", "topic": "/planning_scene", "msg": {"world": [1, 2, 3]}}',
    '{"op": "publish", "topic": "/execute_trajectory/goal", "msg": {"goal": {}, "goal_id": 7}}',
    '{"op": "advertise", "topic": "/x"}',
    '{"op": "advertise", "topic": "/joint_states", "type": "sensor_msgs/JointState"}',
    '{"op": "advertise", "topic": "/planning_scene", "type": "std_msgs/String"}',
    '{"op": "subscribe"}',
    '{"op": "subscribe", "topic": "/joint_states", "type": "std_msgs/String"}',
    '{"op": "subscribe", "topic": "/joint_states", "compression": "png"}',
    '{"op": "subscribe", "topic": "/joint_states", "compression": "cbor"}',
    '{"op": "subscribe", "topic": "/joint_states", "throttle_rate": -1}',
    '{"op": "subscribe", "topic": "/joint_states", "throttle_rate": 1e300}',
    '{"op": "call_service"}',
    '{"op": "call_service", "service": 3}',
    '{"op": "service_response", "id": "x", "values": {}}',
    '{"op": "advertise_service", "service": "/rosapi/topics", "type": "a/B"}',
    '{"op": "send_action_goal"}',
    '{"op": "cancel_action_goal", "id": "x", "action": "/execute_trajectory"}',
    '{"op": "fragment", "id": "x", "data": "a", "num": 3, "total": 2}',
    '{"op": "fragment", "id": "x", "data": "a", "num": 0, "total": 1000000000}',
    '{"op": "fragment", "id": "x", "data": "a", "num": -1, "total": 2}',
    '{"op": "fragment", "id": "x", "data": "no JSON", "num": 0, "total": 1}',
    '{"op": "fragment", "id": "x", "data": "{\\"op\\": \\"fragment\\"}", "num": 0, "total": 1}',
    '{"op": "set_level", "level": "loud"}',
    json.dumps({"op": "publish", "topic": "/" + "a" * 2000, "msg": {}}),
    '{"op": "publish", "topic": "/collision_object", "msg": ' + DEEP + "}",
    DEEP,
    '{"op": "status", "id": "\\ud800"}',
]
"""What is answered with a status."""


def test_each_is_answered_with_a_status_and_a_reason(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        for text in TOLD:
            await client.socket.send(text)
            told = await client.hear()
            assert told["op"] == "status" and told["level"] == "error" and told["msg"], text[:200]
            assert str(tmp_path) not in told["msg"]
        assert (await client.call("/compute_fk", {"fk_link_names": ["hand"]}))["error_code"]["val"] == 1

    talk(tmp_path, test)


CALLS: list[tuple[str, Any]] = [
    ("/fly", {}),
    ("/rosapi/fly", {}),
    ("/rosapi/get_param", {"name": 3}),
    ("/rosapi/get_param", []),
    ("/rosapi/set_param", {"name": "a", "value": "x" * 200_000}),
    ("/rosapi/message_details", {"type": "os/system"}),
    ("/rosapi/message_details", {"type": "../../etc/passwd"}),
    ("/file_server/get_file", {"name": "package://lab_description/../lab.urdf"}),
    ("/file_server/get_file", {"name": "file:///etc/passwd"}),
    ("/file_server/get_file", 3),
    ("/compute_fk", 3),
    ("/compute_fk", "all"),
    ("/compute_fk", {"fk_link_names": "hand"}),
    ("/compute_fk", {"fk_link_names": [3]}),
    ("/compute_fk", {"robot_state": {"joint_state": {"name": ["wrist"], "position": ["0"]}}}),
    ("/compute_fk", {"robot_state": {"joint_state": {"name": ["wrist"], "position": [None]}}}),
    ("/compute_ik", {"ik_request": 7}),
    ("/plan_kinematic_path", {"motion_plan_request": {"goal_constraints": {}}}),
    ("/plan_kinematic_path", motion(goal(0.1, 0.2, 0.3), allowed_planning_time="long")),
    ("/plan_kinematic_path", motion(goal(0.1, 0.2, 0.3), num_planning_attempts=2**40)),
    ("/apply_planning_scene", {"scene": {"world": {"collision_objects": [{"id": "m", "meshes": [MESH]}]}}}),
    ("/check_state_validity", {"robot_state": STRAIGHT, "group_name": 3}),
]
"""Calls that are answered with `result: false`."""


def test_each_call_is_answered_with_a_reason(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        for service, args in CALLS:
            answer = await client.ask(service, args)
            assert answer["result"] is False and isinstance(answer["values"], str), (service, answer)
            assert answer["values"] and str(tmp_path) not in answer["values"]
        assert not (await client.ask("/rosapi/topics", compression="png"))["result"]
        assert (await client.call("/rosapi/get_ros_version"))["version"] == 2

    talk(tmp_path, test, limits=FEW)


def test_disconnects_a_client_that_sends_too_large_a_message(tmp_path: Path) -> None:
    async def run() -> None:
        async with bridged(tmp_path) as bridge:
            for large in ("x" * (FEW.body + 1), b"\xff\xfe"):
                async with bridge.client() as client:
                    await client.socket.send(large)
                    if isinstance(large, bytes):
                        assert (await client.hear())["op"] == "status"
                        continue
                    with pytest.raises(ConnectionClosed):
                        await client.hear()
            async with bridge.client() as client:
                size = FEW.body // 2
                for num in range(3):
                    await client.say(op="fragment", id="f", data="x" * size, num=num, total=9)
                assert "at most" in (await client.hear())["msg"]
                for num in range(20):
                    await client.say(op="fragment", id=f"f{num}", data="x", num=0, total=2)
                assert "at most" in (await client.hear())["msg"]
                assert (await client.call("/rosapi/get_ros_version"))["version"] == 2

    asyncio.run(asyncio.wait_for(run(), 100.0))


def test_one_client_cannot_take_all_there_is(tmp_path: Path) -> None:
    async def run() -> None:
        async with bridged(tmp_path, connections=3, calls=4) as bridge, bridge.client() as client:
            for num in range(300):
                await client.say(op="subscribe", topic=f"/t{num}")
            assert "at most" in (await client.hear())["msg"]
            await client.say(op="advertise_service", service="/slow", type="a/B")
            async with bridge.client() as other:
                for num in range(6):
                    await other.say(op="call_service", id=str(num), service="/slow")
                refused = await other.hear(result=False)
                assert "under way" in refused["values"]
                async with bridge.client():
                    with pytest.raises(ConnectionClosed):
                        async with bridge.client() as fourth:
                            await fourth.hear()
            await client.hear(op="call_service")

    asyncio.run(asyncio.wait_for(run(), 100.0))


def test_a_client_that_reads_nothing_does_not_block_others(tmp_path: Path) -> None:
    async def run() -> None:
        async with bridged(tmp_path) as bridge, bridge.client() as deaf, bridge.client() as client:
            await deaf.say(op="subscribe", topic="/noise", type="std_msgs/String")
            await client.say(op="advertise", topic="/noise", type="std_msgs/String")
            await client.call("/rosapi/get_time")
            for _ in range(600):
                await client.say(op="publish", topic="/noise", msg={"data": "x" * 20_000})
            assert (await client.call("/rosapi/get_ros_version"))["version"] == 2

    asyncio.run(asyncio.wait_for(run(), 100.0))


class Gone:
    """A socket of a client that has gone: what it said is still there, and nothing can be sent any more."""

    async def __aiter__(self) -> AsyncGenerator[str]:
        for _ in range(4 * WAITING):
            yield "no JSON"

    async def send(self, _: str) -> None:
        raise ConnectionClosedError(None, None)


def test_forgets_a_client_that_leaves_with_messages_pending() -> None:
    bridge: Any = SimpleNamespace(
        clients=set(), options=SimpleNamespace(connections=4), largest=1000, leave=lambda _: None
    )
    asyncio.run(asyncio.wait_for(converse(bridge, cast("Any", Gone())), 20.0))
    assert bridge.clients == set()


def test_who_leaves_in_the_midst_is_forgotten(tmp_path: Path) -> None:
    async def run() -> None:
        async with bridged(tmp_path) as bridge:
            async with bridge.client() as client:
                await client.say(
                    op="call_service", id="a", service="/plan_kinematic_path", args=motion(goal(1, 1, 1))
                )
                await client.say(op="advertise_service", service="/mine", type="a/B")
                await client.say(op="subscribe", topic="/only_mine")
            reader, writer = await asyncio.open_connection("127.0.0.1", bridge.port)
            writer.write(b"GET / HT")  # and then nothing
            async with bridge.client() as other:
                assert "/only_mine" not in (await other.call("/rosapi/topics"))["topics"]
                assert not (await other.ask("/mine"))["result"]
                answer = await other.call("/plan_kinematic_path", motion(goal(0.1, 0.2, 0.3)))
                assert answer["motion_plan_response"]["error_code"]["val"] == 1
            writer.close()
            del reader

    asyncio.run(asyncio.wait_for(run(), 100.0))
