"""A gripper of which the two fingers are joints of their own, without a mimic: one drive moves both."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.tasks.grasping import Gripper, Place, grasps_of, gripper_of, pick_and_place
from trajopt.tasks.grasping.simulation import Hold, simulate_handling


def link(name: str, mass: float, size: str, at: str) -> str:
    inertia = '<inertia ixx="0.002" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/>'
    box = f'<collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision>'
    return f'<link name="{name}"><inertial><mass value="{mass}"/>{inertia}</inertial>{box}</link>'


def slide(name: str, parent: str, child: str, at: str, axis: str, ends: tuple[float, float]) -> str:
    return (
        f'<joint name="{name}" type="prismatic"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/>'
        f'<limit lower="{ends[0]}" upper="{ends[1]}" velocity="1" effort="400"/></joint>'
    )


SRDF = """<robot name="gantry">
  <group name="arm"><joint name="x"/><joint name="y"/><joint name="z"/></group>
  <group name="hand">
    <link name="palm"/><link name="left"/><link name="right"/><link name="tcp"/>
    <joint name="left_slide"/><joint name="right_slide"/>
  </group>
  <end_effector name="hand" parent_link="carrier" group="hand" parent_group="arm"/>
  <disable_collisions link1="left" link2="right" reason="Never"/>
  <disable_collisions link1="base" link2="bridge" reason="Never"/>
</robot>"""


@pytest.fixture(scope="module")
def gantry(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return with_palm(tmp_path_factory.mktemp("gantry"), 0.04)


def with_palm(folder: Path, height: float) -> to.Robot:
    """Return a hand that points down on three slides, with fingers that close along y."""
    parts = (
        link("base", 10.0, "0.1 0.1 0.1", "0 0 1.5"),
        slide("x", "base", "bridge", "0 0 1.2", "1 0 0", (-0.6, 0.6))
        + link("bridge", 5.0, "0.05 0.05 0.05", "0 0 0"),
        slide("y", "bridge", "beam", "0 0 -0.1", "0 1 0", (-0.6, 0.6))
        + link("beam", 2.0, "0.05 0.05 0.05", "0 0 0"),
        slide("z", "beam", "carrier", "0 0 -0.3", "0 0 1", (-0.8, 0.1))
        + link("palm", 1.0, f"0.06 0.14 {height}", "0 0 0"),
        slide("left_slide", "palm", "left", "0 0 -0.05", "0 1 0", (0.0, 0.05))
        + link("left", 0.05, "0.02 0.01 0.06", "0 0.005 0"),
        slide("right_slide", "palm", "right", "0 0 -0.05", "0 -1 0", (0.0, 0.05))
        + link("right", 0.05, "0.02 0.01 0.06", "0 -0.005 0"),
    )
    mount = '<joint name="mount" type="fixed"><parent link="carrier"/><child link="palm"/></joint>'
    tip = '<joint name="tip" type="fixed"><parent link="palm"/><child link="tcp"/>'
    tip += '<origin xyz="0 0 -0.06" rpy="3.141592653589793 0 0"/></joint><link name="tcp"/>'
    (folder / "gantry.urdf").write_text(
        f'<robot name="gantry">{"".join(parts)}{mount}{tip}<link name="carrier"/></robot>'
    )
    (folder / "gantry.srdf").write_text(SRDF)
    return to.load(folder / "gantry.urdf", srdf=folder / "gantry.srdf")


@pytest.fixture(scope="module")
def gripper(gantry: to.Robot) -> Gripper:
    return gripper_of(gantry)


def test_fingers_in_proportion_are_driven_together(gantry: to.Robot, gripper: Gripper) -> None:
    together = gripper.driven_together(gantry, np.zeros(5))
    assert together == {"right_slide": ("left_slide", pytest.approx(1.0), pytest.approx(0.0, abs=1e-9))}
    askew = gantry.positions({"left_slide": 0.02})
    assert gripper.driven_together(gantry, askew) == {}


def test_the_hand_ends_how_deep_an_object_is_taken(gantry: to.Robot, tmp_path: Path) -> None:
    """The pads' centres are 60 mm below the middle of the palm: 20 or 50 mm below its end."""
    for height, expected in ((0.08, 0.017), (0.02, 0.0425)):
        hand = gripper_of(with_palm(tmp_path, height))
        assert hand.reach == pytest.approx(expected)
        scene = to.Scene(gantry).add("cup", to.Cylinder(0.02, 0.1))
        over = {0.05 - abs(float(grasp.placement.translation[2])) for grasp in grasps_of(scene, "cup", hand)}
        assert min(over) == pytest.approx(expected)


def test_the_object_stays_between_them_on_the_way(gantry: to.Robot, gripper: Gripper) -> None:
    cup = to.Cylinder(0.02, 0.1)
    scene = to.Scene(gantry).add("floor", to.Box(2, 2, 0.02), to.placement((0, 0, -0.01)))
    scene = scene.add("cup", cup, to.placement((0.2, -0.4, 0.05)), mass=0.3)
    carried = pick_and_place(
        scene,
        "cup",
        group="arm",
        start={},
        grasps=grasps_of(scene, "cup", gripper),
        places=Place(placement=to.placement((0.2, 0.4, 0.05))),
    )
    assert carried.verified, str(carried.explain())
    seen = simulate_handling(carried)
    assert seen.hold is Hold.HELD and seen.shift.position < 2e-3, seen.summary()
