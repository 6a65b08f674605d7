"""A motion that is planned with a model error holds for every robot within it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from trajopt.files.bundle import read_bundle
from trajopt.files.proof import check_proof
from trajopt.geometry import evaluator
from trajopt.scene.reduced import loaded_model
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.errors import JointNotFound, ProblemError, ShapeError

ANGLE = float(np.deg2rad(0.2))


def turned(axis: Floats, angle: float) -> Floats:
    return pin.exp3(axis / np.linalg.norm(axis) * angle)


def as_built(scene: to.Scene, rng: np.random.Generator) -> tuple[to.Scene, Floats]:
    """Return a robot of the box: the objects as its root sees them, and the error of each joint."""
    error = scene.model_error
    sizes = np.array([error.joints.get(name, 0.0) for name in scene.robot.joint_names])
    offsets = sizes * rng.choice((-1.0, 1.0, 0.3), len(sizes))
    rotation = turned(rng.normal(size=3), error.turn)
    way = rng.normal(size=3)
    root = to.Placement(rotation, way / np.linalg.norm(way) * error.shift)
    for name, item in scene.objects.items():
        if item.frame == "world":
            scene = scene.move(name, root.inverse() * item.placement)
    return scene, offsets


def distances(scene: to.Scene, problem: to.Problem, positions: Floats, offsets: Floats) -> Floats:
    """Return the distance of every pair at positions of all joints, (p,) [m]; infinite beyond 9 m."""
    reduced = reduce_model(scene, problem.group, scene.robot.followed(positions) + offsets)
    found = evaluator(reduced).close_pairs(
        reduced.start_positions[None], np.full(len(reduced.pairs.first), 0.3)
    )
    apart = np.full(len(reduced.pairs.first), np.inf)
    np.minimum.at(apart, found.pair, found.distance)
    return apart


@pytest.mark.parametrize("name", ["cup_past_pillar", "past_pillar_ur5", "past_pillar_xarm7", "planar_fold"])
def test_no_robot_of_the_box_is_nearer(name: str) -> None:
    try:
        problem = to.named_problem(name)
    except to.MissingExtra as error:
        pytest.skip(str(error))
    scene = problem.scene.with_model_error(joints=ANGLE, mounting=(2e-3, ANGLE))
    reduced = replace(problem, scene=scene).reduced
    bound, limits = reduced.pairs.error, reduced.limits
    rng, closest = np.random.default_rng(3), 0.0
    for _ in range(40):
        here = reduced.all_positions(rng.uniform(limits.lower, limits.upper))
        built, offsets = as_built(scene, rng)
        described = distances(scene, problem, here, np.zeros(len(here)))
        real = distances(built, problem, here, offsets)
        seen = (described > 0.0) & np.isfinite(described)
        assert (real[seen] >= described[seen] - bound[seen] - 1e-9).all()
        nearer = (described[seen] - real[seen]) / bound[seen]
        closest = max(closest, float(nearer.max(initial=0.0)))
    assert closest > 0.2


def facing_arms(path: Path) -> to.Problem:
    """Two arms of one joint each, a bar of 0.5 m, whose tips are 0.1 m apart at zero."""
    text = '<robot name="two"><link name="base"/>'
    for name, x, along in (("left", -0.55, 1.0), ("right", 0.55, -1.0)):
        text += (
            f'<link name="{name}"><collision><origin xyz="{0.25 * along} 0 0"/><geometry>'
            f'<box size="0.5 0.05 0.05"/></geometry></collision></link><joint name="{name}_joint" '
            f'type="revolute"><parent link="base"/><child link="{name}"/><origin xyz="{x} 0 0"/>'
            '<axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="50" velocity="2"/></joint>'
        )
    path.write_text(text + "</robot>")
    robot = to.Robot.from_urdf(path)
    return to.Problem(
        scene=to.Scene(robot), start=dict.fromkeys(robot.joint_names, 0.0), goal={"left_joint": 1.0}
    )


def test_two_arms_that_are_off_towards_each_other_count_both(tmp_path: Path) -> None:
    problem = facing_arms(tmp_path / "two.urdf")
    reduced = replace(problem, scene=problem.scene.with_model_error(joints=1e-3)).reduced
    tips = (("left", np.array((0.5, 0.0, 0.0))), ("right", np.array((-0.5, 0.0, 0.0))))

    def apart(positions: Floats) -> float:
        placed = [
            reduced.scene.placement_of(link, reduced.all_positions(positions)) * tip for link, tip in tips
        ]
        return float(np.linalg.norm(placed[0] - placed[1]))

    # Both bars point the same way, side by side: each error brings its tip straight to the other.
    here = np.array((np.pi / 2.0, -np.pi / 2.0))
    signs = (1, 1), (-1, -1), (1, -1), (-1, 1)
    nearer = max(apart(here) - apart(here + 1e-3 * np.array(each)) for each in signs)
    one = replace(problem, scene=problem.scene.with_model_error(joints={"left_joint": 1e-3})).reduced
    assert one.pairs.error.max() < nearer <= reduced.pairs.error.max()


def test_a_motion_holds_for_robots_of_the_box() -> None:
    problem = to.named_problem("cup_past_pillar")
    scene = problem.scene.with_model_error(joints=ANGLE, mounting=(1e-3, ANGLE))
    plan = to.plan(replace(problem, scene=scene))
    assert plan.verified, plan.reason
    assert "differs from its description by no more than" in str(plan.certificate)
    rng, reduced = np.random.default_rng(4), problem.reduced
    moments = plan.trajectory(np.linspace(0.0, plan.trajectory.duration, 25))
    for _ in range(8):
        built, offsets = as_built(scene, rng)
        for positions in moments:
            assert distances(built, problem, reduced.all_positions(positions), offsets).min() > 0.0


def test_a_motion_that_is_too_near_for_the_error_is_refused() -> None:
    problem = to.named_problem("cup_past_pillar")
    plan = to.plan(problem)
    scene = problem.scene.with_model_error(mounting=(0.012, 0.0))
    certificate = to.judge(replace(problem, scene=scene), plan.trajectory)
    assert not certificate.verified
    assert [check.name for check in certificate.failed] == ["clearance"]


def loaded(payload: float) -> to.Problem:
    problem = to.named_problem("cup_past_pillar")
    scene, cup = problem.scene, problem.scene.object("cup")
    objects = {**scene.objects, "cup": replace(cup, mass=2.5)}
    return replace(problem, scene=replace(scene, objects=objects).with_model_error(payload=payload))


@pytest.mark.parametrize("share", [-0.3, 0.3])
def test_torques_hold_for_lighter_and_heavier_payloads(share: float) -> None:
    problem = loaded(0.3)
    limits = problem.scene.robot.limits
    weak = replace(limits, effort=np.where(np.arange(len(limits.effort)) == 1, 60.0, limits.effort))
    robot = replace(problem.scene.robot, limits=weak)
    problem = replace(problem, scene=replace(problem.scene, robot=robot))
    plan = to.plan(problem)
    assert plan.verified, plan.reason
    shown = next(check for check in plan.certificate.checks if check.name == "torque")
    item = problem.scene.object("cup")
    other = replace(
        problem.scene, objects={**problem.scene.objects, "cup": replace(item, mass=item.mass * (1.0 + share))}
    )
    model = loaded_model(replace(problem, scene=other).reduced)
    data, motion = model.createData(), plan.trajectory
    times = np.linspace(0.0, motion.duration, 200)
    states = [motion(times, order) for order in range(3)]
    torques = np.array([pin.rnea(model, data, *row).copy() for row in zip(*states, strict=True)])
    effort = problem.limits.effort
    assert (np.abs(torques) <= effort + 1e-6).all()
    assert shown.value is not None
    assert abs(shown.value) >= np.abs(torques[:, 1]).max() - 1e-3


def test_a_scene_with_a_model_error_survives_a_file(tmp_path: Path) -> None:
    problem = to.named_problem("cup_past_pillar")
    scene = problem.scene.with_model_error(joints={"panda_joint2": ANGLE}, mounting=(1e-3, ANGLE))
    asked = replace(problem, scene=scene)
    asked.save(tmp_path / "asked.trajopt")
    again = read_bundle(tmp_path / "asked.trajopt").problem
    assert again.scene.model_error == scene.model_error
    assert (again.reduced.pairs.error == asked.reduced.pairs.error).all()


def test_a_proof_file_states_the_clearance_and_not_the_payload(tmp_path: Path) -> None:
    problem = loaded(0.2)
    scene = problem.scene.with_model_error(joints=ANGLE, payload=0.2)
    plan = to.plan(replace(problem, scene=scene))
    plan.require().save_proof(tmp_path / "x.proof")
    answer = check_proof(tmp_path / "x.proof")
    assert answer.proven, answer.words
    assert "torque for a payload that is 20 % lighter or heavier" in answer.words


def test_a_robot_without_shapes_has_no_pairs(tmp_path: Path) -> None:
    file = tmp_path / "bare.urdf"
    file.write_text(
        '<robot name="bare"><link name="base"/><link name="bar"/><joint name="turn" type="revolute">'
        '<parent link="base"/><child link="bar"/><limit lower="-1" upper="1" effort="9" velocity="1"/>'
        "</joint></robot>"
    )
    scene = to.Scene(to.Robot.from_urdf(file)).with_model_error(joints=ANGLE, mounting=(1e-3, ANGLE))
    assert len(to.Problem(scene=scene, start={"turn": 0.0}, goal={"turn": 0.5}).reduced.pairs.error) == 0


def test_without_an_error_nothing_changes() -> None:
    problem = to.named_problem("cup_past_pillar")
    same = replace(problem, scene=problem.scene.with_model_error())
    assert not same.reduced.pairs.error.any()
    assert (same.reduced.pairs.margin == problem.reduced.pairs.margin).all()


def test_a_goal_within_the_error_of_an_obstacle_is_refused() -> None:
    problem = to.named_problem("cup_past_pillar")
    wide = replace(problem, scene=problem.scene.with_model_error(mounting=(0.1, 0.0)))
    plan = to.plan(wide)
    assert plan.status is to.Status.GOAL_IN_COLLISION
    assert "mm from" in plan.reason and "are required" in plan.reason


def test_wrong_errors_name_the_fault() -> None:
    scene = to.named_problem("cup_past_pillar").scene
    with pytest.raises(JointNotFound, match="panda_joint9"):
        scene.with_model_error(joints={"panda_joint9": 1e-3})
    with pytest.raises(ProblemError, match=r"panda_joint2.*must not be negative"):
        scene.with_model_error(joints={"panda_joint2": -1e-3})
    with pytest.raises(ShapeError, match="mounting"):
        scene.with_model_error(mounting=1e-3)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ShapeError, match="payload"):
        scene.with_model_error(payload=float("nan"))


def lifting(above: float) -> to.Problem:
    """A part in the hand is lifted off a table, with its bottom a distance above it at the start [m]."""
    robot = to.load("panda")
    here = robot.positions("ready")
    scene = to.Scene(robot).add(
        "part",
        to.Box(0.04, 0.04, 0.06),
        to.placement((0.0, 0.0, 0.12)),
        frame="panda_hand",
        touch_links=["panda_hand", "panda_leftfinger", "panda_rightfinger"],
    )
    hand, part = scene.placement_of("panda_hand", here), scene.placement_of("part", here)
    x, y, z = part.translation
    scene = scene.add("table", to.Box(0.4, 0.4, 0.1), to.placement((x, y, z - 0.03 - above - 0.05)))
    scene = scene.allow_contact("the part is on the table", "part", "table", depth=1e-3, first=0.25)
    up = to.Placement(hand.rotation, hand.translation + np.array((0.0, 0.0, 0.15)))
    goal = to.frame_placement("panda_hand", up)
    return to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal)


def test_a_part_on_a_table_is_lifted_although_the_model_is_wrong() -> None:
    problem = lifting(0.0)
    scene = problem.scene.with_model_error(joints=ANGLE, mounting=(1e-3, ANGLE))
    plan = to.plan(replace(problem, scene=scene))
    assert plan.verified, plan.reason
    [contact] = [check for check in plan.certificate.checks if check.name.startswith("contact")]
    assert contact.value == pytest.approx(0.0, abs=1e-4) and contact.bound == 1e-3
    reduced = replace(problem, scene=scene).reduced
    late = plan.trajectory(np.linspace(0.25, plan.trajectory.duration, 20))
    for positions in late:  # clear of the table by more than the error
        apart = distances(
            scene, problem, reduced.all_positions(positions), np.zeros(len(scene.robot.joint_names))
        )
        assert apart.min() > 0.0


def test_the_depth_of_a_contact_is_that_of_the_described_robot() -> None:
    problem = lifting(-3e-3)
    scene = problem.scene.with_model_error(joints=ANGLE, mounting=(1e-3, ANGLE))
    plan = to.plan(replace(problem, scene=scene))
    assert plan.status is to.Status.START_IN_COLLISION
