"""Tasks of the MoveIt Task Constructor, planned by trajopt."""

from collections.abc import Iterator
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from trajopt.ros.commander.geometry_msgs.msg import (
    Point,
    PointStamped,
    Pose,
    PoseStamped,
    Quaternion,
    Twist,
    TwistStamped,
    Vector3,
    Vector3Stamped,
)
from trajopt.ros.commander.moveit_msgs.msg import CollisionObject, Constraints, OrientationConstraint
from trajopt.ros.commander.shape_msgs.msg import SolidPrimitive
from trajopt.ros.commander.std_msgs.msg import Header

from trajopt.ros.commander import MoveItCommanderException, PlanningSceneInterface, World
from trajopt.ros.commander.moveit.core.planning_scene import PlanningScene
from trajopt.ros.commander.moveit.task_constructor import core, stages
from trajopt.ros.commander.scripts import run_script
from trajopt.values.arrays import Floats
from trajopt.values.errors import MissingExtra
from trajopt.values.placement import Placement

ARM, TIP = "panda_arm", "panda_link8"
FREE, STRAIGHT = core.PipelinePlanner(), core.CartesianPath()


@pytest.fixture
def panda() -> Iterator[World]:
    try:
        world = World("panda")
    except MissingExtra:
        pytest.skip("the Panda's meshes are not installed")
    with world:
        yield world


def motion(
    kind: type[stages.MoveTo] | type[stages.MoveRelative], planner: Any, goal: Any, **given: Any
) -> Any:
    """Return a motion of the arm, named after its arguments."""
    stage = kind(f"{kind.__name__} {len(given)}", planner)
    for name, value in {"group": ARM, **given}.items():
        setattr(stage, name, value)
    (stage.setGoal if isinstance(stage, stages.MoveTo) else stage.setDirection)(goal)
    return stage


def planned(*parts: core.Stage) -> core.Task:
    task = core.Task()
    task.add(stages.CurrentState(), *parts)
    task.plan()
    return task


def along(x: float = 0.0, y: float = 0.0, z: float = 0.0, frame: str = "world") -> Vector3Stamped:
    return Vector3Stamped(header=Header(frame_id=frame), vector=Vector3(x, y, z))


def at_pose(x: float, y: float, z: float, frame: str = "world") -> PoseStamped:
    pose = Pose(position=Point(x, y, z), orientation=Quaternion(x=1.0))
    return PoseStamped(header=Header(frame_id=frame), pose=pose)


def tip(world: World, positions: Floats) -> Placement:
    return world.scene.placement_of(TIP, positions)


def tips(world: World, task: core.Task, motion: int) -> Floats:
    """Return points of the tip during a motion of the solution, shape (n, 3) [m]."""
    segment = task.solutions[0].result.segments[motion]
    times = np.linspace(0.0, segment.trajectory.duration, 50).tolist()
    return np.array([tip(world, segment.positions(time)).translation for time in times])


def test_a_script_with_pick_and_place(
    panda: World, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", "trajopt.ros.commander")
    script = Path(__file__).parent / "as_they_stand" / "pick_with_task_constructor.py"
    run_script(script, world=panda)
    assert capsys.readouterr().out == "executed 1\n"
    bar = panda.scene.placement_of("bar", panda.positions)
    assert bar.translation == pytest.approx((0.5, 0.3, 0.215), abs=1e-3)
    assert panda.named_positions["panda_joint4"] == pytest.approx(-2.356, abs=1e-2)
    assert panda.named_positions["panda_finger_joint1"] == pytest.approx(0.0, abs=1e-3)
    told = "\n".join(record.getMessage() for record in caplog.records)
    names = ("  pick", "    approach", "    lift", "  place", "    carry", "    release", "  home", "  shut")
    assert all(name in told for name in names)


def test_straight_motions(panda: World) -> None:
    turn = TwistStamped(header=Header(frame_id="world"), twist=Twist(angular=Vector3(0.0, 0.0, pi / 4.0)))
    offsets = {"panda_joint1": pi / 6.0, "panda_joint3": -pi / 6.0}
    task = planned(
        motion(stages.MoveRelative, STRAIGHT, along(x=0.1)),
        motion(stages.MoveRelative, STRAIGHT, turn),
        motion(stages.MoveRelative, STRAIGHT, offsets),
        motion(stages.MoveTo, FREE, "ready"),
    )
    result = task.solutions[0].result
    assert result.certificate.verified
    assert result.final_state["panda_joint4"] == pytest.approx(-2.356, abs=1e-3)
    points = tips(panda, task, 0)
    assert points[-1] - points[0] == pytest.approx((0.1, 0.0, 0.0), abs=1e-4)
    assert np.abs(points[:, 1:] - points[0, 1:]).max() < 1e-4
    second = result.segments[1]
    begun, turned = (tip(panda, at).rotation for at in (second.positions(0.0), second.end))
    assert (turned @ begun.T)[1, 0] == pytest.approx(np.sin(pi / 4.0), abs=1e-3)
    assert np.abs(tips(panda, task, 1) - tips(panda, task, 1)[0]).max() < 1e-4


def test_goals(panda: World) -> None:
    point = PointStamped(header=Header(frame_id=TIP), point=Point(0.0, 0.0, 0.05))
    pads = at_pose(0.0, 0.0, 0.1, "panda_hand")
    pads.pose.orientation = Quaternion(w=1.0)
    task = planned(
        motion(stages.MoveTo, FREE, point),
        motion(stages.MoveTo, FREE, at_pose(0.4, 0.2, 0.3), ik_frame=pads),
        motion(stages.MoveRelative, FREE, {"panda_joint1": 0.2}),
        motion(stages.MoveRelative, FREE, along(z=-0.05, frame=TIP), max_distance=0.02),
    )
    ends = {
        name: segment.positions(time)
        for segment in task.solutions[0].result.segments
        for name, time in segment.ends
    }
    moved, placed, turned, lifted = (ends[stage.name] for stage in list(task)[1:])
    before = panda.scene.placement_of(TIP, panda.positions)
    assert before.inverse() * tip(panda, moved).translation == pytest.approx((0.0, 0.0, 0.05), abs=1e-3)
    hand = panda.scene.placement_of("panda_hand", placed)
    assert hand * np.array((0.0, 0.0, 0.1)) == pytest.approx((0.4, 0.2, 0.3), abs=1e-3)
    assert turned - placed == pytest.approx([0.2] + [0.0] * (len(placed) - 1), abs=1e-3)
    up = tip(panda, turned).inverse() * tip(panda, lifted).translation
    assert up == pytest.approx((0.0, 0.0, -0.02), abs=1e-3)


def test_a_line_that_ends_early_is_long_enough(panda: World) -> None:
    far = {"max_distance": 1.0, "min_distance": 0.2}
    task = planned(motion(stages.MoveRelative, STRAIGHT, along(x=1.0), **far))
    points = tips(panda, task, 0)
    assert 0.2 < points[-1, 0] - points[0, 0] < 1.0
    failed = planned(motion(stages.MoveRelative, STRAIGHT, along(x=1.0)))
    assert not failed.solutions
    assert "MoveRelative 0" in failed.failures[0].comment
    whole = {"max_distance": 0.1, "min_distance": 0.1}
    points = tips(panda, planned(motion(stages.MoveRelative, STRAIGHT, along(z=-0.5), **whole)), 0)
    assert points[0, 2] - points[-1, 2] == pytest.approx(0.1, abs=1e-3)


def test_a_line_shorter_than_the_least_is_refused(panda: World) -> None:
    short = motion(stages.MoveRelative, STRAIGHT, along(z=-0.01), min_distance=0.05)
    with pytest.raises(MoveItCommanderException, match=r"moves 0.01 m, less than its min_distance of 0.05 m"):
        planned(short)
    more = core.CartesianPath()
    more.min_fraction = 1.5
    with pytest.raises(MoveItCommanderException, match=r"less than min_fraction 1.5"):
        planned(motion(stages.MoveRelative, more, along(z=-0.1)))


def test_choices_and_groups_together(panda: World) -> None:
    near, far = ({"panda_joint1": 0.1}, {"panda_joint1": 1.5})
    away = motion(stages.MoveTo, FREE, at_pose(3.0, 0.0, 0.5))
    both, either, hands = core.Alternatives("either"), core.Fallbacks("or else"), core.Merger("both")
    for goal in (far, near):
        both.insert(motion(stages.MoveTo, FREE, goal))
    either.add(away, motion(stages.MoveTo, FREE, far))
    hands.add(motion(stages.MoveTo, FREE, "extended"), motion(stages.MoveTo, FREE, "close", group="hand"))
    assert planned(both).solutions[0].result.final_state["panda_joint1"] == pytest.approx(0.1, abs=1e-4)
    assert planned(either).solutions[0].result.final_state["panda_joint1"] == pytest.approx(1.5, abs=1e-4)
    (segment,) = planned(hands).solutions[0].result.segments
    assert {"panda_joint1", "panda_finger_joint1"} <= set(segment.trajectory.joint_names)


def ball(x: float, y: float, z: float, radius: float) -> CollisionObject:
    shape = SolidPrimitive(SolidPrimitive.SPHERE, [radius])
    where = Pose(position=Point(x, y, z), orientation=Quaternion(w=1.0))
    return CollisionObject(Header(frame_id="world"), id="ball", primitives=[shape], primitive_poses=[where])


def test_the_scene_changes_between_motions(panda: World) -> None:
    aside = motion(stages.MoveRelative, FREE, along(y=0.3))
    upright = OrientationConstraint(header=Header(frame_id="world"), link_name="panda_hand", weight=1.0)
    upright.orientation.x = 1.0
    upright.absolute_x_axis_tolerance = upright.absolute_y_axis_tolerance = 0.05
    upright.absolute_z_axis_tolerance = 0.05
    aside.path_constraints = Constraints(orientation_constraints=[upright])
    change = stages.ModifyPlanningScene("ball")
    change.addObject(ball(0.4, 0.2, 0.55, 0.08))
    change.allowCollisions("ball", ["panda_hand"])
    change.allowCollisions("ball", False)
    task = planned(change, aside)
    checks = task.solutions[0].result.certificate.checks
    assert any("rotation" in check.name and "path" in check.name for check in checks)
    assert "ball" in task.solutions[0].result.final_scene.objects
    assert panda.scene.objects == {}
    into = stages.ModifyPlanningScene("into the arm")
    into.addObject(ball(*panda.scene.placement_of(TIP, panda.positions).translation.tolist(), 0.1))
    assert "into the arm" in planned(into).failures[0].comment
    into.allowCollisions("ball")
    assert planned(into).solutions


def test_objects_are_attached_detached_and_removed(panda: World) -> None:
    PlanningSceneInterface().add_object(ball(0.5, 0.0, 0.3, 0.03))
    change, back = stages.ModifyPlanningScene("take"), stages.ModifyPlanningScene("leave")
    change.attachObject("ball", "panda_hand")
    back.detachObjects(["ball"], "panda_hand")
    task = planned(change, motion(stages.MoveTo, FREE, {"panda_joint1": 0.5}), back)
    moved = task.solutions[0].result.final_scene.object("ball").placement.translation
    assert moved == pytest.approx((0.5 * np.cos(0.5), 0.5 * np.sin(0.5), 0.3), abs=1e-3)
    gone = stages.ModifyPlanningScene("gone")
    gone.removeObject("ball")
    assert planned(gone).solutions[0].result.final_scene.objects == {}


def test_a_pose_from_a_generator(panda: World) -> None:
    generator = stages.GeneratePose("above")
    generator.pose = at_pose(0.0, 0.0, 0.1, TIP)
    generator.pose.pose.orientation = Quaternion(w=1.0)
    found = stages.ComputeIK("reach", generator)
    found.group = ARM
    slow = core.PipelinePlanner()
    quick = planned(stages.Connect("there", [(ARM, FREE)]), found).solutions[0]
    slow.max_velocity_scaling_factor = slow.max_acceleration_scaling_factor = 0.25
    later = planned(stages.Connect("there", [(ARM, slow)]), found).solutions[0]
    before = panda.scene.placement_of(TIP, panda.positions)
    after = panda.scene.placement_of(TIP, quick.result.final_positions)
    assert before.inverse() * after.translation == pytest.approx((0.0, 0.0, 0.1), abs=1e-3)
    assert later.cost > 1.9 * quick.cost


def test_execution_needs_the_planned_scene(panda: World) -> None:
    task = planned(motion(stages.MoveTo, FREE, {"panda_joint1": 0.3}))
    PlanningSceneInterface().add_sphere("far away", at_pose(2.0, 2.0, 2.0), 0.1)
    assert task.execute(task.solutions[0]).val < 0
    task.plan()
    assert task.execute(task.solutions[0]).val == 1
    assert panda.named_positions["panda_joint1"] == pytest.approx(0.3, abs=1e-2)


def test_a_fixed_state(panda: World) -> None:
    there = PlanningScene(core.Task().getRobotModel())
    there.current_state.joint_positions = {"panda_joint1": 1.0}
    fixed, task = stages.FixedState(), core.Task()
    fixed.setState(there)
    task.add(fixed, motion(stages.MoveTo, FREE, "ready"))
    assert task.plan()
    assert task.solutions[0].result.start[0] == 1.0


def test_properties() -> None:
    made, other = core.PropertyMap(), core.PropertyMap()
    made.update({"one": 1, "two": 2})
    made.exposeTo(other, ["two"])
    assert dict(other) == {"two": 2}
    one = made.property("one")
    one.setCurrentValue(3)
    assert (one.value(), one.defaultValue(), one.defined()) == (3, 1, True)
    one.reset()
    assert one.value() == 1
    with pytest.raises(MoveItCommanderException, match="did you mean 'one'"):
        made["onw"]


def test_refusals_name_the_stage_and_the_remedy(panda: World) -> None:
    constrained = motion(stages.MoveTo, STRAIGHT, "ready", path_constraints=Constraints())
    grasp = stages.SimpleGrasp(stages.GeneratePose("pose"), "grasp")
    merged = core.Merger("both")
    merged.add(motion(stages.MoveRelative, FREE, along(x=0.1)))
    cases: list[tuple[core.Stage, str]] = [
        (constrained, "stage 'MoveTo 1': MoveTo keeps no path_constraints .* use PipelinePlanner"),
        (stages.Connect("c", [(ARM, STRAIGHT)]), "stage 'c': Connect has no straight lines: use MoveTo"),
        (stages.Pick(grasp, "p"), r"stage 'p': Pick needs SimpleGrasp\(GenerateGraspPose"),
        (grasp, "stage 'grasp': SimpleGrasp is not planned alone"),
        (merged, "stage 'MoveRelative 0': MoveRelative cannot be in a Merger: use MoveTo"),
        (
            stages.ComputeIK("ik", stages.CurrentState()),
            "stage 'ik': ComputeIK has no pose: use GeneratePose",
        ),
        (stages.MoveTo("m", FREE), "stage 'm': MoveTo is incomplete: call setGoal"),
        (motion(stages.MoveTo, FREE, "ready", group="ram"), "no group named 'ram'"),
        (motion(stages.MoveTo, FREE, "redy"), "did you mean 'ready'"),
    ]
    for stage, words in cases:
        with pytest.raises(MoveItCommanderException, match=words):
            planned(stage)
    with pytest.raises(MoveItCommanderException, match=r"'gruop' is not a property .*did you mean 'group'"):
        stages.MoveTo("m", FREE).gruop = ARM
    with pytest.raises(MoveItCommanderException, match="'nxt' is not a stage of 'task'"):
        core.Task()["nxt"]


def test_stages_without_a_stand_in_are_named(panda: World, tmp_path: Path) -> None:
    path = tmp_path / "script.py"
    path.write_text("from moveit.task_constructor import stages\nstages.FixCollisionObjects('fix')\n")
    with pytest.raises(MoveItCommanderException, match=r"script.py, line 2: .*move the object by Planning"):
        run_script(path, world=panda)
