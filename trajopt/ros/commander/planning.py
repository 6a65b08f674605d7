"""From a motion plan request to a problem: MoveIt's message, read as its files are."""

from dataclasses import replace
from pathlib import Path

from trajopt.files.messages import document_of
from trajopt.files.moveit.frames import Reading, world_names
from trajopt.files.moveit.motion_plan_request import request_of
from trajopt.files.moveit.planning_scene import SceneFile
from trajopt.problem.problem import Problem
from trajopt.ros.commander.moveit_msgs.msg import MotionPlanRequest
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats


def reading_in(scene: Scene, positions: Floats) -> Reading:
    """Return what names and frames in a message mean while the robot stands at positions."""
    return Reading(world_names(scene.robot), positions)


def problem_of(request: MotionPlanRequest, scene: Scene, positions: Floats) -> Problem:
    """Return the problem that a request asks for.

    Args:
        request: The message.
        scene: What is around the robot.
        positions: Where its joints are now, which counts where the start state leaves one out [rad | m].

    Raises:
        FileFormatError: If the request does not say what it must.
        NameNotFound: If it names a joint, link, frame or object that does not exist.
    """
    robot = scene.robot
    now = dict(zip(robot.joint_names, positions.tolist(), strict=True))
    around = SceneFile(Path(), scene, now, world_names(robot), ())
    return replace(
        request_of(document_of(request, "motion plan request"), around).problem(), name=request.group_name
    )
