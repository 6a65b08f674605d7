"""Planning scene files, feature by feature."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.files.moveit.scenes import SPHERE, Read, same, where, with_objects
from trajopt import Robot, placement
from trajopt.files.moveit import read_scene
from trajopt.values.errors import FileFormatError
from trajopt.values.shapes.shapes import Box, Cone, Cylinder, Plane, Sphere, bounding_box


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


def test_members_that_a_pose_leaves_out_are_zero_as_in_a_message(scene_of: Read) -> None:
    for pose in ("{position: {z: 0.5}, orientation: {w: 1}}", "{position: {z: 0.5}, orientation: {}}"):
        at = scene_of(with_objects(f"{{id: a, pose: {pose}, {SPHERE}}}")).scene.objects["a"].placement
        assert at.translation.tolist() == [0.0, 0.0, 0.5] and np.array_equal(at.rotation, np.eye(3))
    turned = with_objects(f"{{id: a, pose: {{orientation: {{x: 1, w: 0}}}}, {SPHERE}}}")
    rotation = scene_of(turned).scene.objects["a"].placement.rotation
    assert np.allclose(rotation, np.diag((1.0, -1.0, -1.0)))


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


def test_remove_all_and_unknown_objects(scene_of: Read) -> None:
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


def test_append_places_shapes_at_the_poses_of_the_message(scene_of: Read) -> None:
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


def test_a_fixed_frame_on_the_robot_is_a_tool(scene_of: Read) -> None:
    for header, child in (("hand", "tcp"), ("tcp", "hand")):
        scene = scene_of(f"""
            fixed_frame_transforms:
              - {{header: {{frame_id: {header}}}, child_frame_id: {child},
                 transform: {{translation: [0, 0, 0.1], rotation: [0, 0, 0, 1]}}}}
            world:
              collision_objects: [{{id: a, header: {{frame_id: tcp}}, {SPHERE}}}]
        """).scene
        assert scene.tools["tcp"].frame == "hand" and "tcp" not in scene.objects
        assert scene.tools["tcp"].placement.translation == pytest.approx([0.0, 0.0, 0.1])
        assert scene.object("a").placement.translation[2] == pytest.approx(0.2)


def test_a_fixed_frame_on_the_robot_of_a_taken_name_is_refused(scene_of: Read) -> None:
    twice = "{header: {frame_id: hand}, child_frame_id: tcp}"
    with pytest.raises(FileFormatError, match="neither of hand, upper is the world"):
        scene_of("fixed_frame_transforms: [{header: {frame_id: hand}, child_frame_id: upper}]")
    with pytest.raises(FileFormatError, match="neither of hand, tcp is the world"):
        scene_of(f"fixed_frame_transforms: [{twice}, {twice}]")
