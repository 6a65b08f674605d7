"""The example of a ROS 2 node, with stand-ins of the modules of ROS 2."""

import runpy
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from trajopt.ros.commander.geometry_msgs.msg import PoseStamped
from trajopt.ros.commander.sensor_msgs.msg import JointState

import trajopt as to
from tests.ros.commander.conftest import URDF
from tests.ros.ros2_stand_in import ActionClient, Node, modules
from trajopt.files.moveit.frames import pose_of

NODE = Path(__file__).parents[2] / "examples" / "ros2" / "planning_node.py"
HERE = {"shoulder": 0.5, "elbow": -1.0, "wrist": 0.2}
THERE = {"shoulder": 1.0, "elbow": -0.6, "wrist": 0.2}


@pytest.fixture
def node(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    (tmp_path / "lab.urdf").write_text(URDF)
    for name, module in modules().items():
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(Node, "given", {"robot": str(tmp_path / "lab.urdf"), "group": "all"})
    yield runpy.run_path(str(NODE))["PlanningNode"]()


def pose(node: Any, frame: str = "base") -> PoseStamped:
    """Return a pose that the arm's last link has in another configuration, as seen from a frame."""
    scene: to.Scene = node.scene
    tip = scene.robot.group("all").tip
    assert tip is not None
    place = scene.placement_of(frame if frame in scene.robot.links else "base", HERE).inverse()
    message = PoseStamped(pose=pose_of(place * scene.placement_of(tip, THERE)))
    message.header.frame_id = frame
    return message


@pytest.mark.parametrize("frame", ["base", "upper"])
def test_plans_to_a_pose_and_sends_the_motion(node: Any, frame: str) -> None:
    node.heard["/goal_pose"](pose(node, frame))
    assert node.log == ["warning: no joint states yet: the pose is ignored"]
    state = JointState(name=["finger_joint", *HERE], position=[0.04, *HERE.values()])
    node.heard["/joint_states"](state)
    node.heard["/goal_pose"](pose(node, frame))
    controller: ActionClient = node.controller
    (goal,) = controller.goals
    motion = goal.trajectory
    assert set(motion.joint_names) == set(HERE)
    ends = [dict(zip(motion.joint_names, motion.points[end].positions, strict=True)) for end in (0, -1)]
    assert ends == [pytest.approx(HERE), pytest.approx(THERE, abs=0.01)]
    assert motion.points[0].velocities == pytest.approx([0.0] * 3)
    assert motion.points[-1].time_from_start.to_sec() > 0.1
    assert node.log[-1] == "info: the controller drives"


def test_reports_errors(node: Any) -> None:
    node.heard["/joint_states"](JointState(name=list(HERE), position=list(HERE.values())))
    node.heard["/goal_pose"](pose(node, "map"))
    assert node.log[-1].startswith("error: ") and "map" in node.log[-1]
    far = pose(node)
    far.pose.position.x = 5.0
    node.heard["/goal_pose"](far)
    assert node.log[-1].startswith("info: ") and node.controller.goals == []
    node.controller.there = False
    node.heard["/goal_pose"](pose(node))
    assert node.log[-1] == "error: the controller's action is not there" and node.controller.goals == []
    node.controller.there, node.controller.accepts = True, False
    node.heard["/goal_pose"](pose(node))
    assert node.log[-1] == "info: the controller refuses the motion"
