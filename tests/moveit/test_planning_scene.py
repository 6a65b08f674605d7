"""Planning scene files, feature by feature."""

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from trajopt import Placement, Robot, placement
from trajopt.errors import FileFormatError, FrameNotFound, ObjectNotFound
from trajopt.model.meshes.mesh_cover import MeshPolicy
from trajopt.model.reduced import reduce_model
from trajopt.model.shapes import Box, Cone, Cylinder, Plane, Sphere, bounding_box
from trajopt.moveit import SceneFile, read_scene
from trajopt.verify import examine

Read = Callable[[str], SceneFile]


def same(a: Placement, b: Placement) -> bool:
    return np.allclose(a.homogeneous, b.homogeneous, atol=1e-12)


def where(file: SceneFile, name: str) -> Placement:
    return file.scene.placement_of(name, file.positions)


def with_objects(objects: str) -> str:
    return f"world: {{collision_objects: [{objects}]}}"


SPHERE = "primitives: [{type: sphere, dimensions: [0.1]}]"


def test_primitives_in_an_object_with_a_pose(scene_of: Read) -> None:
    file = scene_of("""
        world:
          collision_objects:
            - id: things
              header: {frame_id: world}
              pose: {position: [1, 2, 3], orientation: [0, 0, 0.7071067811865476, 0.7071067811865476]}
              primitives:
                - {type: box, dimensions: [0.1, 0.2, 0.3]}
                - {type: SPHERE, dimensions: [0.1]}
                - {type: 3, dimensions: [0.4, 0.05]}
                - {type: cone, dimensions: [0.4, 0.05]}
              primitive_poses:
                - {position: {x: 1.0, y: 0.0, z: 0.0}, orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}}
                - {position: [0, 0, 1]}
                - {orientation: [1, 0, 0, 0]}
    """)
    item = file.scene.object("things")
    shapes = [shape for shape, _ in item.parts]
    assert shapes == [
        Box(0.1, 0.2, 0.3),
        Sphere(0.1),
        Cylinder(radius=0.05, length=0.4),
        Cone(radius=0.05, length=0.4),
    ]
    assert same(item.placement, placement((1, 2, 3), rpy=(0, 0, np.pi / 2)))
    places = [place for _, place in item.parts]
    assert same(places[0], placement((1, 0, 0)))
    assert same(places[1], placement((0, 0, 1)))
    assert same(places[2], placement(rpy=(np.pi, 0, 0)))
    assert same(places[3], placement())
    assert same(item.placement * places[0], placement((1, 3, 3), rpy=(0, 0, np.pi / 2)))
    assert not file.notes


def test_single_shape_lends_its_pose_to_the_object(scene_of: Read) -> None:
    file = scene_of(with_objects(f"{{id: ball, {SPHERE}, primitive_poses: [{{position: [1, 0, 0]}}]}}"))
    item = file.scene.object("ball")
    assert same(item.placement, placement((1, 0, 0)))
    assert same(item.parts[0][1], placement())


def test_quaternions_of_zeros_and_of_other_lengths(scene_of: Read) -> None:
    file = scene_of(
        with_objects(
            f"{{id: a, {SPHERE}, pose: {{position: [1, 0, 0], orientation: [0, 0, 0, 0]}}}}, "
            f"{{id: b, {SPHERE}, pose: {{position: [1, 0, 0], orientation: [0, 0, 2, 2]}}}}"
        )
    )
    assert same(where(file, "a"), placement((1, 0, 0)))
    assert same(where(file, "b"), placement((1, 0, 0), rpy=(0, 0, np.pi / 2)))
    zero, other = file.notes
    assert "collision_objects[0].pose.orientation" in zero
    assert "zeros" in zero
    assert "normalised" in other


def test_mesh(scene_of: Read) -> None:
    file = scene_of("""
        world:
          collision_objects:
            - id: wedge
              meshes:
                - vertices: [[0, 0, 0], [1, 0, 0], {x: 0, y: 1, z: 0}, [0, 0, 1]]
                  triangles:
                    - {vertex_indices: [0, 2, 1]}
                    - {vertex_indices: [0, 1, 3]}
                    - {vertex_indices: [0, 3, 2]}
                    - [1, 2, 3]
              mesh_poses: [{position: [5, 0, 0]}]
    """)
    item = file.scene.object("wedge")
    lower, upper = bounding_box(item.parts[0][0])
    assert np.allclose((lower, upper), (np.zeros(3), np.ones(3)))
    assert same(item.placement, placement((5, 0, 0)))
    assert "wedge" in item.notes[0]


def test_plane_is_solid_below(scene_of: Read) -> None:
    file = scene_of(
        with_objects(
            "{id: floor, planes: [{coef: [0, 0, 2, 1]}], plane_poses: [{position: [1, 1, 0]}]}, "
            "{id: wall, planes: [{coef: [-1, 0, 0, 3]}]}"
        )
    )
    assert file.scene.object("floor").parts[0][0] == Plane()
    bodies = {body.owner: body.placement for body in file.scene.object_bodies()}
    floor, wall = bodies["floor"], bodies["wall"]
    assert np.allclose(floor.rotation[:, 2], (0, 0, 1))
    assert floor.translation[2] == pytest.approx(-0.5)
    assert np.allclose(wall.rotation[:, 2], (-1, 0, 0))
    assert np.allclose(wall.translation, (3, 0, 0))
    assert len(file.notes) == 2
    assert "solid" in file.notes[0]


def test_subframes_move_along(scene_of: Read) -> None:
    file = scene_of(
        with_objects(
            f"{{id: cup, {SPHERE}, pose: {{position: [1, 0, 0]}}, subframe_names: [rim], "
            "subframe_poses: [{position: [0, 0, 0.1]}]}, "
            "{id: cup, operation: 3, pose: {position: [2, 0, 0]}}"
        )
    )
    assert same(where(file, "cup"), placement((2, 0, 0)))
    assert same(where(file, "cup/rim"), placement((2, 0, 0.1)))


@pytest.mark.parametrize("operation", ["REMOVE", "1", "'\\x01'", "!!binary AQ=="])
def test_remove(scene_of: Read, operation: str) -> None:
    file = scene_of(
        with_objects(
            f"{{id: a, {SPHERE}, subframe_names: [f], subframe_poses: [{{}}]}}, {{id: b, {SPHERE}}}, "
            f"{{id: a, operation: {operation.replace(chr(39), chr(34))}}}"
        )
    )
    assert list(file.scene.objects) == ["b"]


def test_remove_all_and_what_is_not_there(scene_of: Read) -> None:
    file = scene_of(
        "fixed_frame_transforms: [{header: {frame_id: camera}, child_frame_id: world}]\n"
        + with_objects(f"{{id: a, {SPHERE}}}, {{operation: REMOVE}}, {{id: c, operation: REMOVE}}")
    )
    assert list(file.scene.objects) == ["camera"]
    assert "'c'" in file.notes[0]


def test_add_again_replaces(scene_of: Read) -> None:
    file = scene_of(
        with_objects(f"{{id: a, {SPHERE}}}, {{id: a, primitives: [{{type: box, dimensions: [1, 1, 1]}}]}}")
    )
    assert file.scene.object("a").parts[0][0] == Box(1, 1, 1)
    assert "replaces" in file.notes[0]


def test_append_puts_shapes_where_the_message_says(scene_of: Read) -> None:
    file = scene_of(
        with_objects(
            f"{{id: a, {SPHERE}, pose: {{position: [1, 0, 0], orientation: [0, 0, 1, 0]}}}}, "
            "{id: a, operation: APPEND, primitives: [{type: box, dimensions: [1, 1, 1]}], "
            "primitive_poses: [{position: [3, 0, 0]}], subframe_names: [top], "
            "subframe_poses: [{position: [0, 0, 1]}]}, "
            f"{{id: new, operation: APPEND, {SPHERE}}}"
        )
    )
    item = file.scene.object("a")
    assert [type(shape) for shape, _ in item.parts] == [Sphere, Box]
    assert same(item.placement * item.parts[1][1], placement((3, 0, 0)))
    assert same(where(file, "a/top"), placement((3, 0, 1)))
    assert "new" in file.scene.objects


def test_object_in_the_frame_of_a_link_stays_in_the_world(scene_of: Read) -> None:
    file = scene_of(f"""
        robot_state:
          joint_state: {{name: [shoulder, elbow, flange], position: [1.5707963267948966, 0, 0]}}
        world:
          collision_objects:
            - {{id: a, header: {{frame_id: hand}}, pose: {{position: [0.1, 0, 0]}}, {SPHERE}}}
            - {{id: b, header: {{frame_id: /base}}, pose: {{position: [0.1, 0, 0]}}, {SPHERE}}}
            - {{id: c, header: {{frame_id: a}}, pose: {{position: [0.1, 0, 0]}}, {SPHERE}}}
    """)
    assert file.scene.object("a").frame == "world"
    assert same(where(file, "a"), placement((0, 1.1, 0.1), rpy=(0, 0, np.pi / 2)))
    assert same(where(file, "b"), placement((0.1, 0, 0)))
    assert same(where(file, "c"), placement((0, 1.2, 0.1), rpy=(0, 0, np.pi / 2)))


def test_fixed_frames_in_both_conventions(scene_of: Read) -> None:
    file = scene_of(f"""
        fixed_frame_transforms:
          - {{header: {{frame_id: camera}}, child_frame_id: world, transform: {{translation: [1, 0, 0]}}}}
          - {{header: {{frame_id: world}}, child_frame_id: table, transform: {{translation: [2, 0, 0]}}}}
          - {{child_frame_id: odom, transform: {{translation: [0, 0, 0], rotation: [0, 0, 0, 1]}}}}
          - {{header: {{frame_id: hand}}, child_frame_id: world}}
        world:
          collision_objects:
            - {{id: a, header: {{frame_id: camera}}, pose: {{position: [0, 1, 0]}}, {SPHERE}}}
            - {{id: b, header: {{frame_id: odom}}, {SPHERE}}}
    """)
    assert not file.scene.object("camera").parts
    assert same(where(file, "camera"), placement((1, 0, 0)))
    assert same(where(file, "table"), placement((2, 0, 0)))
    assert same(where(file, "a"), placement((1, 1, 0)))
    assert same(where(file, "b"), placement())
    assert "odom" in file.world_names
    assert "'hand'" in file.notes[0]


def test_world_named_by_joints_of_several_degrees_of_freedom(scene_of: Read) -> None:
    file = scene_of(f"""
        robot_state:
          multi_dof_joint_state:
            header: {{frame_id: map}}
            joint_names: [virtual_joint]
            transforms: [{{translation: {{x: 0, y: 0, z: 0}}, rotation: {{x: 0, y: 0, z: 0, w: 1}}}}]
        world: {{collision_objects: [{{id: a, header: {{frame_id: map}}, {SPHERE}}}]}}
    """)
    assert same(where(file, "a"), placement())


def test_attached_objects(scene_of: Read) -> None:
    file = scene_of(f"""
        robot_state:
          joint_state: {{name: [shoulder, elbow], position: [0, 1.5707963267948966]}}
          attached_collision_objects:
            - link_name: hand
              object:
                id: tool
                header: {{frame_id: hand}}
                pose: {{position: [0.1, 0, 0]}}
                {SPHERE}
                subframe_names: [tip]
                subframe_poses: [{{position: [0, 0, 0.1]}}]
              touch_links: [left_finger, right_finger]
            - link_name: hand
              object: {{id: seen, pose: {{position: [0.5, 0.6, 0.1]}}, {SPHERE}}}
            - link_name: fore
              object: {{id: part}}
              weight: 1.0
        world:
          collision_objects:
            - {{id: part, pose: {{position: [0.5, 0.2, 0.1]}}, {SPHERE}}}
            - {{id: tool, {SPHERE}}}
    """)
    tool = file.scene.object("tool")
    assert tool.frame == "hand"
    assert tool.touch_links == {"hand", "left_finger", "right_finger"}
    assert same(tool.placement, placement((0.1, 0, 0)))
    assert same(where(file, "tool/tip"), where(file, "hand") * placement((0.1, 0, 0.1)))
    assert file.scene.object("seen").frame == "hand"
    assert same(where(file, "seen"), placement((0.5, 0.6, 0.1)))
    assert file.scene.object("part").frame == "fore"
    assert file.scene.object("part").touch_links == {"fore"}
    assert same(where(file, "part"), placement((0.5, 0.2, 0.1)))
    assert file.notes == ("robot_state.attached_collision_objects[2]: the weight of 'part' is ignored",)


def test_detach_leaves_the_object_where_it_is(scene_of: Read) -> None:
    attached = f"{{link_name: hand, object: {{id: tool, header: {{frame_id: hand}}, {SPHERE}}}}}"
    file = scene_of(f"""
        robot_state:
          joint_state: {{name: [shoulder], position: [1.5707963267948966]}}
          attached_collision_objects:
            - {attached}
            - {{object: {{id: tool, operation: REMOVE}}}}
            - {{object: {{id: other, operation: REMOVE}}}}
    """)
    assert file.scene.object("tool").frame == "world"
    assert same(where(file, "tool"), placement((0, 1, 0.1), rpy=(0, 0, np.pi / 2)))
    assert "'other'" in file.notes[0]


def test_padding_is_required_of_what_stands_in_the_world(scene_of: Read) -> None:
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
def test_scale_is_that_of_the_shapes(tmp_path: Path, exact: bool) -> None:
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


def test_header_of_the_file(scene_of: Read) -> None:
    file = scene_of("{name: mine, is_diff: true, robot_model_name: other, object_colors: [{id: a}]}")
    assert len(file.notes) == 2
    assert not file.scene.objects


def test_mimicking_joint_follows_unless_named(write: Callable[..., Path], planar_arm: Robot) -> None:
    text = "robot_state: {joint_state: {name: [left_slide], position: [0.03]}}"
    file = read_scene(write(text), planar_arm)
    assert file.positions[planar_arm.index(["right_slide"])[0]] == 0.03


def test_trailing_document_mark_and_exponents_without_point(scene_of: Read) -> None:
    file = scene_of(
        f"{{world: {{collision_objects: [{{id: a, pose: {{position: [1e-05, 0, 0]}}, {SPHERE}}}]}}}}\n---\n"
    )
    assert where(file, "a").translation[0] == 1e-5


BAD: dict[str, tuple[str, type[Exception], str]] = {
    "no yaml": ("{a: [", FileFormatError, "cannot be parsed"),
    "a list": ("[1, 2]", FileFormatError, "one mapping"),
    "nothing": ("", FileFormatError, "one mapping"),
    "two documents": ("{name: a}\n---\n{name: b}", FileFormatError, "one mapping"),
    "misspelt key": (
        "world: {colision_objects: []}",
        FileFormatError,
        "world: unknown key 'colision_objects'; did you mean 'collision_objects'",
    ),
    "unknown shape": (
        with_objects("{id: a, primitives: [{type: torus, dimensions: [1]}]}"),
        FileFormatError,
        r"collision_objects\[0\]\.primitives\[0\]\.type.*'torus'",
    ),
    "prism": (with_objects("{id: a, primitives: [{type: 5}]}"), FileFormatError, "type"),
    "too many sizes": (
        with_objects("{id: a, primitives: [{type: cylinder, dimensions: [1, 1, 1]}]}"),
        FileFormatError,
        r"\[height, radius\]",
    ),
    "negative size": (
        with_objects("{id: a, primitives: [{type: sphere, dimensions: [-1]}]}"),
        FileFormatError,
        "must be positive",
    ),
    "millimetres": (
        with_objects("{id: a, primitives: [{type: sphere, dimensions: [100]}]}"),
        FileFormatError,
        "in metres",
    ),
    "a text for a size": (
        with_objects("{id: a, primitives: [{type: sphere, dimensions: [big]}]}"),
        FileFormatError,
        r"dimensions\[0\]: must be a number, is 'big'",
    ),
    "a truth value for a size": (
        with_objects("{id: a, primitives: [{type: sphere, dimensions: [true]}]}"),
        FileFormatError,
        "must be a number",
    ),
    "not finite": (
        with_objects(f"{{id: a, pose: {{position: [.nan, 0, 0]}}, {SPHERE}}}"),
        FileFormatError,
        r"pose\.position\[0\]: must be finite",
    ),
    "two coordinates": (
        with_objects(f"{{id: a, pose: {{position: [0, 0]}}, {SPHERE}}}"),
        FileFormatError,
        "needs 3 numbers",
    ),
    "quaternion without w": (
        with_objects(f"{{id: a, pose: {{orientation: {{x: 0, y: 0, z: 1}}}}, {SPHERE}}}"),
        FileFormatError,
        r"orientation\.w: must be a number, is missing",
    ),
    "more poses than shapes": (
        with_objects(f"{{id: a, {SPHERE}, primitive_poses: [{{}}, {{}}]}}"),
        FileFormatError,
        "2 poses for 1 primitives",
    ),
    "no shape": (with_objects("{id: a}"), FileFormatError, "has no shape"),
    "no id": (with_objects(f"{{{SPHERE}}}"), FileFormatError, "empty"),
    "id of a link": (with_objects(f"{{id: hand, {SPHERE}}}"), FileFormatError, "'hand' is taken"),
    "mesh without triangles": (
        with_objects("{id: a, meshes: [{vertices: [[0, 0, 0]]}]}"),
        FileFormatError,
        "without triangles",
    ),
    "mesh of a triangle without area": (
        with_objects("{id: a, meshes: [{vertices: [[0, 0, 0]], triangles: [[0, 0, 0]]}]}"),
        FileFormatError,
        "without triangles",
    ),
    "mesh index": (
        with_objects("{id: a, meshes: [{vertices: [[0, 0, 0]], triangles: [[0, 0, 1]]}]}"),
        FileFormatError,
        "three of the 1 vertices",
    ),
    "plane without normal": (
        with_objects("{id: a, planes: [{coef: [0, 0, 0, 1]}]}"),
        FileFormatError,
        "the length 0",
    ),
    "mesh without a point": (
        with_objects("{id: a, meshes: [{vertices: [[0, 0, 0], null], triangles: [[0, 0, 0]]}]}"),
        FileFormatError,
        r"vertices\[1\]: is no point",
    ),
    "subframes": (
        with_objects(f"{{id: a, {SPHERE}, subframe_names: [b]}}"),
        FileFormatError,
        "1 names, but 0 poses",
    ),
    "unknown operation": (
        with_objects(f"{{id: a, operation: 7, {SPHERE}}}"),
        FileFormatError,
        "unknown operation 7",
    ),
    "operation of no kind": (
        with_objects(f"{{id: a, operation: true, {SPHERE}}}"),
        FileFormatError,
        "unknown operation True",
    ),
    "move unknown": (with_objects("{id: cup, operation: MOVE}"), ObjectNotFound, "'cup'"),
    "unknown frame": (
        with_objects(f"{{id: a, header: {{frame_id: hnd}}, {SPHERE}}}"),
        FrameNotFound,
        r"frame_id in .*scene\.yaml.*did you mean 'hand'",
    ),
    "joint twice": (
        "robot_state: {joint_state: {name: [elbow, elbow], position: [0, 1]}}",
        FileFormatError,
        "listed twice",
    ),
    "names without positions": (
        "robot_state: {joint_state: {name: [elbow]}}",
        FileFormatError,
        "1 names, but 0 positions",
    ),
    "a joint displaced that the robot lacks": (
        "robot_state: {multi_dof_joint_state: {joint_names: [a, b], "
        "transforms: [{translation: [0, 0, 0]}, {translation: [1, 0, 0]}]}}",
        FileFormatError,
        r"transforms\[1\].*b of .* cannot stand elsewhere",
    ),
    "transforms without names": (
        "robot_state: {multi_dof_joint_state: {joint_names: [a], transforms: [{}, {}]}}",
        FileFormatError,
        "1 names, but 2 transforms",
    ),
    "frame between strangers": (
        "fixed_frame_transforms: [{header: {frame_id: a}, child_frame_id: b}]",
        FileFormatError,
        "neither of a, b",
    ),
    "frame twice": (
        "fixed_frame_transforms: [{header: {frame_id: a}, child_frame_id: world}, "
        "{header: {frame_id: a}, child_frame_id: world}]",
        FileFormatError,
        "given twice",
    ),
    "world displaced": (
        "fixed_frame_transforms: [{child_frame_id: world, transform: {translation: [0, 0, 1]}}]",
        FileFormatError,
        "from itself",
    ),
    "octomap": (
        "world: {octomap: {octomap: {resolution: 0.1, data: [1]}}}",
        FileFormatError,
        "octomap",
    ),
    "attach to unknown": (
        f"robot_state: {{attached_collision_objects: [{{link_name: hnd, object: {{id: a, {SPHERE}}}}}]}}",
        FrameNotFound,
        "did you mean 'hand'",
    ),
    "touch link unknown": (
        f"robot_state: {{attached_collision_objects: [{{link_name: hand, touch_links: [foer], "
        f"object: {{id: a, {SPHERE}}}}}]}}",
        FrameNotFound,
        "did you mean 'fore'",
    ),
    "attach what is not there": (
        "robot_state: {attached_collision_objects: [{link_name: hand, object: {id: a}}]}",
        ObjectNotFound,
        "'a'",
    ),
    "attached moves": (
        "robot_state: {attached_collision_objects: [{link_name: hand, object: {id: a, operation: 3}}]}",
        FileFormatError,
        "MOVE of an attached object",
    ),
    "padding of unknown": ("link_padding: [{link_name: hnd, padding: 1}]", FrameNotFound, "'hand'"),
    "scale of unknown": ("link_scale: [{link_name: hnd, scale: 1}]", FrameNotFound, "'hand'"),
    "no scale": (
        "link_scale: [{link_name: hand, scale: 0}]",
        FileFormatError,
        "link_scale.*must be positive",
    ),
    "negative scale": ("link_scale: [{link_name: hand, scale: -1}]", FileFormatError, "must be positive"),
    "huge scale": ("link_scale: [{link_name: hand, scale: 1.0e+6}]", FileFormatError, "metres"),
    "infinite padding": ("link_padding: [{link_name: hand, padding: .inf}]", FileFormatError, "finite"),
    "negative padding": ("link_padding: [{link_name: hand, padding: -1}]", FileFormatError, "negative"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_scene(scene_of: Read, case: str) -> None:
    text, error, message = BAD[case]
    with pytest.raises(error, match=message) as caught:
        scene_of(text)
    assert "scene.yaml" in str(caught.value)


def test_missing_file(tmp_path: Path, planar_arm: Robot) -> None:
    with pytest.raises(FileFormatError, match=r"nowhere\.yaml: cannot be read"):
        read_scene(tmp_path / "nowhere.yaml", planar_arm)


def test_joints_that_the_robot_lacks_or_has_fixed_are_left_out_and_noted(scene_of: Read) -> None:
    file = scene_of(
        "robot_state: {joint_state: {name: [camera_pan, elbow, flange, sholder], position: [3, 1, 0.05, 2]}}"
    )
    assert dict(file.state) == {"elbow": 1.0}
    robot = file.scene.robot.name
    assert file.notes == (
        f"robot_state.joint_state: left out, being no joints of {robot}: "
        "camera_pan, sholder (did you mean 'shoulder'?)",
        f"robot_state.joint_state: left out, being fixed in {robot}: flange (at 0.05)",
    )
