"""Actions: the simulated robot is driven, watched and stopped, in the ways of ROS 2 and of ROS 1."""

import asyncio
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.ros.rosbridge.bridged import Client, bridged, talk
from tests.ros.rosbridge.test_moveit_services import BENT, edit, goal, motion, state
from trajopt.files.messages import MoveItErrorCodes as Codes

END = (1.5, 0.5, 0.0)


async def planned(client: Client, *end: float) -> dict[str, Any]:
    """Return a motion from where the robot is, slow enough to be stopped."""
    request = motion(goal(*end), max_velocity_scaling_factor=0.3, max_acceleration_scaling_factor=0.3)
    answer = await client.call("/plan_kinematic_path", request)
    assert answer["motion_plan_response"]["error_code"]["val"] == Codes.SUCCESS
    return answer["motion_plan_response"]["trajectory"]


async def place(client: Client) -> list[float]:
    scene = (await client.call("/get_planning_scene", {"components": {"components": 2}}))["scene"]
    return scene["robot_state"]["joint_state"]["position"]


async def send(client: Client, action: str, name: str, args: dict[str, Any], **more: Any) -> None:
    await client.say(op="send_action_goal", id=name, action=action, args=args, feedback=True, **more)


def test_a_trajectory_is_executed_and_the_robot_is_there(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        trajectory = await planned(client, *END)
        await client.say(op="subscribe", topic="/joint_states")
        kind = "moveit_msgs/action/ExecuteTrajectory"
        await send(client, "/execute_trajectory", "g", {"trajectory": trajectory}, action_type=kind)
        heard: list[dict[str, Any]] = []
        while not heard or heard[-1]["op"] != "action_result":
            heard.append(await client.hear())
        result = heard[-1]
        assert (result["id"], result["status"], result["result"]) == ("g", 4, True)
        assert result["values"]["error_code"]["val"] == Codes.SUCCESS
        assert any(each["op"] == "action_feedback" and each["values"]["state"] for each in heard)
        places = [each["msg"]["position"] for each in heard if each.get("topic") == "/joint_states"]
        between = [at for at in places if np.abs(np.subtract(at, BENT)).max() > 0.05]
        assert between and np.abs(np.subtract(between[0], END)).max() > 0.05
        assert np.allclose(await place(client), END, atol=0.012)
        await send(client, "/execute_trajectory", "again", {"trajectory": trajectory})
        result = await client.hear(op="action_result")
        assert result["status"] == 6 and "stands at" in result["values"]["error_code"]["message"]

    talk(tmp_path, test)


def test_a_controller_reports_its_position_and_stops_on_request(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        trajectory = await planned(client, *END)
        motion = {"trajectory": trajectory["joint_trajectory"]}
        await send(client, "/joint_trajectory_action", "g", motion)
        feedback = (await client.hear(op="action_feedback"))["values"]
        assert feedback["joint_names"] == ["shoulder", "elbow", "wrist"]
        assert np.allclose(feedback["desired"]["positions"], feedback["actual"]["positions"], atol=0.05)
        busy = await client.ask("/rosapi/get_time")
        assert busy["result"]
        await send(client, "/joint_trajectory_action", "h", motion)
        refused = await client.hear(op="action_result", id="h")
        assert not refused["result"] and "driven" in refused["values"]
        await client.say(op="cancel_action_goal", id="g", action="/joint_trajectory_action")
        result = await client.hear(op="action_result", id="g")
        assert result["status"] == 5 and "stopped" in result["values"]["error_string"]
        here = await place(client)
        assert np.abs(np.subtract(here, END)).max() > 0.05

    talk(tmp_path, test)


def test_tolerances_of_a_trajectory_are_kept_or_refused(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        trajectory = (await planned(client, *END))["joint_trajectory"]

        async def followed(name: str, **tolerances: Any) -> dict[str, Any]:
            await send(client, "/follow_joint_trajectory", name, {"trajectory": trajectory, **tolerances})
            return (await client.hear(op="action_result", id=name))["values"]

        here = await place(client)
        for name, tolerances, code in (
            ("a", {"path_tolerance": [{"name": "nose", "position": 0.1}]}, -2),
            ("b", {"path_tolerance": [{"name": "elbow", "acceleration": 0.1}]}, -1),
            ("c", {"component_path_tolerance": [{"joint_name": "elbow"}]}, -1),
        ):
            assert (await followed(name, **tolerances))["error_code"] == code
            assert await place(client) == here
        tight = [{"name": "elbow", "velocity": 1e-12}]
        result = await followed("d", path_tolerance=tight)
        assert result["error_code"] == -4 and "elbow: its velocity" in result["error_string"]
        assert not np.allclose(await place(client), END, atol=1e-2)
        trajectory = (await planned(client, *END))["joint_trajectory"]
        wide = [{"name": "elbow", "position": 0.5}]
        assert (await followed("e", path_tolerance=wide, goal_tolerance=wide))["error_code"] == 0

    talk(tmp_path, test)


def test_move_group_plans_and_moves(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        request = motion(goal(*END))["motion_plan_request"]
        options = {
            "plan_only": True,
            "planning_scene_diff": {"is_diff": True, "robot_state": {"is_diff": True}},
        }
        await send(client, "/move_action", "plan", {"request": request, "planning_options": options})
        result = await client.hear(op="action_result")
        assert result["status"] == 4, result["values"]
        assert result["values"]["planned_trajectory"]["joint_trajectory"]["points"]
        assert await place(client) == pytest.approx(BENT)
        blocked = {
            "is_diff": True,
            "world": {
                "collision_objects": [
                    {
                        "id": "x",
                        "primitives": [{"type": 2, "dimensions": [0.1]}],
                        "pose": {"position": {"x": 0.5}},
                    }
                ]
            },
            "robot_state": {**state(0.0, 0.0, 0.0), "is_diff": True},
        }
        await send(
            client,
            "/move_action",
            "no",
            {"request": request, "planning_options": {"planning_scene_diff": blocked}},
        )
        result = await client.hear(op="action_result")
        assert result["status"] == 6
        assert result["values"]["error_code"]["val"] == Codes.START_STATE_IN_COLLISION
        scene = (await client.call("/get_planning_scene"))["scene"]
        assert scene["world"]["collision_objects"] == []
        await send(client, "/move_group", "go", {"request": request})
        states = [(await client.hear(op="action_feedback"))["values"]["state"] for _ in range(2)]
        assert states == ["PLANNING", "MONITOR"]
        result = await client.hear(op="action_result")
        assert result["status"] == 4
        assert np.allclose(await place(client), END, atol=0.012)

    talk(tmp_path, test)


def test_refuses_an_invalid_goal(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        for action, args, kind, said in (
            ("/fly", {}, "", "no action /fly"),
            ("/execute_trajectory", {}, "my_msgs/Fly", "of the type moveit_msgs/ExecuteTrajectory"),
            ("/execute_trajectory", {"trajectoy": {}}, "", "has no field 'trajectoy'"),
            ("/move_action", {"requst": {}}, "", "requst"),
            ("/move_action", {"request": {"group": 1}}, "", "has no field 'group'"),
        ):
            await send(client, action, "g", args, action_type=kind)
            result = await client.hear(op="action_result")
            assert not result["result"] and said in result["values"], result
        await send(client, "/execute_trajectory", "g", {})
        result = await client.hear(op="action_result")
        assert result["status"] == 6 and result["values"]["error_code"]["val"] == Codes.INVALID_MOTION_PLAN
        await client.say(op="cancel_action_goal", id="g", action="/execute_trajectory")
        assert "no goal 'g'" in (await client.hear(op="status"))["msg"]

    talk(tmp_path, test)


def test_in_ros_1_an_action_is_five_topics(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        assert await edit(client, robot_state={**state(*BENT), "is_diff": True})
        trajectory = await planned(client, *END)
        for each in ("status", "feedback", "result"):
            await client.say(op="subscribe", topic=f"/execute_trajectory/{each}")
        assert (await client.hear(topic="/execute_trajectory/status"))["msg"]["status_list"] == []
        whole = {"goal_id": {"id": "g", "stamp": {"secs": 0, "nsecs": 0}}, "goal": {"trajectory": trajectory}}
        await client.say(op="publish", topic="/execute_trajectory/goal", msg=whole)
        told = (await client.hear(topic="/execute_trajectory/feedback"))["msg"]
        assert told["status"]["goal_id"]["id"] == "g" and told["feedback"]["state"] == "MONITOR"
        assert told["header"]["stamp"]["secs"] > 0
        status = (await client.hear(topic="/execute_trajectory/status"))["msg"]
        assert status["status_list"][0]["status"] == 1
        await client.say(op="publish", topic="/execute_trajectory/cancel", msg={"id": "g"})
        result = (await client.hear(topic="/execute_trajectory/result"))["msg"]
        assert result["status"]["status"] == 2
        assert result["result"]["error_code"]["val"] == Codes.PREEMPTED
        assert await edit(client, robot_state={**state(*BENT), "is_diff": True})
        whole["goal_id"]["id"] = "h"
        await client.say(op="publish", topic="/execute_trajectory/goal", msg=whole)
        result = (await client.hear(topic="/execute_trajectory/result"))["msg"]
        assert result["status"]["status"] == 3
        await client.say(op="publish", topic="/execute_trajectory/goal", msg={"goal_id": {"id": 3}})
        assert "must be text" in (await client.hear(op="status"))["msg"]

    talk(tmp_path, test)


def test_an_action_of_one_client_is_done_for_another(tmp_path: Path) -> None:
    async def run() -> None:
        async with bridged(tmp_path) as bridge, bridge.client() as one:
            async with bridge.client() as other:
                await other.say(
                    op="advertise_action", action="/grip", type="control_msgs/action/GripperCommand"
                )
                await other.call("/rosapi/get_time")
                assert "/grip" in (await one.call("/rosapi/action_servers"))["action_servers"]
                kind = "control_msgs/action/GripperCommand"
                await send(one, "/grip", "g", {"position": 0.04}, action_type=kind)
                goal = await other.hear(op="send_action_goal")
                assert (goal["args"], goal["action_type"]) == ({"position": 0.04}, kind)
                mine = {"id": goal["id"], "action": "/grip"}
                await other.say(op="action_feedback", values={"stalled": False}, **mine)
                assert (await one.hear(op="action_feedback", id="g"))["values"] == {"stalled": False}
                await one.say(op="cancel_action_goal", id="g", action="/grip")
                assert (await other.hear(op="cancel_action_goal"))["id"] == goal["id"]
                await other.say(op="action_result", values={"stalled": True}, status=5, result=True, **mine)
                result = await one.hear(op="action_result", id="g")
                assert (result["values"], result["status"], result["result"]) == ({"stalled": True}, 5, True)
                await other.say(op="action_result", values={}, status=4, **mine)
                assert "no goal" in (await other.hear(op="status"))["msg"]
                await send(one, "/grip", "g", {}, action_type="control_msgs/Fly")
                assert (
                    "of the type control_msgs/GripperCommand"
                    in (await one.hear(op="action_result"))["values"]
                )
                async with bridge.client() as third:
                    await send(third, "/grip", "h", {})
                    left = await other.hear(op="send_action_goal")
                    await third.say(op="advertise_action", action="/grip", type=kind)
                    assert "another client offers" in (await third.hear(op="status"))["msg"]
                assert (await other.hear(op="cancel_action_goal"))["id"] == left["id"]
                await send(one, "/grip", "g", {})
                await other.hear(op="send_action_goal")
                await other.say(op="unadvertise_action", action="/grip")
                await other.call("/rosapi/get_time")
                await send(one, "/grip", "h", {})
                assert "no action /grip" in (await one.hear(op="action_result", id="h"))["values"]
            result = await one.hear(op="action_result", id="g")
            assert result["status"] == 6 and "has left" in result["values"]

    asyncio.run(asyncio.wait_for(run(), 100.0))
