"""What people write with compas_fab, against a bridge: `python -m ...compas_script PORT MESH_PORT [all]`.

It prints what it got as JSON, for a test to look at; compas_fab's reactor runs once in a process.
"""

import json
import sys
import threading
import time
from typing import Any

from compas.geometry import Box, Frame
from compas_fab.backends import (
    CollisionCheckError,
    InverseKinematicsError,
    MotionPlanningError,
    MoveItPlanner,
    RosClient,
)
from compas_fab.robots import ConfigurationTarget, FrameTarget, FrameWaypoints, RigidBody, TargetMode

START = [0.5, 1.0, 0.2]


def basics(client: Any, mesh_port: int) -> dict[str, Any]:
    """Load the robot, place its hand, and plan."""
    base = f"http://127.0.0.1:{mesh_port}"
    cell = client.load_robot_cell(load_geometry=True, http_file_server_base_url=base)
    planner, state = MoveItPlanner(client), cell.default_cell_state()
    state.robot_configuration.joint_values = START
    frame = planner.forward_kinematics(state, TargetMode.ROBOT)
    end = cell.zero_full_configuration()
    end.joint_values = [1.0, 0.5, 0.0]
    planned = planner.plan_motion(ConfigurationTarget(end, [0.01] * 3, [0.01] * 3), state)
    return {
        "distro": client.ros_distro.value,
        "name": cell.robot_model.name,
        "group": cell.main_group_name,
        "hand": list(frame.point),
        "end": planned.points[-1].joint_values,
        "duration": planned.time_from_start,
    }


def more(client: Any) -> dict[str, Any]:
    """Use every other feature of the planner."""
    cell, planner = client.robot_cell, MoveItPlanner(client)
    state = cell.default_cell_state()
    state.robot_configuration.joint_values = START
    here = planner.forward_kinematics(state, TargetMode.ROBOT)
    options = {"max_results": 1}
    found = planner.inverse_kinematics(FrameTarget(here, TargetMode.ROBOT), state, options=options)
    away = Frame([here.point.x + 0.1, here.point.y, here.point.z], here.xaxis, here.yaxis)
    line = planner.plan_cartesian_motion(FrameWaypoints([away], TargetMode.ROBOT), state)
    cell.rigid_body_models["box"] = RigidBody.from_mesh(Box(0.1, 0.1, 0.4).to_mesh(triangulated=True))
    blocked = cell.default_cell_state()
    blocked.robot_configuration.joint_values = START
    blocked.rigid_body_states["box"].frame = Frame(
        [here.point.x + 0.13, here.point.y, 0.1], [1, 0, 0], [0, 1, 0]
    )
    planner.set_robot_cell(cell, blocked)
    planner.check_collision(blocked)
    told: dict[str, Any] = {"ik": found.joint_values, "fraction": line.fraction}
    try:
        planner.plan_cartesian_motion(FrameWaypoints([away], TargetMode.ROBOT), blocked)
    except MotionPlanningError as error:
        told["partly"] = error.partial_trajectory.fraction
    in_box = blocked.copy()
    in_box.rigid_body_states["box"].frame = Frame([here.point.x, here.point.y, 0.1], [1, 0, 0], [0, 1, 0])
    try:
        planner.check_collision(in_box)
    except CollisionCheckError as error:
        told["pairs"] = [sorted(pair) for pair in error.collision_pairs]
    try:
        target = FrameTarget(here, TargetMode.ROBOT)
        planner.inverse_kinematics(target, in_box, options=options)
    except InverseKinematicsError as error:
        told["blocked"] = str(error)
    del cell.rigid_body_models["box"]
    planner.set_robot_cell(cell, cell.default_cell_state())
    told["left"] = [each.id for each in planner.get_planning_scene().world.collision_objects]
    return told


def executed(client: Any) -> dict[str, Any]:
    """Drive along a motion, and hear how it goes."""
    cell, planner = client.robot_cell, MoveItPlanner(client)
    state = cell.default_cell_state()
    state.robot_configuration.joint_values = START
    end = cell.zero_full_configuration()
    end.joint_values = [1.0, 0.5, 0.0]
    motion = planner.plan_motion(ConfigurationTarget(end, [0.001] * 3, [0.001] * 3), state)
    heard: list[str] = []
    ended, result = threading.Event(), dict[str, Any]()

    def over(kind: str) -> Any:
        def take(value: Any) -> None:
            result[kind] = str(value)
            ended.set()

        return take

    # In its own messages: those of its trajectories have names for positions that its client does not know.
    client.execute_joint_trajectory(
        motion.source_message.trajectory.joint_trajectory,
        callback=over("done"),
        errback=over("failed"),
        feedback_callback=lambda feedback: heard.append(str(feedback.state)),
    )
    # compas_fab 2.0.1 does not deliver the result in ROS 2's way: it looks for it one level too high.
    until = time.monotonic() + 60.0
    where = START
    while time.monotonic() < until and abs(where[0] - 1.0) > 0.005:
        ended.wait(0.5)
        where = planner.get_planning_scene().robot_state.joint_state.position
    if not client.ros_distro.is_ros2:
        ended.wait(20.0)
    return {"heard": sorted(set(heard)), "result": result, "where": list(where)}


def main() -> None:
    """Do it, and print what came of it."""
    port, mesh_port = int(sys.argv[1]), int(sys.argv[2])
    told: dict[str, Any] = {}
    with RosClient(host="127.0.0.1", port=port) as client:
        told["basics"] = basics(client, mesh_port)
        if "all" in sys.argv:
            told["more"] = more(client)
            told["executed"] = executed(client)
    print(json.dumps(told))


if __name__ == "__main__":
    main()
