"""The frame of a tool that the scene has, in a script for MoveIt."""

import pytest
from trajopt.ros.commander.geometry_msgs.msg import Pose

import trajopt as to
from trajopt.ros.commander import MoveGroupCommander, PlanningSceneInterface, World


def test_poses_are_about_a_tool(lab_arm: to.Robot) -> None:
    scene = to.Scene(lab_arm).with_tool("tcp", on="finger", placement=to.placement((0.1, 0.0, 0.0)))
    with World(lab_arm, scene=scene, start="bent") as world:
        group = MoveGroupCommander("arm")
        hand = group.get_current_pose().pose.position
        group.set_end_effector_link("tcp")
        tip = group.get_current_pose().pose.position
        away = ((tip.x - hand.x) ** 2 + (tip.y - hand.y) ** 2) ** 0.5
        assert away == pytest.approx(0.16)
        group.set_position_target([tip.x - 0.05, tip.y, tip.z])
        assert group.go()
        there = world.scene.placement_of("tcp", world.positions).translation
        assert there == pytest.approx([tip.x - 0.05, tip.y, tip.z], abs=2e-3)


def test_clearing_the_scene_keeps_the_tools_of_the_robot(lab_arm: to.Robot) -> None:
    scene = to.Scene(lab_arm).add("drill", to.Box(0.02, 0.02, 0.02), frame="finger", touch_links=["finger"])
    scene = scene.with_tool("bit", on="drill").with_tool("tcp", on="finger")
    with World(lab_arm, scene=scene, start="bent") as world:
        PlanningSceneInterface().clear()
        assert list(world.scene.tools) == ["tcp"] and not world.scene.objects


def test_a_world_is_given_a_tool_while_it_runs(lab_arm: to.Robot) -> None:
    with World(lab_arm, start="bent") as world:
        world.edit(lambda scene: scene.with_tool("tcp", on="finger"))
        group = MoveGroupCommander("arm")
        group.set_end_effector_link("tcp")
        pose: Pose = group.get_current_pose().pose
        assert pose.position.z == pytest.approx(0.1)
        PlanningSceneInterface().add_box("cup", group.get_current_pose(), (0.01, 0.01, 0.01))
        group.attach_object("cup", "tcp")
        assert world.scene.object("cup").frame == "tcp"
        assert group.detach_object("tcp")
