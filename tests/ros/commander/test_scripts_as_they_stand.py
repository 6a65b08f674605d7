"""Scripts for MoveIt run without any change: their imports mean the stand-ins while they run."""

import io
import logging
import sys
from pathlib import Path

import pytest
from trajopt.ros.commander.moveit_msgs.msg import MoveItErrorCodes

import trajopt as to
from tests.ros.commander.jumping import JumpingExecutor
from trajopt.ros.commander import MoveItCommanderException, RobotCommander, World
from trajopt.ros.commander.scripts import PACKAGES, Answering, run_script
from trajopt.values.errors import FileFormatError, MissingExtra

OURS = Path(__file__).parent / "as_they_stand" / "reach_and_carry.py"


@pytest.fixture
def world(lab_arm: to.Robot) -> World:
    return World(lab_arm, executor=JumpingExecutor(lab_arm.positions("bent")))


def state_of_the_process() -> tuple[object, ...]:
    roots = {*PACKAGES, "six"}
    names = {name: id(module) for name, module in sys.modules.items() if name.split(".")[0] in roots}
    return names, list(sys.argv), list(sys.path), sys.stdin


def test_a_script_of_our_own(
    world: World, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    before = state_of_the_process()
    with caplog.at_level(logging.INFO, "trajopt.ros.commander"):
        run_script(OURS, ["one", "--two"], world=world, stdin=Answering())
    told = capsys.readouterr().out
    for line in ("there", "executed", "added", "attached", "carried", "detached", "removed"):
        assert f"{line}: True" in told
    assert "fraction: 1.0" in told and "7 JointState JointTrajectory" in told
    assert told.splitlines()[-1] == "at the end"
    said = caplog.text
    assert "/display: DisplayTrajectory: " in said and "points of 3 joints" in said
    assert "String(data='all done')" in said and "2 words: one --two" in said and "handing over" in said
    assert "no planner named 'RRTConnectkConfigDefault'" in said and "trajopt's own plans" in said
    assert "no object in the world named 'box'" in said and "nothing is removed" in said
    assert world.scene.objects == {}
    assert state_of_the_process() == before
    assert "helper_of_the_script" not in sys.modules


def written(folder: Path, text: str) -> Path:
    path = folder / "script.py"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "import rospy\n\nrospy.Subscriber('/x', None)",
            r"line 3: rospy.Subscriber has no stand-in: ",
        ),
        ("import rospy\nrospy.Publihser", r"line 2: rospy.Publihser .*did you mean 'Publisher'"),
        (
            "from tf.transformations import quaternion_of_euler",
            "line 1: tf.transformations.quaternion_of_euler has no stand-in; "
            "did you mean 'quaternion_from_euler'",
        ),
        ("import tf\ntf.TransformListener()", r"line 2: tf.TransformListener has no stand-in: frames"),
        ("import std_msgs.msg\nstd_msgs.msg.Sting", r"std_msgs.msg.Sting .*did you mean 'String'"),
        (
            "import actionlib",
            r"line 1: No module named 'actionlib'; stand-ins exist for moveit_commander",
        ),
        ("import moveit_msgs.srv", r"line 1: No module named 'moveit_msgs.srv'; stand-ins exist for"),
        ("from std_msgs.msg import Sting", r"line 1: .*Sting"),
        ("from moveit_commander import MoveGroupComander", r"line 1: .*MoveGroupComander"),
        (
            "import moveit_commander\nmoveit_commander.MoveGroupCommander('amr')",
            "line 2: no group named 'amr'",
        ),
        ("import rospy\nrospy.get_param('robot_description')", "line 2: .*text of the robot's files"),
        (
            "import rospy\nfrom std_msgs.msg import *\nfrom geometry_msgs.msg import Pose\n"
            "rospy.Publisher('/t', String).publish(Pose())",
            "line 4: topic '/t' takes String, not Pose",
        ),
    ],
)
def test_reports_a_call_without_a_stand_in(world: World, tmp_path: Path, text: str, said: str) -> None:
    before = state_of_the_process()
    with pytest.raises(MoveItCommanderException, match=said):
        run_script(written(tmp_path, text), world=world)
    assert state_of_the_process() == before


def test_scripts_can_probe_for_available_names(world: World, tmp_path: Path) -> None:
    text = (
        "import rospy\nassert not hasattr(rospy, 'Subscriber')\nassert hasattr(rospy, 'Publisher')\n"
        "from std_msgs.msg import Empty\nrospy.Publisher('/beat', Empty).publish(Empty())\n"
        "try:\n    import actionlib\nexcept ImportError:\n    pass\n"
        "try:\n    from std_msgs.msg import Sting\nexcept ImportError:\n    pass\n"
        "try:\n    rospy.get_param('x')\nexcept KeyError:\n    rospy.set_param('/x', 1)\n"
        "assert rospy.get_param('x') == 1 and rospy.myargv(['a', 'b:=c']) == ['a']\n"
        "rospy.signal_shutdown('done')\nassert rospy.is_shutdown()\nraise SystemExit(3)\n"
    )
    with pytest.raises(SystemExit) as ended:
        run_script(written(tmp_path, text), world=world)
    assert ended.value.code == 3
    with pytest.raises(FileFormatError, match="is not a file"):
        run_script(tmp_path / "other.py", world=world)


def test_words_of_older_scripts(
    world: World, tmp_path: Path, caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (
        "import moveit_commander, rospy\nfrom moveit_msgs.msg import DisplayTrajectory\n"
        "robot = moveit_commander.RobotCommander()\ngroup = robot.get_group('arm')\n"
        "group.set_planner_id('RRTstar')\ngroup.set_planning_pipeline_id('ompl')\n"
        "plan = robot.arm.plan([0.1, 0.2, 0.3])\n"
        "rospy.Publisher('/shown', DisplayTrajectory).publish('', [plan])\n"
        "print('executed', group.execute(plan))\n"
        "print(type(robot.lab_arm) if hasattr(robot, 'lab_arm') else 'no such attribute')\n"
        "scene = moveit_commander.PlanningSceneInterface()\nscene.remove_attached_object('hand', 'cup')\n"
        "moveit_commander.os._exit(0)\n"
    )
    with pytest.raises(SystemExit) as ended:
        run_script(written(tmp_path, text), world=world)
    assert ended.value.code == 0
    assert capsys.readouterr().out == "executed True\nno such attribute\n"
    assert world.named_positions == pytest.approx({"shoulder": 0.1, "elbow": 0.2, "wrist": 0.3})
    warned = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    assert [line.split("'")[1] for line in warned] == ["RRTstar", "ompl", "cup"]


def test_published_scene_messages_change_the_scene(world: World, tmp_path: Path) -> None:
    text = (
        "import rospy, moveit_commander, moveit_msgs.msg as m, geometry_msgs.msg as g\n"
        "scene = moveit_commander.PlanningSceneInterface()\n"
        "at = g.PoseStamped()\nat.header.frame_id, at.pose.position.x = 'hand', 0.15\n"
        "objects = rospy.Publisher('/collision_object', m.CollisionObject)\n"
        "objects.publish(scene.make_box('box', at, (0.05,) * 3))\n"
        "held = rospy.Publisher('/attached_collision_object', m.AttachedCollisionObject)\n"
        "held.publish('hand', m.CollisionObject(id='box'))\n"
        "assert list(scene.get_attached_objects(['box'])) == ['box']\n"
        "held.publish('hand', m.CollisionObject(id='box', operation=m.CollisionObject.REMOVE))\n"
        "assert scene.get_known_object_names() == ['box']\n"
        "whole = rospy.Publisher('/planning_scene', m.PlanningScene)\n"
        "gone = m.CollisionObject(id='box', operation=m.CollisionObject.REMOVE)\n"
        "whole.publish(m.PlanningScene(is_diff=True, world=m.PlanningSceneWorld([gone])))\n"
        "assert scene.get_known_object_names() == []\n"
    )
    run_script(written(tmp_path, text), world=world)
    assert world.scene.objects == {}


def test_groups_are_known_with_the_name_of_the_robot(world: World) -> None:
    robot = RobotCommander(world=world)
    assert robot.has_group("lab_arm") and not robot.has_group("ram")
    assert robot.get_group("lab_arm").get_name() == "arm"
    assert robot.get_link_names("lab_arm") == robot.get_link_names("arm")
    assert robot.get_active_joint_names("lab_arm") == robot.get_active_joint_names("arm")
    assert world.group("lab_arm") is world.group("arm")
    with pytest.raises(to.TrajoptError, match="'lab_ram'"):
        world.group("lab_ram")


def test_answers() -> None:
    asked = Answering(io.StringIO("yes\nrest\n"))
    assert [asked.readline() for _ in range(4)] == ["yes\n", "rest\n", "\n", "\n"]
    assert list(Answering(io.StringIO("a\nb\n"))) == ["a\n", "b\n"]
    assert Answering(io.StringIO("all")).read() == "all" and Answering().read() == ""
    assert list(Answering()) == []


@pytest.fixture
def tutorials(shared_data: Path) -> Path:
    folder = shared_data / "moveit_tutorials"
    if not folder.is_dir():
        pytest.skip("MoveIt's tutorials are not beside this repository")
    return folder


@pytest.fixture
def panda() -> World:
    try:
        return World("panda")
    except MissingExtra:
        pytest.skip("the Panda's meshes are not installed")


@pytest.mark.slow
def test_moveits_first_tutorial(
    tutorials: Path, panda: World, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.INFO, "trajopt.ros.commander"):
        run_script(tutorials / "move_group_python_interface_tutorial.py", world=panda, stdin=Answering())
    assert capsys.readouterr().out.endswith("tutorial demo complete!\n")
    said = [record.getMessage() for record in caplog.records]
    assert sum(line.startswith("execution: ended") for line in said) == 4
    assert sum("100.00% of" in line for line in said) == 2
    assert sum("DisplayTrajectory" in line for line in said) == 1
    outcome = panda.outcome
    assert outcome is not None and outcome.error_code.val == MoveItErrorCodes.SUCCESS
    assert panda.scene.objects == {}


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "count"), [("cluttered", 4), ("sparse", 1)])
def test_moveits_tutorial_of_scenes(tutorials: Path, panda: World, kind: str, count: int) -> None:
    run_script(tutorials / "collision_scene_example.py", [kind], world=panda)
    assert len(panda.scene.objects) == count
