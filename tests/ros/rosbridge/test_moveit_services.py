"""MoveIt's services over rosbridge: each answer, and each error code."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.ros.rosbridge.bridged import Client, talk
from trajopt.files.messages import MoveItErrorCodes as Codes

JOINTS = ["shoulder", "elbow", "wrist"]
STRAIGHT = {"joint_state": {"name": JOINTS, "position": [0.0, 0.0, 0.0]}}
BENT = [0.5, -1.0, 0.2]


def state(*positions: float, **more: Any) -> dict[str, Any]:
    return {"joint_state": {"name": JOINTS, "position": list(positions)}, **more}


def goal(*positions: float) -> dict[str, Any]:
    return {
        "joint_constraints": [
            {
                "joint_name": name,
                "position": at,
                "tolerance_above": 0.01,
                "tolerance_below": 0.01,
                "weight": 1,
            }
            for name, at in zip(JOINTS, positions, strict=True)
        ]
    }


def motion(*goals: dict[str, Any], **more: Any) -> dict[str, Any]:
    request = {"group_name": "arm", "goal_constraints": list(goals), "allowed_planning_time": 5.0, **more}
    return {"motion_plan_request": request}


def box(x: float, y: float, **more: Any) -> dict[str, Any]:
    primitive = {"type": 1, "dimensions": [0.1, 0.1, 0.4]}
    pose = {"position": {"x": x, "y": y, "z": 0.1}, "orientation": {"w": 1.0}}
    return {"id": "box", "header": {"frame_id": "base"}, "primitives": [primitive], "pose": pose, **more}


async def edit(client: Client, **scene: Any) -> bool:
    scene = {"is_diff": True, "robot_state": {"is_diff": True}, **scene}
    return (await client.call("/apply_planning_scene", {"scene": scene}))["success"]


def test_forward_kinematics(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        args = {"header": {"frame_id": "base"}, "fk_link_names": ["hand", "fore"], "robot_state": STRAIGHT}
        answer = await client.call("/compute_fk", args)
        assert answer["error_code"]["val"] == Codes.SUCCESS
        assert answer["pose_stamped"][0]["pose"]["position"]["x"] == pytest.approx(1.0)
        assert answer["pose_stamped"][0]["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "base"}
        in_fore = {**args, "header": {"frame_id": "/fore"}, "fk_link_names": ["hand"]}
        answer = await client.call("compute_fk", in_fore)
        assert answer["pose_stamped"][0]["pose"]["position"]["x"] == pytest.approx(0.5)
        for change, code in (
            ({"fk_link_names": ["nose"]}, Codes.INVALID_LINK_NAME),
            ({"fk_link_names": []}, Codes.INVALID_LINK_NAME),
            ({"header": {"frame_id": "moon"}}, Codes.FRAME_TRANSFORM_FAILURE),
            ({"robot_state": {"joint_state": {"name": ["wrist"]}}}, Codes.INVALID_ROBOT_STATE),
        ):
            assert (await client.call("/compute_fk", {**args, **change}))["error_code"]["val"] == code

    talk(tmp_path, test)


def test_inverse_kinematics(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        place = await client.call(
            "/compute_fk", {"fk_link_names": ["hand"], "robot_state": state(0.3, 0.6, -0.2)}
        )
        request = {
            "group_name": "arm",
            "robot_state": state(0.2, 0.5, 0.0),
            "pose_stamped": {"header": {"frame_id": "/world"}, "pose": place["pose_stamped"][0]["pose"]},
            "avoid_collisions": True,
            "timeout": {"secs": 2, "nsecs": 0},
            "attempts": 8,
        }
        answer = await client.call("/compute_ik", {"ik_request": request})
        assert answer["error_code"]["val"] == Codes.SUCCESS
        found = answer["solution"]["joint_state"]
        assert found["name"] == JOINTS
        assert np.allclose(found["position"], (0.3, 0.6, -0.2), atol=1e-4)
        far = {"header": {}, "pose": {"position": {"x": 9.0}}}
        for change, code in (
            ({"pose_stamped": far}, Codes.NO_IK_SOLUTION),
            ({"group_name": "leg"}, Codes.INVALID_GROUP_NAME),
            ({"ik_link_name": "nose"}, Codes.INVALID_LINK_NAME),
        ):
            answer = await client.call("/compute_ik", {"ik_request": {**request, **change}})
            assert answer["error_code"]["val"] == code, answer["error_code"]
        where = place["pose_stamped"][0]["pose"]["position"]
        assert await edit(client, world={"collision_objects": [box(where["x"], where["y"])]})
        answer = await client.call("/compute_ik", {"ik_request": request})
        assert answer["error_code"]["val"] == Codes.NO_IK_SOLUTION
        answer = await client.call("/compute_ik", {"ik_request": {**request, "avoid_collisions": False}})
        assert answer["error_code"]["val"] == Codes.SUCCESS

    talk(tmp_path, test)


def test_motions(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        start = {"start_state": state(*BENT, is_diff=True)}
        answer = await client.call("/plan_kinematic_path", motion(goal(1.5, 0.5, 0.0), **start))
        plan = answer["motion_plan_response"]
        assert plan["error_code"]["val"] == Codes.SUCCESS and plan["group_name"] == "arm"
        points = plan["trajectory"]["joint_trajectory"]["points"]
        assert np.allclose(points[0]["positions"], BENT)
        assert np.allclose(points[-1]["positions"], (1.5, 0.5, 0.0), atol=0.011)
        assert points[-1]["time_from_start"]["sec"] + points[-1]["time_from_start"]["nanosec"] > 0
        assert plan["trajectory_start"]["joint_state"]["position"] == pytest.approx(BENT)
        many = motion(goal(1.5, 0.5, 0.0), planner_id="RRTConnect", num_planning_attempts=3, **start)
        plan = (await client.call("/plan_kinematic_path", many))["motion_plan_response"]
        assert plan["error_code"]["val"] == Codes.SUCCESS
        for request, code in (
            (motion(goal(1.5, 0.5, 0.0), group_name="leg"), Codes.INVALID_GROUP_NAME),
            (motion(), Codes.INVALID_GOAL_CONSTRAINTS),
            (motion({}), Codes.INVALID_GOAL_CONSTRAINTS),
            (motion({"joint_constraints": [{"joint_name": "nose"}]}), Codes.INVALID_GOAL_CONSTRAINTS),
            (motion(goal(9.0, 0.5, 0.0)), Codes.GOAL_STATE_INVALID),
            (motion(goal(1.5, 0.5, 0.0), start_state=state(9.0, 0.0, 0.0)), Codes.START_STATE_INVALID),
        ):
            plan = (await client.call("/plan_kinematic_path", request))["motion_plan_response"]
            assert plan["error_code"]["val"] == code, plan["error_code"]
            assert plan["error_code"]["message"] and not plan["trajectory"]["joint_trajectory"]["points"]

    talk(tmp_path, test)


def test_straight_lines(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        bent = state(0.5, 1.0, 0.2, is_diff=True)
        place = await client.call("/compute_fk", {"fk_link_names": ["hand"], "robot_state": bent})
        pose = place["pose_stamped"][0]["pose"]
        pose["position"]["x"] += 0.1
        request = {
            "header": {"frame_id": "base", "seq": 1},
            "start_state": bent,
            "group_name": "arm",
            "link_name": "hand",
            "waypoints": [pose],
            "max_step": 0.01,
            "jump_threshold": 1.57,
            "avoid_collisions": True,
        }
        answer = await client.call("/compute_cartesian_path", request)
        assert answer["fraction"] == pytest.approx(1.0)
        assert len(answer["solution"]["joint_trajectory"]["points"]) >= 2
        late = await client.call("/compute_cartesian_path", request, timeout=0.3)
        assert late["fraction"] == 0.0 and "OUT_OF_TIME" in late["error_code"]["message"]
        where = pose["position"]
        assert await edit(client, world={"collision_objects": [box(where["x"] + 0.03, where["y"])]})
        answer = await client.call("/compute_cartesian_path", request)
        assert 0.0 < answer["fraction"] < 1.0 and answer["error_code"]["val"] == Codes.SUCCESS
        answer = await client.call("/compute_cartesian_path", {**request, "avoid_collisions": False})
        assert answer["fraction"] == pytest.approx(1.0)

    talk(tmp_path, test)


def test_straight_lines_end_where_path_constraints_fail(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        bent = state(0.5, 1.0, 0.2, is_diff=True)
        place = await client.call("/compute_fk", {"fk_link_names": ["hand"], "robot_state": bent})
        pose = place["pose_stamped"][0]["pose"]
        pose["position"]["x"] += 0.1
        request = {"start_state": bent, "group_name": "arm", "waypoints": [pose], "avoid_collisions": True}
        free = await client.call("/compute_cartesian_path", request)
        elbow = [point["positions"][1] for point in free["solution"]["joint_trajectory"]["points"]]
        most = 0.5 * abs(elbow[-1] - elbow[0])

        async def within(off: float, **more: Any) -> Any:
            near = {
                "joint_name": "elbow", "position": 1.0, "tolerance_above": off, "tolerance_below": off,
                "weight": 1, **more,
            }  # fmt: skip
            constraints = {"joint_constraints": [near]}
            return await client.call("/compute_cartesian_path", {**request, "path_constraints": constraints})

        answer = await within(most)
        assert 0.2 < answer["fraction"] < 0.8 and answer["error_code"]["val"] == Codes.SUCCESS
        assert "path constraints" in answer["error_code"]["message"]
        for point in answer["solution"]["joint_trajectory"]["points"]:
            assert abs(point["positions"][1] - 1.0) <= most + 1e-4
        assert (await within(1.0))["fraction"] == pytest.approx(1.0)
        answer = await within(1e-4, position=0.5)
        assert answer["fraction"] == 0.0 and answer["solution"]["joint_trajectory"]["points"] == []
        assert answer["error_code"]["val"] == Codes.SUCCESS
        answer = await within(1.0, joint_name="knee")
        assert answer["error_code"]["val"] == Codes.INVALID_GOAL_CONSTRAINTS

    talk(tmp_path, test)


def test_objects_attached_by_a_request_count_for_that_request(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        pole = {
            "id": "pole", "header": {"frame_id": "hand"},
            "primitives": [{"type": 1, "dimensions": [0.6, 0.02, 0.02]}],
            "pose": {"position": {"x": 0.4}, "orientation": {"w": 1.0}},
        }  # fmt: skip
        carried = {"link_name": "hand", "object": pole, "touch_links": ["hand"]}
        loaded = {**state(0.0, 0.0, 0.0, is_diff=True), "attached_collision_objects": [carried]}
        assert await edit(client, world={"collision_objects": [box(1.5, 0.0)]})

        async def valid(robot_state: Any) -> Any:
            return await client.call(
                "/check_state_validity", {"group_name": "arm", "robot_state": robot_state}
            )

        assert (await valid(STRAIGHT))["valid"]
        answer = await valid(loaded)
        assert not answer["valid"]
        assert any("pole" in (each["contact_body_1"], each["contact_body_2"]) for each in answer["contacts"])
        asked = {"fk_link_names": ["pole"], "robot_state": loaded}
        answer = await client.call("/compute_fk", asked)
        assert answer["pose_stamped"][0]["pose"]["position"]["x"] == pytest.approx(1.4)
        answer = await client.call("/compute_fk", {**asked, "robot_state": STRAIGHT})
        assert answer["error_code"]["val"] == Codes.INVALID_LINK_NAME
        here = await client.call("/compute_fk", {"fk_link_names": ["hand"], "robot_state": STRAIGHT})
        where = {"header": {}, "pose": here["pose_stamped"][0]["pose"]}
        reach = {"group_name": "arm", "pose_stamped": where, "avoid_collisions": True}
        for robot_state, code in ((STRAIGHT, Codes.SUCCESS), (loaded, Codes.NO_IK_SOLUTION)):
            answer = await client.call("/compute_ik", {"ik_request": {**reach, "robot_state": robot_state}})
            assert answer["error_code"]["val"] == code
        line = {"group_name": "arm", "waypoints": [where["pose"]], "avoid_collisions": True}
        bent = {**loaded, **state(0.0, 0.6, 0.6)}
        answer = await client.call("/compute_cartesian_path", {**line, "start_state": bent})
        carried_now = answer["start_state"]["attached_collision_objects"]
        assert [each["object"]["id"] for each in carried_now] == ["pole"]
        assert answer["fraction"] < 1.0

    talk(tmp_path, test)


def test_reports_the_ignored_parts_of_a_request(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        odd = {"joint_state": {"name": ["wheel"], "position": [1.0]}, "is_diff": True}
        more = {"max_cartesian_speed": 0.1, "planner_id": "RRTConnect", "start_state": odd}
        answer = await client.call("/plan_kinematic_path", motion(goal(0.1, 0.2, 0.0), **more))
        said = answer["motion_plan_response"]["error_code"]["message"]
        assert "wheel" in said and "max_cartesian_speed" in said and "RRTConnect" in said
        answer = await client.call("/compute_fk", {"fk_link_names": ["hand"], "robot_state": odd})
        assert "wheel" in answer["error_code"]["message"]

    talk(tmp_path, test)


def test_validity(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        request = {"robot_state": STRAIGHT, "group_name": "arm"}
        answer = await client.call("/check_state_validity", request)
        assert answer["valid"] and answer["contacts"] == []
        assert await edit(client, world={"collision_objects": [box(0.75, 0.0)]})
        for group in ("arm", ""):
            answer = await client.call("/check_state_validity", {**request, "group_name": group})
            assert not answer["valid"]
            pairs = {(each["contact_body_1"], each["contact_body_2"]) for each in answer["contacts"]}
            assert {frozenset(pair) for pair in pairs} == {frozenset(("fore", "box"))}
            assert {answer["contacts"][0]["body_type_1"], answer["contacts"][0]["body_type_2"]} == {0, 1}
        held = {**request, "robot_state": state(0.0, 1.5, 0.0), "constraints": goal(0.0, 1.5, 0.0)}
        answer = await client.call("/check_state_validity", held)
        assert answer["valid"] and all(each["result"] for each in answer["constraint_result"])
        broken = {**held, "constraints": goal(1.0, 1.5, 0.0)}
        answer = await client.call("/check_state_validity", broken)
        assert not answer["valid"] and not all(each["result"] for each in answer["constraint_result"])
        refused = await client.ask("/check_state_validity", {**request, "group_name": "leg"})
        assert not refused["result"] and "leg" in refused["values"]

    talk(tmp_path, test)


def test_the_scene(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        assert await edit(client, world={"collision_objects": [box(0.75, 0.4)]})
        whole = (await client.call("/get_planning_scene"))["scene"]
        assert [each["id"] for each in whole["world"]["collision_objects"]] == ["box"]
        assert whole["world"]["collision_objects"][0]["type"] == {"key": "", "db": ""}
        carried = {"link_name": "hand", "object": {"id": "box"}, "touch_links": ["hand"], "weight": 1.0}
        robot_state = state(0.1, 0.2, 0.3, is_diff=True, attached_collision_objects=[carried])
        assert await edit(client, robot_state=robot_state)
        scene = (await client.call("/get_planning_scene", {"components": {"components": 671}}))["scene"]
        assert scene["robot_state"]["joint_state"]["position"] == pytest.approx([0.1, 0.2, 0.3])
        assert [each["object"]["id"] for each in scene["robot_state"]["attached_collision_objects"]] == [
            "box"
        ]
        assert scene["world"]["collision_objects"] == []
        for each in scene["robot_state"]["attached_collision_objects"]:
            each["object"]["operation"] = 1
        assert await edit(
            client, **{**scene, "is_diff": True, "robot_state": {**scene["robot_state"], "is_diff": True}}
        )
        scene = (await client.call("/get_planning_scene"))["scene"]
        assert [each["id"] for each in scene["world"]["collision_objects"]] == ["box"]
        refused = await client.ask("/apply_planning_scene", {"scene": {"robot_stat": {}}})
        assert not refused["result"] and "robot_stat" in refused["values"]
        moved = {"is_diff": True, "world": {"collision_objects": [{"id": "ball", "operation": 3}]}}
        refused = await client.ask("/apply_planning_scene", {"scene": moved})
        assert not refused["result"] and "ball" in refused["values"]

    talk(tmp_path, test)


def test_planners(tmp_path: Path) -> None:
    async def test(client: Client) -> None:
        found = (await client.call("/query_planner_interface"))["planner_interfaces"]
        assert found[0]["name"] == "trajopt" and found[0]["planner_ids"]

    talk(tmp_path, test)
