"""Tools of a scene: frames that the robot has there, which do wherever a frame is meant."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.optimise.kinematics import inverse_kinematics
from trajopt.optimise.terms import soft_clearance
from trajopt.optimise.terms.clearance import SoftDistance
from trajopt.scene.reducing import reduce_model, tool_frame
from trajopt.tasks.cartesian import follow, follows_curve, line
from trajopt.values.errors import FrameNotFound

AT = to.placement((0.02, 0.0, 0.1), rpy=(0.0, 0.3, 0.0))


@pytest.fixture
def arm(tmp_path: Path) -> to.Scene:
    return to.Scene(odd_arm(tmp_path)).add("table", to.Box(1, 1, 0.1), to.placement((0.8, 0, -0.3)))


@pytest.fixture
def drilling(arm: to.Scene) -> to.Scene:
    """A drill on the last link, and the frame of its tip."""
    drill = arm.add("drill", to.Cylinder(0.02, 0.1), to.placement((0, 0, 0.1)), frame="tip")
    return drill.with_tool("bit", on="drill", placement=to.placement((0, 0, 0.05)))


def test_a_tool_moves_with_its_parent_frame(arm: to.Scene) -> None:
    scene, here = arm.with_tool("tcp", on="tip", placement=AT), arm.robot.positions()
    expected = arm.placement_of("tip", here) * AT
    assert np.allclose(scene.placement_of("tcp", here).homogeneous, expected.homogeneous)
    assert "tcp" not in arm.tools, "a scene is a value"
    again = scene.move("tcp", to.placement((0, 0, 0.2)))
    assert again.tools["tcp"].placement.translation == pytest.approx([0, 0, 0.2])
    assert not scene.remove("tcp").tools


def test_a_tool_on_an_object_follows_the_object(drilling: to.Scene) -> None:
    here = drilling.robot.positions()
    moved = drilling.move("drill", to.placement((0, 0, 0.3)))
    away = moved.placement_of("bit", here).translation - drilling.placement_of("bit", here).translation
    assert np.linalg.norm(away) == pytest.approx(0.2)
    rack = drilling.detach("drill", at=here)
    assert rack.holder("bit").link == "world"


def test_a_tool_is_a_frame_of_the_reduced_model(drilling: to.Scene) -> None:
    on_tool = drilling.with_tool("probe", on="bit", placement=AT)
    reduced = reduce_model(on_tool, "all", on_tool.robot.positions())
    for name in ("bit", "probe"):
        joint, _ = reduced.attachment(name)
        assert joint == reduced.attachment("tip")[0]


def test_the_last_tool_is_the_tool_frame_of_its_arm() -> None:
    panda = to.load("panda")
    scene = to.Scene(panda).with_tool("wide", on="panda_hand").with_tool("tip", on="panda_hand")
    arm, hand = (reduce_model(scene, group, panda.positions("ready")) for group in ("panda_arm", "hand"))
    assert tool_frame(arm) == "tip" and tool_frame(hand) not in scene.tools


def test_a_tool_is_kept_and_printed(drilling: to.Scene) -> None:
    for scene in (pickle.loads(pickle.dumps(drilling)), copy.deepcopy(drilling), copy.copy(drilling)):
        assert scene.tools["bit"].frame == "drill"
        assert np.array_equal(
            scene.tools["bit"].placement.homogeneous, drilling.tools["bit"].placement.homogeneous
        )
    assert "with bit, table, drill" in repr(drilling)
    problem = to.Problem(scene=drilling, start={}, goal=to.joint_positions({"pan": 0.3}))
    assert "tool         bit on drill at (0, 0, 0.05) m" in str(problem)


@pytest.mark.parametrize("frame", ["bit", "tip", "drill"])
def test_every_kind_of_frame_is_a_goal_a_constraint_and_a_speed(drilling: to.Scene, frame: str) -> None:
    start = drilling.robot.positions({"pan": -0.4, "elbow": 0.4})
    goal = drilling.placement_of(frame, drilling.robot.positions({"pan": 0.4, "elbow": 0.4}))
    upright = drilling.placement_of(frame, start).rotation.T @ (0.0, 0.0, 1.0)
    problem = to.Problem(
        scene=drilling,
        start=start,
        goal=to.frame_placement(frame, goal, position_tolerance=1e-3, rotation_tolerance=1e-2),
        constraints=[to.axis_alignment(frame, axis=upright, tolerance=0.2)],
        tool_speed=to.tool_speed(frame, linear=0.2),
    )
    plan = to.plan(problem).require()
    ended = drilling.placement_of(frame, problem.reduced.all_positions(plan.trajectory.positions[-1]))
    assert np.linalg.norm(ended.translation - goal.translation) < 2e-3
    speeds = [check for check in plan.certificate.checks if "tool speed" in check.name]
    assert [check.subject for check in speeds] == [frame]


def test_inverse_kinematics_places_a_tool(drilling: to.Scene) -> None:
    start = drilling.robot.positions({"pan": -0.4, "elbow": 0.4})
    reduced = reduce_model(drilling, "all", start)
    here = drilling.placement_of("bit", start)
    found = inverse_kinematics(reduced, to.frame_placement("bit", here), rng=np.random.default_rng(0))
    assert found.free


def test_a_tool_follows_a_curve() -> None:
    panda = to.load("panda")
    scene = to.Scene(panda).with_tool("tip", on="panda_hand_tcp", placement=to.placement((0, 0, 0.05)))
    here = scene.placement_of("tip", panda.positions("ready"))
    curve = follows_curve("tip", line(here, here * to.placement((0, 0.05, 0))))
    assert follow(scene, curve, group="panda_arm", start="ready").fraction == 1.0


def edits(scene: to.Scene, link: str) -> list[object]:
    """What is said of a link, by that name or the name of a frame on it."""
    other = scene.allow(link, "table").with_margin(0.03, link, "table").with_clearance(0.002, link, "drill")
    other = other.allow_contact("meant", link, "table", first=0.5)
    other = other.add("cup", to.Sphere(0.01), frame=link, touch_links=[link])
    return [
        other.may_touch(link, "table"),
        other.margin_of(link, "table"),
        other.clearance_of(link, "drill"),
        dict(other.pair_margins),
        dict(other.clearances.pairs),
        other.allowances,
        other.object("cup").touch_links,
        dict(other.allowed.entries),
    ]


def test_a_frame_means_the_link_it_is_fixed_on_where_a_link_is_needed(drilling: to.Scene) -> None:
    scene = drilling.with_tool("tcp", on="tip", placement=AT).with_tool("further", on="tcp")
    said = edits(scene, "tip")
    assert said[0] is True and said[1] == 0.03 and said[2] == 0.002
    assert edits(scene, "tcp") == said == edits(scene, "further")
    assert scene.owner("bit") == "drill", "a frame on an object means the object"


def test_a_link_without_a_shape_means_the_one_it_is_fixed_on() -> None:
    scene = to.Scene(to.load("panda")).add("table", to.Box(0.5, 0.5, 0.1), to.placement((0.8, 0, -0.2)))
    assert scene.owner("panda_hand_tcp") == "panda_hand" and scene.owner("panda_link8") == "panda_link7"
    wide = scene.with_margin(0.05, "panda_hand_tcp", "table")
    assert wide.margin_of("panda_hand", "table") == 0.05 == wide.margin_of("panda_hand_tcp", "table")
    free = scene.allow("panda_hand_tcp", "table")
    assert free.may_touch("panda_hand", "table") and free.may_touch("panda_hand_tcp", "table")


def test_an_object_is_attached_to_a_frame_or_an_attached_object(drilling: to.Scene) -> None:
    at = to.placement((0.0, 0.0, 0.06))
    for holder, touched in (("bit", {"tip", "drill"}), ("drill", {"tip", "drill"}), ("tip", {"tip"})):
        held = drilling.add("screw", to.Sphere(0.005)).attach("screw", holder, placement=at)
        assert held.holder("screw").link == "tip"
        assert held.object("screw").touch_links == touched
        here = held.robot.positions()
        expected = held.placement_of(holder, here) * at
        assert np.allclose(held.placement_of("screw", here).homogeneous, expected.homogeneous)


def test_an_object_may_touch_an_object_by_name(drilling: to.Scene) -> None:
    scene = drilling.add("shaving", to.Sphere(0.01), frame="table", touch_links=["drill"])
    assert scene.may_touch("shaving", "drill") and not scene.may_touch("shaving", "tip")
    assert scene.may_touch("bit", "shaving"), "a frame on the drill means the drill"


def test_soft_clearance_takes_frames(drilling: to.Scene) -> None:
    costs = [soft_clearance(0.05, pairs={(name, "table"): SoftDistance(0.2)}) for name in ("bit", "drill")]
    reduced = reduce_model(drilling, "all", drilling.robot.positions())
    first, second = (cost.residual.by_pair(reduced)[0] for cost in costs)  # type: ignore[attr-defined]
    assert np.array_equal(first, second) and first.max() == 0.2


def test_unknown_names_come_with_those_of_tools(drilling: to.Scene) -> None:
    with pytest.raises(FrameNotFound, match="'bit'"):
        to.Problem(scene=drilling, start={}, goal=to.frame_placement("bitt", to.placement()))
    with pytest.raises(FrameNotFound, match="'bit'"):
        drilling.with_margin(0.01, "bti", "table")


def test_a_tool_is_simulated(drilling: to.Scene) -> None:
    problem = to.Problem(scene=drilling, start={"pan": -0.4}, goal=to.joint_positions({"pan": 0.1}))
    plan = to.plan(problem).require()
    assert to.simulate(plan).final_pose_error("bit").position < 0.01
