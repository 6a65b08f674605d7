"""Scene files that are refused, each with what is wrong and where."""

from pathlib import Path

import pytest

from tests.files.moveit.scenes import SPHERE, Read, with_objects
from trajopt import Robot
from trajopt.files.moveit import read_scene
from trajopt.values.errors import FileFormatError, FrameNotFound, ObjectNotFound

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
        r"vertices\[1\]: is not a point",
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
        r"transforms\[1\].*b of .* cannot be elsewhere",
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
