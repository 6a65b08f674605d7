"""The operations of every server."""

from collections.abc import Mapping

from trajopt.server.operation import Lane, Operation
from trajopt.server.operations.driving import execute
from trajopt.server.operations.planning import (
    check,
    explain,
    follow_curve,
    forward_kinematics,
    inverse_kinematics,
    plan,
    plan_task,
    validity,
)
from trajopt.server.operations.scenes import cloud, edit, planning_scene, read, set_motions
from trajopt.server.operations.worlds import call, drive, hold, robot, scene

OPERATIONS: Mapping[str, Operation] = {
    "plan": Operation(plan),
    "explain": Operation(explain),
    "task": Operation(plan_task),
    "follow": Operation(follow_curve),
    "check": Operation(check, Lane.QUICK),
    "forward_kinematics": Operation(forward_kinematics, Lane.QUICK),
    "inverse_kinematics": Operation(inverse_kinematics, Lane.QUICK),
    "validity": Operation(validity, Lane.QUICK),
    "read": Operation(read, Lane.QUICK),
    "edit": Operation(edit, Lane.QUICK, edits=True),
    "cloud": Operation(cloud, Lane.QUICK, edits=True, attached=True),
    "motions": Operation(set_motions, Lane.QUICK, edits=True),
    "planning_scene": Operation(planning_scene, Lane.QUICK, edits=True),
    "execute": Operation(execute, Lane.DRIVING),
    "robot": Operation(robot, Lane.QUICK),
    "scene": Operation(scene, Lane.QUICK),
    "hold": Operation(hold, Lane.QUICK, edits=True),
    "call": Operation(call),
    "drive": Operation(drive, Lane.DRIVING),
}
