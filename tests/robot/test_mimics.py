"""Mimic joints: chains, circles, joints that do not move, and a judge that sees where links really are."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.robots_for_tests import ODD_ARM
from tests.verify.arms import link, quintic, reduced
from trajopt.optimise.kinematics import forward_kinematics
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.errors import MimicContradiction, MimicCycle
from trajopt.values.placement import placement
from trajopt.values.shapes.shapes import Sphere
from trajopt.verify import verify
from trajopt.verify.kernel.kinematics import Kinematics

Stated = Mapping[str, tuple[str, float, float]]
"""Mimic joint -> the joint that it states, multiplier, offset."""


def planar(
    folder: Path,
    stated: Stated,
    *,
    limits: Mapping[str, str] | None = None,
    kinds: Mapping[str, str] | None = None,
    names: tuple[str, ...] = ("j1", "m1", "m2"),
) -> to.Robot:
    """Rods of 0.3 m in the plane z = 0, one after the other; what is stated mimics.

    Args:
        folder: To write to.
        stated: What mimics what.
        limits: Joint -> attributes of its <limit>.
        kinds: Joint -> its type; revolute unless told.
        names: Joints from the base on.
    """
    text = link("l0")
    for place, name in enumerate(names):
        follows = ""
        if name in stated:
            source, multiplier, offset = stated[name]
            follows = f'<mimic joint="{source}" multiplier="{multiplier!r}" offset="{offset!r}"/>'
        limit = (limits or {}).get(name, 'lower="-3" upper="3" velocity="20" effort="500"')
        kind = (kinds or {}).get(name, "revolute")
        text += link(f"l{place + 1}", length=0.3)
        text += (
            f'<joint name="{name}" type="{kind}"><parent link="l{place}"/><child link="l{place + 1}"/>'
            f'<origin xyz="{0.3 if place else 0.0} 0 0"/><axis xyz="0 0 1"/><limit {limit}/>{follows}</joint>'
        )
    path = folder / "planar.urdf"
    path.write_text(f'<robot name="planar">{text}</robot>')
    return to.Robot.from_urdf(path)


CHAIN: Stated = {"m1": ("j1", 1.0, 0.0), "m2": ("m1", 1.0, 0.0)}


def elbows(angles: Floats) -> Floats:
    """Where each rod of the planar chain ends, by trigonometry, (k,) -> (k, 2)."""
    turned = np.cumsum(angles)
    return np.cumsum(0.3 * np.stack((np.cos(turned), np.sin(turned)), axis=1), axis=0)


def with_ball(robot: to.Robot, at: Floats) -> to.Scene:
    """A ball of 40 mm in the plane of the rods."""
    return to.Scene(robot).add("ball", Sphere(0.02), placement((*at.tolist(), 0.0)))


def test_a_mimic_of_a_mimic_moves_and_the_judge_sees_it_collide(tmp_path: Path) -> None:
    robot = planar(tmp_path, CHAIN)
    assert robot.groups["all"].joints == ("j1",)
    middle = elbows(np.full(3, 0.25))
    # In the middle of the motion the last rod lies across the ball; it would not if m2 stood still.
    ball = 0.5 * (middle[1] + middle[2])
    still = elbows(np.array((0.25, 0.25, 0.0)))
    assert np.linalg.norm(0.5 * (still[1] + still[2]) - ball) > 0.03
    scene = with_ball(robot, ball)
    model = reduced(scene, [0.0])
    certificate = verify(model, quintic(model, [[0.0], [0.5]], 1.0), goals=())
    assert not certificate.verified
    assert any("l3" in check.subject and not check.holds for check in certificate.checks)
    assert model.all_positions(np.array((0.5,))) == pytest.approx((0.5, 0.5, 0.5))


def test_a_plan_that_sweeps_the_last_link_through_the_obstacle_is_not_a_success(
    tmp_path: Path,
) -> None:
    robot = planar(tmp_path, CHAIN)
    middle = elbows(np.full(3, 0.25))
    ball = 0.5 * (middle[1] + middle[2])
    scene = with_ball(robot, ball)
    result = to.plan(to.Problem(scene=scene, start={"j1": 0.0}, goal=to.joint_positions({"j1": 0.5})))
    assert result.status is not to.Status.SOLVED, "one joint leads all three, and the ball lies in the way"


@pytest.mark.parametrize(
    ("stated", "named"),
    [
        ({"m1": ("m1", 1.0, 0.0)}, ("m1",)),
        ({"m1": ("m2", 1.0, 0.0), "m2": ("m1", 1.0, 0.0)}, ("m1", "m2")),
        ({"j1": ("m2", 2.0, 0.0), "m1": ("j1", 1.0, 0.0), "m2": ("m1", 1.0, 0.1)}, ("j1", "m2", "m1")),
    ],
)
def test_a_circle_is_refused_with_its_joints(tmp_path: Path, stated: Stated, named: tuple[str, ...]) -> None:
    with pytest.raises(MimicCycle) as caught:
        planar(tmp_path, stated)
    assert caught.value.joints == named
    assert all(joint in str(caught.value) for joint in named)


def test_a_joint_that_mimics_an_unknown_joint_moves_freely_and_is_noted(tmp_path: Path) -> None:
    robot = planar(tmp_path, {"m1": ("j2", 1.0, 0.0), "m2": ("m1", 2.0, 0.0)})
    assert robot.groups["all"].joints == ("j1", "m1")
    assert robot.positions({"m1": 0.2}) == pytest.approx((0.0, 0.2, 0.4))
    assert robot.notes == ("joints that mimic a missing joint move on their own: m1 ('j2')",)


def test_a_mimic_of_a_fixed_joint_is_at_its_offset(tmp_path: Path) -> None:
    robot = planar(
        tmp_path, {"m1": ("j1", 3.0, 0.4), "m2": ("m1", -2.0, 0.1)}, kinds={"j1": "fixed"}, names=NAMES
    )
    assert robot.groups["all"].joints == ("free",)
    assert robot.positions({"free": 1.0}) == pytest.approx((0.4, -0.7, 1.0))


def test_a_fixed_mimic_joint_does_not_move(tmp_path: Path) -> None:
    robot = planar(tmp_path, {"m1": ("j1", 3.0, 0.4), "m2": ("m1", -2.0, 0.1)}, kinds={"m1": "fixed"})
    assert robot.positions({"j1": 1.0}) == pytest.approx((1.0, 0.1))


NAMES = ("j1", "m1", "m2", "free")


def grouped(folder: Path, robot: Callable[[Path], to.Robot], joints: tuple[str, ...]) -> to.Robot:
    """The robot in that folder with one group of some joints."""
    robot(folder)
    members = "".join(f'<joint name="{name}"/>' for name in joints)
    srdf = folder / "planar.srdf"
    srdf.write_text(f'<robot name="planar"><group name="some">{members}</group></robot>')
    return to.Robot.from_urdf(folder / "planar.urdf", srdf=srdf)


def test_a_mimic_joint_of_the_group_follows_a_leader_outside_it(tmp_path: Path) -> None:
    stated: Stated = {"m1": ("j1", -0.5, 0.2), "m2": ("m1", 2.0, 0.0)}
    robot = grouped(tmp_path, lambda folder: planar(folder, stated, names=NAMES), ("m1", "m2", "free"))
    assert robot.group("some").joints == ("free",)
    model = reduce_model(to.Scene(robot), "some", robot.positions({"j1": 0.8}))
    assert model.all_positions(np.array((0.3,))) == pytest.approx((0.8, -0.2, -0.4, 0.3))
    # Positions of all joints may come from sensors; where a mimic joint follows is what counts.
    measured = reduce_model(to.Scene(robot), "some", np.array((0.8, -0.199, -0.41, 0.0)))
    assert measured.all_positions(np.array((0.3,))) == pytest.approx((0.8, -0.2, -0.4, 0.3))


def test_a_mimic_joint_is_put_nowhere_but_where_it_follows(tmp_path: Path) -> None:
    robot = planar(tmp_path, CHAIN)
    goal = to.joint_positions({"j1": 0.0})
    problem = to.Problem(scene=to.Scene(robot), start={"j1": 0.5, "m2": 0.505}, goal=goal)
    assert problem.start_positions == pytest.approx((0.5, 0.5, 0.5)), "a sensor may err"
    with pytest.raises(MimicContradiction, match=r"m2 is put at 0\.3, but it follows j1 to 0\.5"):
        to.Problem(scene=to.Scene(robot), start={"j1": 0.5, "m2": 0.3}, goal=goal)
    with pytest.raises(MimicContradiction, match="m1"):
        to.Problem(
            scene=to.Scene(robot), start=np.array((0.5, 0.0, 0.5)), goal=to.joint_positions({"j1": 0.0})
        )


@settings(deadline=None, max_examples=40)
@given(data=st.data())
def test_forward_kinematics_of_random_chains(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    count = data.draw(st.integers(2, 6))
    names = tuple(f"q{place}" for place in range(count))
    numbers = st.floats(-2.0, 2.0).map(lambda x: round(x, 3))
    order = data.draw(st.permutations(names))
    # A joint may mimic any joint before it in a random order, which may be farther out in the tree.
    stated: dict[str, tuple[str, float, float]] = {}
    for place, name in enumerate(order[1:], start=1):
        if data.draw(st.booleans()):
            stated[name] = (data.draw(st.sampled_from(order[:place])), data.draw(numbers), data.draw(numbers))
    kinds = {name: data.draw(st.sampled_from(("revolute", "continuous"))) for name in names}
    limits = dict.fromkeys(names, 'lower="-1e4" upper="1e4" velocity="20" effort="500"')
    folder = tmp_path_factory.mktemp("chain")
    robot = planar(folder, stated, names=names, kinds=kinds, limits=limits)
    free = tuple(name for name in names if name not in stated)
    assert robot.groups["all"].joints == free
    chosen = {name: data.draw(numbers) for name in free}

    def angle(name: str) -> float:
        if name in chosen:
            return chosen[name]
        source, multiplier, offset = stated[name]
        return multiplier * angle(source) + offset

    expected = elbows(np.array([angle(name) for name in names]))
    model = reduce_model(to.Scene(robot), "all", robot.positions(chosen))
    group = np.array([[chosen[name] for name in free]])
    poses = Kinematics(model).poses(group)
    for rod in range(1, count + 1):
        (tip,) = forward_kinematics(model, f"l{rod}", group, offset=(0.3, 0.0, 0.0))
        assert tip.translation[:2] == pytest.approx(expected[rod - 1], abs=1e-12)
        joint, place = model.attachment(f"l{rod}")
        at = place * np.array((0.3, 0.0, 0.0))
        judged = poses.rotation[0, joint] @ at + poses.translation[0, joint]
        assert judged[:2] == pytest.approx(expected[rod - 1], abs=1e-12)


def test_a_group_of_joints_has_their_links(tmp_path: Path) -> None:
    """Also those of mimic joints, as fingers that may touch what their hand holds."""
    (tmp_path / "odd.urdf").write_text(ODD_ARM)
    (tmp_path / "odd.srdf").write_text(
        '<robot name="odd"><group name="end"><joint name="wrist"/><joint name="follow"/></group></robot>'
    )
    group = to.load(tmp_path / "odd.urdf", srdf=tmp_path / "odd.srdf").group("end")
    assert (group.joints, group.links) == (("wrist",), ("tip", "finger"))
