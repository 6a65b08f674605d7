"""Whatever is put in place of a value: a file is read, or refused with an error that names it."""

import copy
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml

from trajopt import Robot, Scene
from trajopt.files.moveit import read_request, read_scene
from trajopt.files.moveit.trajectories import read_trajectory
from trajopt.values.errors import TrajoptError

SPHERE = "primitives: [{type: sphere, dimensions: [0.1]}]"

SCENE = f"""
name: a
robot_state:
  joint_state: {{header: {{frame_id: ""}}, name: [shoulder], position: [0.1]}}
  multi_dof_joint_state:
    header: {{frame_id: map}}
    joint_names: [virtual]
    transforms: [{{translation: [0, 0, 0], rotation: [0, 0, 0, 1]}}]
  attached_collision_objects:
    - link_name: hand
      touch_links: [fore]
      object: {{id: tool, header: {{frame_id: hand}}, {SPHERE}, pose: {{position: [1, 0, 0]}}}}
fixed_frame_transforms:
  - {{header: {{frame_id: camera}}, child_frame_id: world, transform: {{translation: [1, 0, 0]}}}}
allowed_collision_matrix:
  entry_names: [hand, a]
  entry_values: [[true, false], [false, true]]
  default_entry_names: [a]
  default_entry_values: [true]
link_padding: [{{link_name: hand, padding: 0.1}}]
world:
  collision_objects:
    - id: a
      header: {{frame_id: camera}}
      primitives: [{{type: 1, dimensions: [0.1, 0.1, 0.1]}}]
      primitive_poses: [{{position: [1, 2, 3], orientation: {{x: 0, y: 0, z: 0, w: 1}}}}]
      subframe_names: [f]
      subframe_poses: [{{position: [1, 2, 3]}}]
    - {{id: b, planes: [{{coef: [0, 0, 1, 0]}}], plane_poses: [{{}}]}}
    - {{id: b, operation: MOVE, pose: {{position: [0, 0, 1]}}}}
    - {{id: a, operation: APPEND, {SPHERE}}}
    - {{id: a, operation: REMOVE}}
"""

REQUEST = """
group_name: arm
start_state: {joint_state: {name: [shoulder, flange], position: [0.1, 0]}}
max_velocity_scaling_factor: 0.5
allowed_planning_time: 4
goal_constraints:
  - joint_constraints: [{joint_name: elbow, position: 1, tolerance_above: 0.1}]
    position_constraints:
      - header: {frame_id: base}
        link_name: hand
        target_point_offset: [0, 0, 1]
        constraint_region:
          primitives: [{type: 1, dimensions: [1, 1, 1]}]
          primitive_poses: [{position: [1, 0, 0]}]
    orientation_constraints:
      - header: {frame_id: base}
        link_name: hand
        orientation: [0, 0.2, 0.3, 1]
        absolute_x_axis_tolerance: 0.1
        parameterization: 1
path_constraints: {joint_constraints: [{joint_name: elbow, position: 1}]}
"""

TRAJECTORY = """
joint_names: [a]
points:
  - {time_from_start: 0, positions: [0], velocities: [0], accelerations: [0]}
  - {time_from_start: {sec: 1, nanosec: 4}, positions: [0], velocities: [0], accelerations: [0]}
"""  # fmt: skip

JUNK = [None, True, -1, float("nan"), 1e300, 10**400, "", "hand", [], {}, [[None]], {"x": 1}, b"\x01"]


def places(value: object, way: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    if way:
        yield way
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from places(inner, (*way, key))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from places(inner, (*way, i))


def replaced(document: object, way: tuple[str | int, ...], value: object) -> object:
    result = copy.deepcopy(document)
    owner = result
    for key in way[:-1]:
        owner = owner[key]
    owner[way[-1]] = value
    return result


@pytest.mark.parametrize("kind", ["scene", "request", "trajectory"])
def test_only_errors_that_name_the_file(kind: str, tmp_path: Path, planar_arm: Robot) -> None:
    scene = Scene(planar_arm)
    readers: dict[str, tuple[str, Callable[[Path], object]]] = {
        "scene": (SCENE, lambda path: read_scene(path, planar_arm)),
        "request": (REQUEST, lambda path: read_request(path, scene).problem()),
        "trajectory": (TRAJECTORY, read_trajectory),
    }
    text, read = readers[kind]
    document = yaml.safe_load(text)
    path = tmp_path / "malformed.yaml"
    path.write_text(yaml.dump(document, Dumper=yaml.CSafeDumper))
    assert read(path)
    refused = 0
    for i, way in enumerate(places(document)):
        for junk in JUNK[i % 3 :: 3]:
            path.write_text(yaml.dump(replaced(document, way, junk), Dumper=yaml.CSafeDumper))
            try:
                read(path)
            except TrajoptError as error:
                refused += 1
                assert "malformed.yaml" in str(error), (way, junk)
    assert refused > 20
