"""Constraints of motion plan requests become requirements that accept the same postures."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tests.robots_for_tests import odd_arm
from trajopt import Robot, Scene, placement
from trajopt.files.moveit import RequestFile
from trajopt.problem.requirements import FramePlacement, JointPositions, RotationCoordinates
from trajopt.values.errors import FileFormatError, FrameNotFound, JointNotFound
from trajopt.values.shapes.shapes import Sphere

Read = Callable[..., RequestFile]
Array = NDArray[np.float64]

TURN = 0.7071067811865476


def goals(read: Read, constraints: str, scene: Scene | None = None) -> RequestFile:
    return read(f"{{group_name: arm, goal_constraints: [{{{constraints}}}]}}", scene)


def position_of(shape: str, more: str = "", link: str = "hand") -> str:
    return (
        f"position_constraints: [{{link_name: {link}, constraint_region: {{primitives: [{shape}], "
        f"primitive_poses: [{{position: [0.4, 0.5, 0.1]}}]}}{', ' + more if more else ''}}}]"
    )


def orientation_of(quaternion: str, tolerance: tuple[float, ...], kind: int, more: str = "") -> str:
    x, y, z = tolerance
    return (
        f"orientation_constraints: [{{link_name: hand, orientation: {quaternion}, "
        f"absolute_x_axis_tolerance: {x}, absolute_y_axis_tolerance: {y}, "
        f"absolute_z_axis_tolerance: {z}, parameterization: {kind}{', ' + more if more else ''}}}]"
    )


SPHERE = "{type: sphere, dimensions: [0.03]}"
BOX = "{type: box, dimensions: [0.02, 0.04, 0.06]}"


def only(request: RequestFile) -> FramePlacement:
    (goal,) = request.goals
    assert isinstance(goal, FramePlacement)
    return goal


def test_joints(request_of: Read) -> None:
    request = goals(
        request_of,
        "joint_constraints: [{joint_name: elbow, position: 1, tolerance_above: 0.1, tolerance_below: 0, "
        "weight: 2}, {joint_name: shoulder, position: -1}]",
    )
    (goal,) = request.goals
    assert isinstance(goal, JointPositions)
    assert goal.positions == {"elbow": 1.0, "shoulder": -1.0}
    assert goal.above == {"elbow": 0.1, "shoulder": 1e-4}
    assert goal.below == {"elbow": 1e-4, "shoulder": 1e-4}


def test_position_in_a_box(request_of: Read) -> None:
    goal = only(goals(request_of, position_of(BOX, "target_point_offset: {x: 0.1, y: 0, z: 0}")))
    assert (goal.frame, goal.reference) == ("hand", "world")
    assert np.allclose(goal.placement.translation, (0.4, 0.5, 0.1))
    assert np.allclose(goal.position_tolerance, (0.01, 0.02, 0.03))
    assert np.isinf(goal.rotation_tolerance).all()
    assert np.allclose(goal.offset, (0.1, 0, 0))


def test_position_in_a_sphere_is_one_in_the_cube_inside(request_of: Read) -> None:
    request = goals(request_of, position_of(SPHERE))
    goal = only(request)
    assert np.allclose(goal.position_tolerance, 0.03 / np.sqrt(3))
    assert "sphere of 0.03 m" in request.notes[0]


def test_edges_of_boxes(request_of: Read) -> None:
    request = goals(request_of, position_of("{type: box, dimensions: [0, -1, .inf]}"))
    assert only(request).position_tolerance.tolist() == [1e-4, np.inf, np.inf]
    assert len(request.notes) == 1
    with pytest.raises(FileFormatError, match="requires nothing"):
        goals(request_of, position_of("{type: box, dimensions: [-1, -1, -1]}"))


def test_first_of_several_regions(request_of: Read) -> None:
    text = position_of(f"{BOX}, {SPHERE}")
    request = goals(request_of, text)
    assert np.allclose(only(request).position_tolerance, (0.01, 0.02, 0.03))
    assert "first of 2 regions" in request.notes[0]


def test_orientation(request_of: Read) -> None:
    goal = only(goals(request_of, orientation_of(f"[0, 0, {TURN}, {TURN}]", (0.1, 0.0, 3.2), 0)))
    assert np.isinf(goal.position_tolerance).all()
    assert goal.rotation_tolerance.tolist() == [0.1, 1e-4, np.inf]
    assert goal.coordinates is RotationCoordinates.XYZ_EULER
    assert np.allclose(goal.placement.rotation, Rotation.from_euler("z", 90, degrees=True).as_matrix())


def test_position_and_orientation_become_one(request_of: Read) -> None:
    turned = orientation_of(f"[0, 0, {TURN}, {TURN}]", (0.1, 0.2, 0.3), 0)
    straight = orientation_of("[0, 0, 0, 1]", (0.1, 0.2, 0.3), 0)
    goal = only(goals(request_of, f"{position_of(SPHERE)}, {turned}"))
    assert np.allclose(goal.placement.translation, (0.4, 0.5, 0.1))
    assert np.isfinite(goal.rotation_tolerance).all()
    assert np.isfinite(goal.position_tolerance).all()
    assert only(goals(request_of, f"{position_of(BOX)}, {straight}"))
    # A box along other axes than the goal's, another link, another frame: each for itself.
    assert len(goals(request_of, f"{position_of(BOX)}, {turned}").goals) == 2
    assert len(goals(request_of, f"{position_of(SPHERE, link='fore')}, {turned}").goals) == 2
    elsewhere = orientation_of("[0, 0, 0, 1]", (0.1, 0.2, 0.3), 0, "header: {frame_id: upper}")
    assert len(goals(request_of, f"{position_of(SPHERE)}, {elsewhere}").goals) == 2


def test_references(request_of: Read, planar_arm: Robot) -> None:
    scene = (
        Scene(planar_arm)
        .add("table", Sphere(0.1), placement((1.0, 0.0, 0.0)))
        .add("tool", Sphere(0.1), placement((0.1, 0.0, 0.0)), frame="hand")
    )
    for frame, reference in (("table", "table"), ("base", "world"), ("''", "world"), ("/world", "world")):
        goal = only(goals(request_of, position_of(SPHERE, f"header: {{frame_id: {frame}}}", "tool"), scene))
        assert (goal.frame, goal.reference) == ("tool", reference)


def error_of(goal: FramePlacement, scene: Scene, link: Array, point: Array) -> Array:
    """The six components that a requirement bounds, computed from its docstring."""
    holder = scene.holder(goal.frame)
    assert holder.link == "hand"
    frame = link @ holder.placement.rotation
    where = point + link @ (holder.placement * goal.offset)
    aim = goal.placement.rotation
    turned = Rotation.from_matrix(aim.T @ frame)
    euler = goal.coordinates is RotationCoordinates.XYZ_EULER
    rotation = turned.as_euler("XYZ") if euler else turned.as_rotvec()
    return np.concatenate((aim.T @ (where - goal.placement.translation), rotation))


QUATERNIONS = {
    "none": (0.0, 0.0, 0.0, 1.0),
    "tool down": (1.0, 0.0, 0.0, 0.0),
    "quarter": (0.0, TURN, 0.0, TURN),
    "two quarters": (0.5, 0.5, 0.5, 0.5),
    "any": (0.1, 0.5, -0.3, 0.8),
}


@pytest.mark.parametrize("kind", [0, 1])
@pytest.mark.parametrize("name", QUATERNIONS)
def test_the_same_postures_are_accepted(request_of: Read, name: str, kind: int) -> None:
    quaternion = np.array(QUATERNIONS[name]) / np.linalg.norm(QUATERNIONS[name])
    tolerance = (0.2, 0.5, 1.5)
    offset = np.array((0.1, 0.2, -0.1))
    request = goals(
        request_of,
        position_of(SPHERE, f"target_point_offset: {offset.tolist()}")
        + ", "
        + orientation_of(str(quaternion.tolist()), tolerance, kind),
    )
    goal = only(request)
    bound = np.concatenate((goal.position_tolerance, goal.rotation_tolerance))
    desired = Rotation.from_quat(quaternion).as_matrix()
    rng = np.random.default_rng(1)
    accepted = 0
    for _ in range(300):
        link = desired @ Rotation.from_rotvec(rng.normal(scale=0.5, size=3)).as_matrix()
        point = np.array((0.4, 0.5, 0.1)) - link @ offset
        error = error_of(goal, request.scene, link, point)
        assert np.allclose(error[:3], 0.0, atol=1e-12)
        # MoveIt's own measure: Euler angles of R_d^T R, or R_d times its rotation vector.
        turned = Rotation.from_matrix(desired.T @ link)
        measure = turned.as_euler("XYZ") if kind == 0 else desired @ turned.as_rotvec()
        expected = bool((np.abs(measure) <= tolerance).all())
        assert bool((np.abs(error) <= bound + 1e-12).all()) == expected
        accepted += expected
    assert 20 < accepted < 280


def test_position_beside_a_turned_copy_of_the_frame(request_of: Read) -> None:
    """Every point in the cube lies in the sphere, whatever the axes of the goal."""
    request = goals(
        request_of, f"{position_of(SPHERE)}, {orientation_of('[0.1, 0.5, -0.3, 0.8]', (0.1, 0.1, 0.1), 1)}"
    )
    goal = only(request)
    assert goal.frame == "hand/turned_0"
    assert request.scene.object("hand/turned_0").frame == "hand"
    corner = goal.placement.rotation @ goal.position_tolerance
    assert np.linalg.norm(corner) == pytest.approx(0.03)
    assert request.problem().scene.holder(goal.frame).link == "hand"


BAD: dict[str, tuple[str, type[Exception], str]] = {
    "unknown joint": (
        "joint_constraints: [{joint_name: elbo, position: 1}]",
        JointNotFound,
        r"joint_constraints\[0\]\.joint_name.*did you mean 'elbow'",
    ),
    "fixed joint": ("joint_constraints: [{joint_name: flange, position: 0}]", JointNotFound, "flange"),
    "joint twice": (
        "joint_constraints: [{joint_name: elbow, position: 1}, {joint_name: elbow, position: 1}]",
        FileFormatError,
        "twice",
    ),
    "no position": (
        "joint_constraints: [{joint_name: elbow}]",
        FileFormatError,
        "position: must be a number",
    ),
    "negative tolerance": (
        "joint_constraints: [{joint_name: elbow, position: 1, tolerance_above: -1}]",
        FileFormatError,
        "tolerance_above: is negative",
    ),
    "unknown link": (position_of(SPHERE, link="hnad"), FrameNotFound, "did you mean 'hand'"),
    "unknown frame": (
        position_of(SPHERE, "header: {frame_id: handd}"),
        FrameNotFound,
        r"header\.frame_id.*did you mean 'hand'",
    ),
    "no region": ("position_constraints: [{link_name: hand}]", FileFormatError, "0 primitives"),
    "cylinder": (
        position_of("{type: cylinder, dimensions: [1, 1]}"),
        FileFormatError,
        "a box or a sphere, not a cylinder",
    ),
    "mesh": (
        "position_constraints: [{link_name: hand, constraint_region: {meshes: [{}]}}]",
        FileFormatError,
        "not a mesh",
    ),
    "parameterization": (orientation_of("[0, 0, 0, 1]", (1, 1, 1), 2), FileFormatError, "must be 0"),
    "visibility": ("visibility_constraints: [{}]", FileFormatError, "the cone alone is not supported"),
    "view direction": (
        "visibility_constraints: [{max_view_angle: 1, sensor_view_direction: 3}]",
        FileFormatError,
        "must be 0",
    ),
    "view angle": ("visibility_constraints: [{max_view_angle: -1}]", FileFormatError, "is negative"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_constraints(request_of: Read, case: str) -> None:
    text, error, message = BAD[case]
    with pytest.raises(error, match=message):
        goals(request_of, text)


def test_constraints_of_a_continuous_joint_are_of_the_turn_of_the_start(
    request_of: Read, tmp_path: Path
) -> None:
    """In MoveIt its positions have no turns."""
    bound = (
        "joint_constraints: [{joint_name: pan, position: 0.5, tolerance_above: 0.2, tolerance_below: 0.2}]"
    )
    found = request_of(
        "{start_state: {joint_state: {name: [pan], position: [13.0]}}, "
        f"goal_constraints: [{{{bound}}}], path_constraints: {{{bound}}}, "
        f"trajectory_constraints: {{constraints: [{{{bound}}}]}}}}",
        Scene(odd_arm(tmp_path)),
    )
    for each in (*found.goals, *found.constraints, *found.waypoints[0]):
        assert isinstance(each, JointPositions)
        assert each.positions["pan"] == pytest.approx(0.5 + 4.0 * np.pi)
