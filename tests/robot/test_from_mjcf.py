"""Robots of MuJoCo's own files: the same kinematics, shapes, limits and pairs; notes on what is left out."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import trajopt as to
from trajopt.robot.joints import draw_positions
from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.robot.loading.pinocchio_model import link_placement
from trajopt.values.errors import FileFormatError, ModelError, UnsupportedJoint
from trajopt.values.shapes.shapes import Box, Capsule, Convex, Cylinder, Plane, Sphere

ARM = """<mujoco model="bench">
  <compiler angle="degree" autolimits="true"/>
  <asset><mesh name="tetra" file="tetra.obj"/></asset>
  <default><default class="seen"><geom contype="0" conaffinity="0"/></default></default>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -0.2"/>
    <geom name="table" type="box" size="0.1 0.2 0.3" pos="1 0 0"/>
    <body name="base" pos="0.1 0 0" euler="0 0 30">
      <geom name="pillar" type="cylinder" size="0.05 0.1"/>
      <body name="upper" pos="0 0 0.1">
        <inertial pos="0.1 0 0.2" mass="2" diaginertia="0.02 0.03 0.04" quat="0.9 0.1 0.2 0.3"/>
        <joint name="shoulder" axis="0 1 0" range="-120 120" pos="0.02 0.01 0" ref="20"/>
        <geom name="limb" type="capsule" size="0.03 0.1" pos="0.15 0 0" euler="0 90 0"/>
        <geom name="skin" class="seen" type="sphere" size="0.2"/>
        <body name="fore" pos="0.3 0 0" euler="10 20 30">
          <joint name="reach" type="slide" axis="1 0 0.2" range="-0.1 0.2" ref="0.05"/>
          <joint name="roll" axis="1 0 0"/>
          <geom name="sleeve" type="box" size="0.1 0.02 0.02" pos="0.1 0 0" mass="0.5"/>
          <geom name="tetra" type="mesh" mesh="tetra" pos="0.1 0.1 0" euler="45 0 0"/>
          <body name="left" pos="0.2 0.02 0">
            <joint name="left" type="slide" axis="0 1 0" range="0 0.04"/>
            <geom type="ellipsoid" size="0.03 0.01 0.02"/>
          </body>
          <body name="right" pos="0.2 -0.02 0">
            <joint name="right" type="slide" axis="0 -1 0" range="0 0.04"/>
            <geom type="ellipsoid" size="0.01 0.01 0.01"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="base" body2="left"/></contact>
  <equality><joint name="both" joint1="right" joint2="left" polycoef="0 1 0 0 0"/></equality>
  <actuator>
    <motor joint="shoulder" forcerange="-40 50" gear="2"/><motor joint="roll" ctrlrange="-3 3" gear="-4"/>
    <position joint="reach" kp="100"/><motor joint="left" gear="1"/>
  </actuator>
  <keyframe><key name="home" qpos="0.3 0.1 -0.2 0.01 0.01"/></keyframe>
</mujoco>"""

TETRAHEDRON = """v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 0.1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


def written(folder: Path, text: str = ARM) -> Path:
    """Write a model, and the mesh that it names."""
    (folder / "tetra.obj").write_text(TETRAHEDRON)
    (folder / "bench.xml").write_text(text)
    return folder / "bench.xml"


def compiled(file: Path) -> Any:
    """Return MuJoCo's model of a file; its warnings go nowhere."""
    engine: Any = mujoco
    engine.set_mju_user_warning(lambda _: None)
    try:
        return engine.MjModel.from_xml_path(str(file))
    finally:
        engine.set_mju_user_warning(None)


def poses(model: Any, robot: to.Robot, positions: Sequence[float]) -> dict[str, tuple[Any, Any]]:
    """Return where MuJoCo has the bodies of a model: rotation and position."""
    engine: Any = mujoco
    data = engine.MjData(model)
    for joint, value in zip(robot.joint_names, positions, strict=True):
        data.joint(joint).qpos[:] = value
    engine.mj_kinematics(model, data)
    return {
        model.body(body).name or f"body_{body}": (data.xmat[body].reshape(3, 3), data.xpos[body])
        for body in range(1, model.nbody)
    }


def assert_same_kinematics(file: Path, robot: to.Robot) -> None:
    model = compiled(file)
    for drawn in draw_positions(robot.limits, 20, rng=np.random.default_rng(0)):
        positions = robot.followed(drawn)
        for body, (rotation, position) in poses(model, robot, positions.tolist()).items():
            found = link_placement(robot.model, body, positions)
            np.testing.assert_allclose(found.rotation, rotation, atol=1e-9)
            np.testing.assert_allclose(found.translation, position, atol=1e-9)


def test_bodies_are_where_mujoco_has_them(tmp_path: Path) -> None:
    file = written(tmp_path)
    robot = to.Robot.from_mjcf(file)
    assert robot.name == "bench" and robot.joint_names == ("shoulder", "reach", "roll", "left", "right")
    assert_same_kinematics(file, robot)


def test_limits_groups_states_and_mimics(tmp_path: Path) -> None:
    robot = to.Robot.from_mjcf(written(tmp_path))
    assert robot.limits.lower[:2] == pytest.approx((-np.deg2rad(120), -0.1))
    assert np.isinf(robot.limits.upper[2])
    assert robot.limits.effort.tolist() == [100.0, np.inf, 12.0, np.inf, np.inf]
    assert robot.group("all").joints == ("shoulder", "reach", "roll", "left")
    assert (robot.mimics["right"].source, robot.mimics["right"].multiplier) == ("left", 1.0)
    assert robot.positions("home") == pytest.approx((0.3, 0.1, -0.2, 0.01, 0.01))
    assert any(note.startswith("no effort limit") and "reach, left" in note for note in robot.notes)


def test_masses_and_moments_are_the_same(tmp_path: Path) -> None:
    file = written(tmp_path)
    robot = to.Robot.from_mjcf(file)
    engine: Any = mujoco
    model = compiled(file)
    data = engine.MjData(model)
    for drawn in draw_positions(robot.limits, 10, rng=np.random.default_rng(3)):
        positions = robot.followed(drawn)
        data.qpos[:] = positions
        data.qvel[:] = data.qacc[:] = 0.0
        engine.mj_inverse(model, data)
        still = np.zeros(robot.model.nv)
        found = pin.rnea(robot.model, robot.model.createData(), robot.configuration(positions), still, still)
        np.testing.assert_allclose(found, data.qfrc_bias, atol=1e-9)


def test_colliding_and_visual_geoms_are_separated(tmp_path: Path) -> None:
    robot = to.Robot.from_mjcf(written(tmp_path))
    shapes = {body.owner: type(body.shape) for body in robot.bodies}
    assert shapes["world/floor"] is Plane and shapes["base"] is Cylinder and shapes["upper"] is Capsule
    assert shapes["left"] is shapes["right"] is Convex
    table = next(body for body in robot.bodies if body.owner == "world/table")
    assert table.shape == Box(0.2, 0.4, 0.6) and robot.frame("world/table").link == "world/table"
    assert [type(body.shape) for body in robot.bodies if body.owner == "fore"] == [Box, Convex]
    seen = {visual.link: visual.geometry for visual in robot.visuals}
    assert seen["upper"] == Sphere(0.2) and isinstance(seen["base"], Cylinder)
    hull = next(body.shape for body in robot.bodies if body.owner == "left")
    assert isinstance(hull, Convex)
    radii = np.array((0.03, 0.01, 0.02))
    assert (np.linalg.norm(hull.vertices / radii, axis=1) <= 1.03).all()
    directions = np.random.default_rng(0).normal(size=(200, 3))
    inside = directions / np.linalg.norm(directions, axis=1, keepdims=True) * radii
    corners = hull.vertices[hull.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((inside @ normals.T) <= np.einsum("ij,ij->i", normals, corners[:, 0]) + 1e-12).all()


def test_pairs_that_mujoco_does_not_check_may_touch(tmp_path: Path) -> None:
    scene = to.Scene(to.Robot.from_mjcf(written(tmp_path)))
    assert scene.may_touch("upper", "fore") and scene.may_touch("base", "left")
    assert scene.may_touch("base", "upper") and not scene.may_touch("upper", "left")
    assert not scene.may_touch("base", "right")
    assert not scene.may_touch("left", "right") and not scene.may_touch("world/table", "upper")


def test_bits_of_contact_decide_which_pairs_are_checked(tmp_path: Path) -> None:
    text = ARM.replace('name="limb"', 'name="limb" contype="2" conaffinity="4"')
    text = text.replace('name="table"', 'name="table" contype="4" conaffinity="1"')
    scene = to.Scene(to.Robot.from_mjcf(written(tmp_path, text)))
    assert not scene.may_touch("world/table", "upper") and scene.may_touch("world/floor", "upper")


def test_load_takes_a_file_of_mujocos_too_and_a_motion_is_planned(tmp_path: Path) -> None:
    robot = to.load(written(tmp_path), torque_scaling=2.0)
    assert robot.limits.effort[0] == 200.0
    problem = to.Problem(
        scene=to.Scene(robot), start={}, goal=to.joint_positions({"shoulder": -0.5, "roll": 4.0})
    )
    assert to.plan(problem).require()
    with pytest.raises(ModelError, match="MJCF"):
        to.load(tmp_path / "bench.xml", package_dirs=[tmp_path])


def test_free_bodies_stand_still_and_balls_are_refused(tmp_path: Path) -> None:
    free = ARM.replace('<geom name="pillar"', '<freejoint name="root"/><geom name="pillar"')
    robot = to.Robot.from_mjcf(written(tmp_path, free.replace('qpos="', 'qpos="0 0 0 1 0 0 0 ')))
    assert robot.joint_names == ("shoulder", "reach", "roll", "left", "right")
    assert "joint 'root' is free: base is fixed in its place" in robot.notes
    with pytest.raises(UnsupportedJoint, match="'roll' is of type 'ball'"):
        ball = ARM.replace('<joint name="roll" axis="1 0 0"/>', '<joint name="roll" type="ball"/>')
        ball = ball[: ball.index("<equality>")] + "</mujoco>"
        to.Robot.from_mjcf(written(tmp_path, ball))


def test_omitted_parts_are_noted(tmp_path: Path) -> None:
    text = ARM
    for old, new in (
        ("<equality>", '<equality><connect name="loop" body1="left" body2="right" anchor="0 0 0"/>'),
        ('<position joint="reach" kp="100"/>', ""),
        ('axis="1 0 0"/>', 'axis="1 0 0" damping="1"/>'),
        ('axis="1 0 0.2" range="-0.1 0.2"', 'axis="1 0 0.2"'),
        ("<worldbody>", '<option gravity="0 0 -1.62"/><worldbody>'),
    ):
        assert old in text
        text = text.replace(old, new)
    robot = to.Robot.from_mjcf(written(tmp_path, text))
    said = "\n".join(robot.notes)
    assert "slide 'reach' has no range: [-100, 100] m is taken" in said
    assert "equality constraints are not kept, loops among them: loop" in said
    assert "no actuator moves these joints, and no group does: reach" in said
    assert "damping of joints do not count in torques" in said
    assert "gravity is taken as (0.0, 0.0, -9.81) m/s^2; the file has [0.0, 0.0, -1.62]" in said
    assert robot.passive_joints == {"reach"} and "reach" not in robot.group("all").joints


@pytest.mark.parametrize(
    "text",
    [
        "<mujoco><worldbody><geom type='box' size='1 1 1'/></worldbody></mujoco>",
        "<mujoco><oops/></mujoco>",
        "<x",
    ],
)
def test_files_that_hold_no_robot(tmp_path: Path, text: str) -> None:
    (tmp_path / "none.xml").write_text(text)
    with pytest.raises(FileFormatError, match=r"none\.xml"):
        to.Robot.from_mjcf(tmp_path / "none.xml")


def test_an_sdf_file_names_the_way_to_a_urdf(tmp_path: Path) -> None:
    (tmp_path / "robot.sdf").write_text("<sdf version='1.9'><model name='m'/></sdf>")
    with pytest.raises(FileFormatError, match=r"SDF.*URDF.*sdformat-mjcf; sdf2mjcf robot\.sdf robot\.xml"):
        to.load(tmp_path / "robot.sdf")


numbers = st.floats(-1.0, 1.0).map(lambda value: round(value, 3))
triples = st.tuples(numbers, numbers, numbers)
axes = triples.filter(lambda axis: float(np.linalg.norm(axis)) > 0.1)
joints = st.tuples(st.sampled_from(("hinge", "slide")), axes, triples, numbers, st.booleans())
bodies = st.tuples(triples, triples, st.lists(joints, max_size=3), st.integers(0, 3))


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(bodies, min_size=1, max_size=6).filter(lambda tree: any(body[2] for body in tree)))
def test_random_trees_are_where_mujoco_has_them(tmp_path: Path, tree: list[Any]) -> None:
    def text_of(values: Sequence[float]) -> str:
        return " ".join(map(repr, values))

    parts = [f'<body name="b{place}"/>' for place in range(len(tree))]
    inside: dict[int, str] = dict.fromkeys(range(-1, len(tree)), "")
    for place in reversed(range(len(tree))):
        position, angles, hung, back = tree[place]
        text = "".join(
            f'<joint name="j{place}_{number}" type="{kind}" axis="{text_of(axis)}" pos="{text_of(anchor)}" '
            f'ref="{ref}"' + (' range="-2 2"/>' if limited else "/>")
            for number, (kind, axis, anchor, ref, limited) in enumerate(hung)
        )
        parts[place] = (
            f'<body name="b{place}" pos="{text_of(position)}" euler="{text_of(angles)}">{text}'
            f'<geom type="sphere" size="0.1"/>{inside[place]}</body>'
        )
        inside[max(place - 1 - back, -1)] = parts[place] + inside[max(place - 1 - back, -1)]
    file = tmp_path / "tree.xml"
    file.write_text(
        f'<mujoco><compiler angle="radian" autolimits="true"/><worldbody>{inside[-1]}</worldbody></mujoco>'
    )
    robot = to.Robot.from_mjcf(file)
    assert len(robot.joint_names) == sum(len(body[2]) for body in tree)
    assert_same_kinematics(file, robot)


def test_warnings_of_mujoco_are_notes_and_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two joints of one axis in one place: the inertia is singular, which MuJoCo warns of."""
    (tmp_path / "twice.xml").write_text(
        "<mujoco><worldbody><body><joint name='a' axis='1 0 0'/><joint name='b' axis='1 0 0'/>"
        "<geom size='0.1'/></body></worldbody></mujoco>"
    )
    monkeypatch.chdir(tmp_path)
    robot = to.Robot.from_mjcf(tmp_path / "twice.xml")
    assert any(
        note.startswith("MuJoCo warns: Inertia matrix is too close to singular") for note in robot.notes
    )
    assert list(tmp_path.iterdir()) == [tmp_path / "twice.xml"]
