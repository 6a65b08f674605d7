"""Bases that move: joints of one number each in the place of planar, floating and no joints."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import Guard, IdealExecutor, Servo
from trajopt.robot.bases import MovingBase, planar_base, rail
from trajopt.values.errors import GroupNotFound, JointNotFound, ModelError, ProblemError, ShapeError

LIMIT = '<limit lower="-2" upper="2" effort="50" velocity="2"/>'
LINKS = """
  <link name="plate"><inertial><origin xyz="0 0 0.15"/><mass value="20"/><inertia ixx="0.4" iyy="0.5" izz="0.8" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.15"/><geometry><box size="0.5 0.4 0.2"/></geometry></collision></link>
  <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.06 0.06"/></geometry></collision></link>
  <link name="fore"><inertial><origin xyz="0.2 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.06 0.06"/></geometry></collision></link>
  <link name="tool"/>
  <joint name="flange" type="fixed"><parent link="fore"/><child link="tool"/><origin xyz="0.4 0 0"/></joint>
"""  # noqa: E501
ARM = f"""
  <joint name="shoulder" type="revolute"><parent link="plate"/><child link="upper"/><origin xyz="0.1 0 0.4"/>
    <axis xyz="0 0 1"/>{LIMIT}</joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/>
    <axis xyz="0 0 1"/>{LIMIT}</joint>
"""
SRDF = """<robot name="cart">
  <virtual_joint name="odom_joint" type="planar" parent_frame="odom" child_link="plate"/>
  <passive_joint name="odom_joint"/>
  <group name="base"><joint name="odom_joint"/></group>
  <group name="arm"><chain base_link="plate" tip_link="tool"/></group>
  <group name="all_of_it"><group name="base"/><group name="arm"/></group>
  <group_state name="dock" group="base"><joint name="odom_joint" value="1 2 0.5"/></group_state>
</robot>"""
NAMES = ("odom_joint/x", "odom_joint/y", "odom_joint/theta")
ARM_SRDF = '<robot name="cart"><group name="arm"><chain base_link="plate" tip_link="tool"/></group></robot>'

Made = Callable[..., to.Robot]


def plane(**changes: Any) -> MovingBase:
    return planar_base(
        **{"lower": (-3, -2), "upper": (3, 2), "velocity": (0.8, 1.2), "acceleration": (1, 2)} | changes
    )


@pytest.fixture
def cart(tmp_path: Path) -> Made:
    """Write and load a cart with an arm of two joints in the plane."""

    def make(more: str = "", srdf: str = SRDF, limits: str = "", **options: Any) -> to.Robot:
        (tmp_path / "cart.urdf").write_text(f'<robot name="cart">{LINKS}{ARM}{more}</robot>')
        (tmp_path / "cart.srdf").write_text(srdf)
        (tmp_path / "limits.yaml").write_text(limits)
        files = {"srdf": tmp_path / "cart.srdf"} if srdf else {}
        files |= {"limits": tmp_path / "limits.yaml"} if limits else {}
        return to.load(tmp_path / "cart.urdf", **files, **options)

    return make


def of(robot: to.Robot, name: str) -> dict[str, float]:
    limits, place = robot.limits, robot.joint_names.index(name)
    kinds = ("lower", "upper", "velocity", "acceleration", "effort")
    return {kind: float(getattr(limits, kind)[place]) for kind in kinds}


def test_a_planar_virtual_joint_becomes_three_joints(cart: Made) -> None:
    robot = cart(base=plane())
    assert robot.joint_names == (*NAMES, "shoulder", "elbow")
    assert robot.base.joints == NAMES and robot.base.frame == "odom" == robot.links[0]
    assert robot.group("base").joints == NAMES, "although the file calls it passive"
    assert robot.group("all_of_it").joints == robot.joint_names
    assert robot.group("arm").joints == ("shoulder", "elbow")
    assert robot.state("dock") == dict(zip(NAMES, (1.0, 2.0, 0.5), strict=True))
    inf = np.inf
    assert of(robot, NAMES[0]) == dict(lower=-3, upper=3, velocity=0.8, acceleration=1.0, effort=inf)
    assert of(robot, NAMES[1]) == dict(lower=-2, upper=2, velocity=0.8, acceleration=1.0, effort=inf)
    assert of(robot, NAMES[2]) == dict(lower=-inf, upper=inf, velocity=1.2, acceleration=2.0, effort=inf)
    assert not any("odom_joint" in note for note in robot.limits.defaulted)
    where = to.Scene(robot).placement_of("tool", robot.positions({**robot.state("dock"), "elbow": np.pi / 2}))
    ahead, aside = 0.1 + 0.4, 0.4
    c, s = np.cos(0.5), np.sin(0.5)
    assert where.translation == pytest.approx([1 + c * ahead - s * aside, 2 + s * ahead + c * aside, 0.4])


def test_limits_of_a_file_win(cart: Made) -> None:
    robot = cart(base=plane(yaw=(-1, 2)), limits="joint_limits: {odom_joint/x: {max_velocity: 0.3}}")
    assert of(robot, NAMES[0])["velocity"] == 0.3 and of(robot, NAMES[0])["acceleration"] == 1.0
    assert (of(robot, NAMES[2])["lower"], of(robot, NAMES[2])["upper"]) == (-1.0, 2.0)


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_a_joint_of_the_urdf_is_fixed_and_noted_or_moves(cart: Made, kind: str) -> None:
    more = (
        '<link name="ground"/>'
        f'<joint name="ride" type="{kind}"><parent link="ground"/><child link="plate"/>'
        '<origin xyz="1 0 0.5" rpy="0 0 1.5707963267948966"/></joint>'
    )
    fixed = cart(more, srdf="")
    assert fixed.joint_names == ("shoulder", "elbow") and "ride" in fixed.fixed_joints
    (note,) = (note for note in fixed.notes if "'ride'" in note)
    assert f"the {kind} joint" in note and "planar_base" in note
    robot = cart(more, srdf="", base=plane())
    assert robot.joint_names[:3] == ("ride/x", "ride/y", "ride/theta")
    assert not any("'ride'" in note for note in robot.notes)
    moved = to.Scene(robot).placement_of("plate", robot.positions({"ride/x": 0.3}))
    assert moved.translation == pytest.approx([1.0, 0.3, 0.5]), "along x of the joint's own frame"
    with pytest.raises(JointNotFound, match="did you mean 'ride'"):
        cart(more, srdf="", base=plane(name="rode"))


def test_a_base_that_no_file_names(cart: Made) -> None:
    robot = cart(srdf="", base=plane())
    assert robot.joint_names[:3] == ("base/x", "base/y", "base/theta") and robot.links[0] == "world"
    assert robot.group("all").joints == robot.joint_names
    with pytest.raises(ModelError, match=r"no group of the SRDF.*arm"):
        cart(srdf=ARM_SRDF, base=plane())
    with pytest.raises(GroupNotFound, match="did you mean 'arm'"):
        cart(srdf=ARM_SRDF, base=plane(groups=("arn",)))
    robot = cart(srdf=ARM_SRDF, base=plane(groups=("arm",)))
    assert robot.group("arm").joints == robot.joint_names and robot.group("arm").tip == "tool"


def test_a_rail_under_a_robot(cart: Made) -> None:
    along = rail((0, 2, 0), -1, 1, velocity=0.5, acceleration=1, groups=("arm",))
    robot = cart(srdf=ARM_SRDF, base=along)
    assert robot.group("arm").joints == ("rail", "shoulder", "elbow") and robot.base.joints == ("rail",)
    assert of(robot, "rail") == dict(lower=-1, upper=1, velocity=0.5, acceleration=1.0, effort=np.inf)
    at = to.Scene(robot).placement_of("plate", robot.positions({"rail": 0.4}))
    assert at.translation == pytest.approx([0.0, 0.4, 0.0])


def test_a_root_link_named_world_stays_in_the_world(cart: Made) -> None:
    feet = '<joint name="feet" type="fixed"><parent link="world"/><child link="plate"/></joint>'
    srdf = ARM_SRDF.replace(
        "<group", '<virtual_joint name="v" type="fixed" parent_frame="world" child_link="world"/><group'
    )
    robot = cart(
        '<link name="world"/>' + feet,
        srdf=srdf,
        base=rail((1, 0, 0), 0, 2, velocity=1, acceleration=1, groups=("arm",)),
    )
    scene = to.Scene(robot).add("ball", to.Sphere(0.1), to.placement((0, 3, 0)))
    positions = robot.positions({"v": 1.5})
    assert scene.placement_of("ball", positions).translation == pytest.approx([0, 3, 0])
    assert scene.placement_of("world", positions).translation == pytest.approx([0, 0, 0])
    assert scene.placement_of("plate", positions).translation == pytest.approx([1.5, 0, 0])


@pytest.mark.parametrize(
    ("make", "error", "says"),
    [
        (lambda: plane(lower=(4, 0)), ModelError, "limits of x, 4 and 3"),
        (lambda: plane(yaw=(1, 0)), ModelError, "limits of theta"),
        (lambda: plane(velocity=(0, 1)), ProblemError, "velocity must be positive"),
        (lambda: plane(acceleration=1.0), ShapeError, "acceleration"),
        (lambda: rail((0, 0, 0), 0, 1, velocity=1, acceleration=1), ShapeError, "axis"),
        (lambda: rail((0, 0, 1), 1, 0, velocity=1, acceleration=1), ModelError, "the rail"),
        (lambda: plane(groups="arm"), ProblemError, "groups"),
    ],
)
def test_a_base_that_cannot_be(make: Callable[[], object], error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        make()


def test_a_name_that_is_taken(cart: Made) -> None:
    with pytest.raises(ModelError, match="has a joint 'elbow' already"):
        cart(srdf="", base=rail((1, 0, 0), 0, 1, velocity=1, acceleration=1, name="elbow"))


def test_base_and_arm_plan_together_and_are_simulated(cart: Made) -> None:
    """The goal is far out of the arm's reach, and a post stands in the straight way."""
    robot = cart(base=plane())
    scene = to.Scene(robot).add("post", to.Cylinder(0.2, 1.0), to.placement((1.6, 0.0, 0.5)))
    problem = to.Problem(
        scene=scene,
        group="all_of_it",
        start={},
        goal=to.frame_placement("tool", to.placement((3.2, 0.1, 0.4)), rotation_tolerance=0.1),
    )
    plan = to.plan(problem).require()
    assert plan.certificate.verified
    base = plan.trajectory.positions[:, :3]
    assert np.abs(base[-1, :2] - base[0, :2]).max() > 1.0
    run = to.simulate(plan)
    assert run.diverged is None and not run.collisions
    assert run.tracking_error.maximum.max() < 0.02


def test_wheels_are_not_pushed_sideways_by_many_short_motions(cart: Made) -> None:
    scene = to.Scene(cart(base=plane(drive=to.bases.Drive.DIFFERENTIAL)))
    names = scene.robot.group("all_of_it").joints
    arm = IdealExecutor(names, np.zeros(len(names)))
    problem = to.Problem(scene=scene, group="all_of_it", start={}, goal=dict.fromkeys(names, 0.0))
    for take_over in (lambda: Guard(scene, "all_of_it", arm), lambda: Servo(arm, problem)):
        with pytest.raises(ProblemError, match="group 'all_of_it' moves a base whose wheels roll"):
            take_over()
    Guard(scene, "arm", arm)


def test_a_group_without_joints_is_not_guarded(cart: Made) -> None:
    srdf = SRDF.replace("</robot>", '<group name="mount"><link name="tool"/></group></robot>')
    robot = cart(srdf=srdf, base=plane())
    arm = IdealExecutor(robot.joint_names, np.zeros(len(robot.joint_names)))
    with pytest.raises(ProblemError, match="group 'mount' has no joint to move"):
        Guard(to.Scene(robot), "mount", arm)
