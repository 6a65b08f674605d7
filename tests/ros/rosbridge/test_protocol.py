"""The protocol: topics, services of clients, pieces of messages, and what the server tells of itself."""

import asyncio
import json
from pathlib import Path

import pytest

from tests.ros.rosbridge.bridged import Client, bridged, talk
from trajopt.ros.rosbridge import Distro, RosbridgeOptions


def test_each_subscriber_receives_a_published_message_once(tmp_path: Path) -> None:
    async def run() -> None:
        async with bridged(tmp_path) as bridge, bridge.client() as one, bridge.client() as other:
            for client in (one, other):
                for name in ("a", "b"):
                    await client.say(op="subscribe", id=name, topic="/chatter", type="std_msgs/String")
            assert (await other.call("/rosapi/topic_type", {"topic": "/chatter"}))[
                "type"
            ] == "std_msgs/msg/String"
            await one.say(op="advertise", topic="chatter", type="std_msgs/msg/String")
            await one.say(op="publish", topic="/chatter", msg={"data": "Hello"})
            await one.say(op="publish", topic="/chatter", msg={"data": "again"})
            for client in (one, other):
                assert (await client.hear())["msg"] == {"data": "Hello"}
                assert (await client.hear())["msg"] == {"data": "again"}
            await other.say(op="unsubscribe", id="a", topic="/chatter")
            await other.call("/rosapi/get_time")
            await one.say(op="publish", topic="/chatter", msg={"data": "third"})
            assert (await other.hear())["msg"] == {"data": "third"}
            await other.say(op="unsubscribe", topic="/chatter")
            await other.call("/rosapi/get_time")
            await one.say(op="publish", topic="/chatter", msg={"data": "fourth"})
            await one.call("/rosapi/get_time")
            await other.say(op="call_service", id="last", service="/rosapi/get_time")
            assert (await other.hear())["id"] == "last"

    asyncio.run(asyncio.wait_for(run(), 100.0))


def test_the_robot_is_described_to_who_comes_late(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        for topic, start in (("/robot_description", "<robot"), ("/robot_description_semantic", "<robot")):
            await client.say(op="subscribe", topic=topic, type="std_msgs/msg/String")
            assert (await client.hear(topic=topic))["msg"]["data"].startswith(start)
        await client.say(op="advertise", topic="/map", type="my_msgs/msg/Map", latch=True)
        await client.say(op="publish", topic="/map", msg={"cells": [1, 2]}, latch=True)
        await client.say(op="subscribe", topic="/map")
        assert (await client.hear(topic="/map"))["msg"] == {"cells": [1, 2]}

    talk(tmp_path, test)


def test_joint_states_and_the_scene_are_published(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        await client.say(op="subscribe", topic="/joint_states", type="sensor_msgs/msg/JointState")
        state = (await client.hear(topic="/joint_states"))["msg"]
        assert state["name"] == ["shoulder", "elbow", "wrist"] and state["header"]["stamp"]["sec"] > 0
        await client.say(op="unsubscribe", topic="/joint_states")
        await client.say(op="subscribe", topic="/monitored_planning_scene")
        scene = (await client.hear(topic="/monitored_planning_scene"))["msg"]
        assert scene["world"]["collision_objects"] == []
        ball = {
            "id": "ball",
            "primitives": [{"type": 2, "dimensions": [0.1]}],
            "pose": {"position": {"y": 2}},
        }
        await client.say(op="publish", topic="/collision_object", msg=ball)
        scene = (await client.hear(topic="/monitored_planning_scene"))["msg"]
        assert [each["id"] for each in scene["world"]["collision_objects"]] == ["ball"]
        held = {"link_name": "hand", "object": {"id": "ball"}}
        await client.say(op="publish", topic="/attached_collision_object", msg=held)
        scene = (await client.hear(topic="/monitored_planning_scene"))["msg"]
        assert scene["robot_state"]["attached_collision_objects"][0]["object"]["id"] == "ball"
        nothing = {"is_diff": False}
        await client.say(op="publish", topic="/planning_scene", msg=nothing)
        scene = (await client.hear(topic="/monitored_planning_scene"))["msg"]
        assert scene["robot_state"]["attached_collision_objects"] == []

    talk(tmp_path, test)


def test_a_service_of_one_client_is_called_by_another(tmp_path: Path) -> None:
    async def run() -> None:
        async with bridged(tmp_path) as bridge, bridge.client() as one:
            async with bridge.client() as other:
                await other.say(op="advertise_service", service="/double", type="my_srvs/Double")
                await other.call("/rosapi/get_time")
                asked = asyncio.create_task(one.ask("/double", {"x": 2}))
                call = await other.hear(op="call_service", service="/double")
                await other.say(op="service_response", id=call["id"], values={"y": 2 * call["args"]["x"]})
                assert (await asked)["values"] == {"y": 4}
                asked = asyncio.create_task(one.ask("/double", {"x": 2}))
                call = await other.hear(op="call_service")
                failed = {"id": call["id"], "values": "no", "result": False}
                await other.say(op="service_response", **failed)
                assert not (await asked)["result"]
                asked = asyncio.create_task(one.ask("/double", {"x": 2}))
                await other.hear(op="call_service")
            assert "has left" in (await asked)["values"]
            assert not (await one.ask("/double"))["result"]
            await one.say(op="advertise_service", service="/compute_ik", type="a/B")
            assert "of the server itself" in (await one.hear(op="status"))["msg"]

    asyncio.run(asyncio.wait_for(run(), 100.0))


def test_messages_in_pieces(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        whole = json.dumps({"op": "call_service", "id": "whole", "service": "/rosapi/get_time", "args": {}})
        for num in (1, 0, 2):
            piece = whole[num * 30 : (num + 1) * 30] if num < 2 else whole[60:]
            await client.say(op="fragment", id="f", data=piece, num=num, total=3)
        assert (await client.hear(id="whole"))["result"]
        await client.say(op="call_service", id="long", service="/rosapi/services", fragment_size=100)
        heard = [await client.hear(op="fragment")]
        heard += [await client.hear(op="fragment") for _ in range(heard[0]["total"] - 1)]
        assert len(heard) > 2
        assert "/compute_ik" in json.loads("".join(each["data"] for each in heard))["values"]["services"]

    talk(tmp_path, test)


def test_a_fragmented_message_is_reassembled(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        told = {"data": "x" * 5000}
        await client.say(op="advertise", topic="/long", type="std_msgs/String")
        await client.say(op="publish", topic="/long", msg=told, latch=True)
        await client.say(op="subscribe", topic="/long", fragment_size=10)
        heard = [await asyncio.wait_for(client.hear(op="fragment"), 10.0)]
        for _ in range(heard[0]["total"] - 1):
            heard.append(await asyncio.wait_for(client.hear(op="fragment"), 10.0))
        assert len(heard) > 500
        assert json.loads("".join(each["data"] for each in heard))["msg"] == told

    talk(tmp_path, test)


def test_the_server_describes_itself(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        assert await client.call("/rosapi/get_ros_version") == {"version": 2, "distro": "jazzy"}
        assert (await client.call("/rosapi/get_time"))["time"]["sec"] > 1.6e9
        topics = await client.call("/rosapi/topics")
        kinds = dict(zip(topics["topics"], topics["types"], strict=True))
        assert kinds["/joint_states"] == "sensor_msgs/msg/JointState"
        assert "/execute_trajectory" in (await client.call("/rosapi/action_servers"))["action_servers"]
        found = await client.call("/rosapi/service_type", {"service": "/compute_ik"})
        assert found == {"type": "moveit_msgs/srv/GetPositionIK"}
        found = await client.call("/rosapi/services_for_type", {"type": "moveit_msgs/srv/GetPositionIK"})
        assert found == {"services": ["/compute_ik"]}
        found = await client.call("/rosapi/topics_for_type", {"type": "sensor_msgs/JointState"})
        assert found == {"topics": ["/joint_states"]}
        asked = {"type": "moveit_msgs/srv/GetPositionIK"}
        (first, *more) = (await client.call("/rosapi/service_request_details", asked))["typedefs"]
        assert first["fieldnames"] == ["ik_request"] and first["fieldarraylen"] == [-1]
        kinds = {each["type"]: each for each in more}
        assert kinds["shape_msgs/SolidPrimitive"]["fieldtypes"][0] == "uint8"
        assert (await client.call("/rosapi/message_details", {"type": "std_msgs/String"}))["typedefs"]
        for service in ("get_param_names", "nodes", "services", "node_details", "service_host"):
            assert await client.call(f"/rosapi/{service}")
        await client.call("/rosapi/set_param", {"name": "speed", "value": "0.5"})
        assert (await client.call("/rosapi/get_param", {"name": "/speed"}))["value"] == "0.5"
        assert (await client.call("/rosapi/has_param", {"name": "/speed"}))["exists"]
        assert (await client.call("/rosapi/search_param", {"name": "speed"}))["global_name"] == "/speed"
        await client.call("/rosapi/delete_param", {"name": "speed"})
        assert not (await client.call("/rosapi/has_param", {"name": "/speed"}))["exists"]

    talk(tmp_path, test)


def test_as_noetic_it_writes_as_ros_1_does(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        assert await client.call("/rosapi/get_ros_version") == {"version": 1, "distro": "noetic"}
        urdf = json.loads((await client.call("/rosapi/get_param", {"name": "/robot_description"}))["value"])
        assert urdf.startswith("<robot")
        scene = (await client.call("/get_planning_scene"))["scene"]
        header = scene["robot_state"]["joint_state"]["header"]
        assert header == {"seq": 0, "stamp": {"secs": 0, "nsecs": 0}, "frame_id": ""}
        asked = {"name": "package://lab_description/meshes/look.stl"}
        assert (await client.call("/file_server/get_file", asked))["value"]
        for name in (
            "package://lab_description/secret.txt",
            "package://lab_description/../outside.stl",
            "/etc/passwd",
        ):
            assert not (await client.ask("/file_server/get_file", {"name": name}))["result"]

    talk(tmp_path, test, distro=Distro.NOETIC)


def test_the_client_selects_the_status_level(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        await client.say(op="set_level", level="none")
        await client.say(op="hop")
        await client.say(op="set_level", level="error")
        await client.say(op="hop", id=7)
        told = await client.hear()
        assert (told["op"], told["id"]) == ("status", 7) and "'hop'" in told["msg"]

    talk(tmp_path, test)


@pytest.mark.parametrize(
    ("origin", "host", "admitted"),
    [
        (None, None, True),
        ("http://localhost:3000", None, False),
        ("http://[::1", None, False),
        (None, "[::1", False),
        (None, "", False),
        ("https://evil.example", None, False),
        ("null", None, False),
        ("https://cell.example", None, True),
        (None, "evil.example:9090", False),
    ],
)
def test_admits_only_named_pages_and_known_hosts(
    tmp_path: Path, origin: str | None, host: str | None, admitted: bool
) -> None:
    async def run() -> None:
        async with bridged(tmp_path, origins=("https://cell.example",)) as bridge:
            more = {} if host is None else {"Host": host}
            reader, writer = await asyncio.open_connection("127.0.0.1", bridge.port)
            headers = {
                "Host": f"127.0.0.1:{bridge.port}",
                "Upgrade": "websocket",
                "Connection": "Upgrade",
                "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
                "Sec-WebSocket-Version": "13",
                **({} if origin is None else {"Origin": origin}),
                **more,
            }
            lines = ["GET / HTTP/1.1", *(f"{key}: {value}" for key, value in headers.items()), "", ""]
            writer.write("\r\n".join(lines).encode())
            status = int((await reader.readline()).split()[1])
            writer.close()
            assert status == (101 if admitted else 403)

    asyncio.run(asyncio.wait_for(run(), 60.0))


def test_a_token_is_part_of_the_address() -> None:
    options = RosbridgeOptions(token="s3cret")
    assert options.knows("/?token=s3cret") and options.knows("/any?a=1&token=s3cret")
    wrong = ("/", "/?token=", "/?token=S3CRET", "//[", "/?token=\u00e9")
    assert not any(map(options.knows, wrong))
    assert RosbridgeOptions().knows("/")


@pytest.mark.parametrize(
    ("request_line", "headers", "status"),
    [
        (b"GET /?token=\xff HTTP/1.1", (b"Host: localhost",), 401),
        (b"GET /?token=s3cret HTTP/1.1", (b"Host: localhost", b"Host: localhost"), 400),
        (b"GET /?token=s3cret HTTP/1.1", (b"Host: localhost", b"Origin: null", b"Origin: null"), 400),
        (b"GET /?token=s3cret HTTP/1.1", (), 403),
    ],
)
def test_refuses_malformed_handshakes(
    tmp_path: Path, request_line: bytes, headers: tuple[bytes, ...], status: int
) -> None:
    async def run() -> None:
        async with bridged(tmp_path, token="s3cret") as bridge:
            reader, writer = await asyncio.open_connection("127.0.0.1", bridge.port)
            writer.write(b"\r\n".join((request_line, *headers, b"", b"")))
            assert int((await reader.readline()).split()[1]) == status
            writer.close()

    asyncio.run(asyncio.wait_for(run(), 60.0))
