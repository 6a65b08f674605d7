"""`trajopt moveit` as a process: the script's output, its log, its exit status."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.process import STRICT
from tests.ros.commander.conftest import SRDF, URDF

SCRIPT = """
import sys, rospy, moveit_commander
from std_msgs.msg import String

input("Enter?")
print("known:", moveit_commander.PlanningSceneInterface().get_known_object_names(), sys.argv[1:])
group = moveit_commander.MoveGroupCommander("arm")
print("at:", group.get_current_joint_values())
rospy.loginfo("hello")
rospy.Publisher("/words", String, queue_size=1).publish("spoken")
if "--subscribe" in sys.argv:
    rospy.Subscriber("/words", String, print)
sys.exit(4)
"""
SCENE = """
world:
  collision_objects:
    - id: pillar
      primitives: [{type: cylinder, dimensions: [0.5, 0.05]}]
      primitive_poses: [{position: [-0.6, 0.0, 0.3], orientation: [0, 0, 0, 1]}]
robot_state: {joint_state: {name: [elbow, finger_joint], position: [0.5, 0.1]}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("moveit")
    for name, text in {"lab.urdf": URDF, "lab.srdf": SRDF, "s.py": SCRIPT, "scene.yaml": SCENE}.items():
        (path / name).write_text(text)
    return path


def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    given = ("moveit", "--robot", "lab.urdf", "--srdf", "lab.srdf", *words)
    command = [sys.executable, *STRICT, "-m", "trajopt", *given]
    done = subprocess.run(
        command, cwd=folder, input="", capture_output=True, text=True, timeout=240, check=False
    )
    assert "Warning" not in done.stderr and "nanobind" not in done.stderr, done.stderr
    return done


def test_a_script_with_arguments_of_its_own(folder: Path) -> None:
    done = run(folder, "--scene", "scene.yaml", "s.py", "word", "--robot", "other")
    assert done.returncode == 4, done.stderr
    assert "Enter?\nknown: ['pillar'] ['word', '--robot', 'other']" in done.stdout
    assert "at: [0.0, 0.5, 0.0]" in done.stdout
    assert "finger_joint" in done.stderr, "what was left out of the scene's file is said"
    assert "[INFO] hello" in done.stderr and "[INFO] /words: String(data='spoken')" in done.stderr


def test_unsupported_scripts_are_reported_in_one_line(folder: Path) -> None:
    done = run(folder, "--yes", "--state", "bent", "s.py", "--subscribe")
    assert done.returncode == 2
    assert "known: []" in done.stdout and "at: [0.0, 0.5, 0.0]" not in done.stdout
    last = done.stderr.splitlines()[-1]
    assert last.startswith("trajopt: s.py, line 12: rospy.Subscriber has no stand-in: ")
    assert "Traceback" not in done.stderr
    assert "is not a file" in run(folder, "other.py").stderr
