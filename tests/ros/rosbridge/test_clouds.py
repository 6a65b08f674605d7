"""Clouds that a camera publishes on a topic: obstacles, in place of what it saw before."""

from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.ros.rosbridge.bridged import Client, talk
from trajopt.files.messages import PointCloud2, decode
from trajopt.ros.rosbridge import RosbridgeOptions
from trajopt.ros.rosbridge.answers.states import points_of
from trajopt.values.errors import FileFormatError, ProblemError

TOPIC = "/camera/points"
STATE = {"joint_state": {"name": ["shoulder", "elbow", "wrist"], "position": [0.0, 0.0, 0.0]}}


def cloud(points: Any, frame: str = "world", stamp: int = 0, **more: Any) -> dict[str, Any]:
    """Return a message as a depth camera's driver writes it: 16 bytes a point, one row."""
    rows = np.zeros((len(points), 4), dtype="<f4")
    rows[:, :3] = points
    fields = [
        {"name": name, "offset": 4 * place, "datatype": 7, "count": 1} for place, name in enumerate("xyz")
    ]
    return {
        "header": {"frame_id": frame, "stamp": {"sec": stamp, "nanosec": 0}},
        "height": 1, "width": len(points), "fields": fields, "is_bigendian": False, "point_step": 16,
        "row_step": 16 * len(points), "data": b64encode(rows.tobytes()).decode(), "is_dense": False, **more,
    }  # fmt: skip


def wall(x: float) -> Any:
    y, z = np.meshgrid(np.linspace(-0.2, 0.2, 41), np.linspace(0.0, 0.2, 21))
    return np.stack([np.full(y.shape, x), y, z], axis=-1).reshape(-1, 3)


def test_a_cloud_on_a_topic_is_an_obstacle_until_the_next(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        await client.say(op="advertise", topic=TOPIC, type="sensor_msgs/msg/PointCloud2")

        async def published(message: dict[str, Any]) -> None:
            await client.say(op="publish", topic=TOPIC, msg=message)

        async def valid() -> bool:
            asked = {"group_name": "arm", "robot_state": STATE}
            return (await client.call("/check_state_validity", asked))["valid"]

        async def told(why: str) -> None:
            assert why in (await client.hear(op="status", level="error"))["msg"]

        assert await valid()
        await published(cloud(wall(1.15), stamp=5))
        scene = (await client.call("/get_planning_scene"))["scene"]
        assert "cloud world" in [each["id"] for each in scene["world"]["collision_objects"]]
        await published(cloud([*wall(1.05), [np.nan] * 3], stamp=6))
        assert not await valid()
        await published(cloud(wall(3.0), stamp=4))
        assert not await valid()
        await published(cloud(wall(3.0), stamp=7))
        assert await valid()
        await published(cloud([[0.0, 0.0, 0.0]], frame="hand"))
        assert await valid()
        await published(cloud([[0.0, 0.0, 0.0]], frame="nowhere"))
        await told("nowhere")
        await published(cloud([[0.0, 0.0, 0.0]], row_step=15))
        await told("rows of 15 bytes")

    talk(tmp_path, test, clouds=(TOPIC,))


def test_clouds_are_not_obstacles_by_default(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        await client.say(op="advertise", topic=TOPIC, type="sensor_msgs/PointCloud2")
        await client.say(op="publish", topic=TOPIC, msg=cloud(wall(1.05)))
        assert (await client.call("/check_state_validity", {"robot_state": STATE}))["valid"]

    talk(tmp_path, test)


def test_rows_numbers_and_bytes_in_any_order() -> None:
    points = np.arange(12.0).reshape(4, 3)
    rows = np.zeros((2, 60), dtype=np.uint8)
    layout = np.dtype({"names": list("xyz"), "formats": [">f8"] * 3, "offsets": [2, 10, 18], "itemsize": 28})
    records = np.zeros(4, dtype=layout)
    for place, name in enumerate("xyz"):
        records[name] = points[:, place]
    rows[:, :56] = np.frombuffer(records.tobytes(), np.uint8).reshape(2, 56)
    fields = [
        {"name": name, "offset": 2 + 8 * place, "datatype": 8, "count": 1} for place, name in enumerate("xyz")
    ]
    stated = {
        "height": 2, "width": 2, "fields": fields, "is_bigendian": True, "point_step": 28, "row_step": 60,
        "data": rows.reshape(-1).tolist(),
    }  # fmt: skip
    np.testing.assert_array_equal(points_of(decode(PointCloud2, stated)), points)
    assert points_of(decode(PointCloud2, {**stated, "height": 0, "data": None})).shape == (0, 3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"data": 10**9}, "data: must be base64"),
        ({"data": "no base64!"}, "data: must be base64"),
        ({"data": [256]}, "data: must be base64"),
        ({"data": [0] * 17}, "17 bytes"),
        ({"height": 2}, "2 rows"),
        ({"height": -1}, "height"),
        ({"width": 2**31}, "points of 16"),
        ({"point_step": 0}, "does not lie in a point"),
        ({"fields": []}, "fields must have x, y and z"),
        (
            {"fields": [{"name": n, "offset": 0, "datatype": 1, "count": 1} for n in "xyz"]},
            "must be one FLOAT32",
        ),
        (
            {"fields": [{"name": n, "offset": 0, "datatype": 7, "count": 9} for n in "xyz"]},
            "must be one FLOAT32",
        ),
        ({"fields": [{"name": n, "offset": 13, "datatype": 7, "count": 1} for n in "xyz"]}, "does not lie"),
        ({"eval": "1"}, "no field"),
    ],
)
def test_refuses_a_message_that_is_not_a_cloud(change: dict[str, Any], said: str) -> None:
    with pytest.raises(FileFormatError, match=said):
        points_of(decode(PointCloud2, {**cloud([[1.0, 2.0, 3.0]]), **change}))


def test_a_topic_begins_with_a_slash() -> None:
    with pytest.raises(ProblemError, match="begins with /"):
        RosbridgeOptions(clouds=("camera",))
