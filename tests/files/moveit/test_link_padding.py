"""MoveIt's padding and scale of links in scenes."""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from tests.files.moveit.scenes import SPHERE, Read
from trajopt import Robot, placement
from trajopt.files.moveit import read_scene
from trajopt.robot.bodies import MeshPolicy
from trajopt.scene.reducing import reduce_model
from trajopt.values.shapes.shapes import Sphere, bounding_box
from trajopt.verify import examine


def test_padding_becomes_required_clearance_from_the_world(scene_of: Read) -> None:
    tool = f"{{link_name: hand, object: {{id: tool, header: {{frame_id: hand}}, {SPHERE}}}}}"
    file = scene_of(f"""
        world: {{collision_objects: [{{id: a, {SPHERE}}}]}}
        robot_state: {{attached_collision_objects: [{tool}]}}
        link_padding: [{{link_name: hand, padding: 0.05}}, {{link_name: fore, padding: 0.0}}]
    """)
    scene = file.scene.add("later", Sphere(0.1), placement((1.0, 0.0, 0.0)))
    for name in ("hand", "tool"):
        assert scene.clearance_of(name, "a") == scene.clearance_of("later", name) == 0.05
        assert scene.margin_of(name, "a") == pytest.approx(0.055)
        assert scene.clearance_of(name, "base") == 0.0
    assert scene.clearance_of("fore", "a") == scene.clearance_of("tool", "hand") == 0.0
    pinned = scene.with_clearance(0.02, "hand", "a")
    assert pinned.clearance_of("hand", "a") == 0.02 and pinned.clearance_of("hand", "later") == 0.05
    assert "single pairs differ" in repr(scene) and not file.notes
    reduced = reduce_model(pinned, group="arm", start=file.positions)
    for pair, required in enumerate(reduced.pairs.required):
        assert required == pinned.clearance_of(*reduced.owners(pair))
    assert {0.0, 0.02, 0.05} == set(reduced.pairs.required.tolist())


def test_the_judge_proves_padding(scene_of: Read) -> None:
    """The hand's sphere of a padding stands clear of a wall by a known distance."""
    text = """
        world: {{collision_objects: [{{id: wall, pose: {{position: [{x}, 0, 0.1]}},
          primitives: [{{type: box, dimensions: [0.2, 4, 4]}}]}}]}}
        link_padding: [{{link_name: hand, padding: 0.05}}]
    """
    first = scene_of(text.format(x=5.0))
    hand = first.scene.placement_of("hand", first.positions)
    farthest = max(
        (hand * (body.placement * corner))[0]
        for body in first.scene.robot.bodies
        if body.owner == "hand"
        for corner in product(*np.transpose(bounding_box(body.shape)))
    )
    for gap, near in ((0.049, True), (0.051, False)):
        file = scene_of(text.format(x=farthest + gap + 0.1))
        reduced = reduce_model(file.scene, group="arm", start=file.positions)
        seen = examine(reduced, reduced.start_positions)
        pairs = [item for item in seen.collisions if {item.first, item.second} == {"hand", "wall"}]
        assert [item.required for item in pairs] == [0.05] * near
        assert all("50 mm are required" in item.words for item in pairs)


SHAPES = """<robot name="r"><link name="base"/><link name="hand">
<collision><origin xyz="0.1 0 0"/><geometry><box size="0.1 0.2 0.3"/></geometry></collision>
<collision><geometry><sphere radius="0.1"/></geometry></collision>
<collision><geometry><cylinder radius="0.1" length="0.4"/></geometry></collision>
<collision><geometry><mesh filename="wedge.obj"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="hand"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="9" velocity="1"/></joint></robot>"""


WEDGE = ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.0, 0.4, 0.0), (0.0, 0.0, 0.8))


@pytest.mark.parametrize("exact", [False, True])
def test_link_scale_scales_the_shapes(tmp_path: Path, exact: bool) -> None:
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in WEDGE)
    (tmp_path / "wedge.obj").write_text(corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    (tmp_path / "r.urdf").write_text(SHAPES)
    robot = Robot.from_urdf(tmp_path / "r.urdf", meshes=MeshPolicy(exact=exact))
    (tmp_path / "scene.yaml").write_text("{link_scale: [{link_name: hand, scale: 1.5}]}")
    file = read_scene(tmp_path / "scene.yaml", robot)
    box, ball, can, wedge = file.scene.robot.bodies
    assert (box.shape.x, box.shape.y, box.shape.z) == pytest.approx((0.15, 0.3, 0.45))
    assert box.placement.translation[0] == 0.1
    assert ball.shape.radius == pytest.approx(0.15)
    assert (can.shape.radius, can.shape.length) == pytest.approx((0.15, 0.6))
    # About the mean of the vertices, (0.1, 0.1, 0.2): x runs from 0.1 - 1.5 * 0.1 to 0.1 + 1.5 * 0.3.
    lower, upper = wedge.shape.vertices.min(axis=0), wedge.shape.vertices.max(axis=0)
    assert lower == pytest.approx((-0.05, -0.05, -0.1), abs=1e-7)
    assert upper == pytest.approx((0.55, 0.55, 1.1), abs=1e-7)
    assert all(body.scale == 1.0 for body in robot.bodies)
    assert any("hand is scaled by 1.5" in note for note in file.notes)
    back = replace(file.scene.robot, bodies=tuple(body.scaled(1.0) for body in file.scene.robot.bodies))
    assert np.allclose(back.bodies[3].shape.vertices, robot.bodies[3].shape.vertices, atol=1e-12)
