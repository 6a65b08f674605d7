"""Goals and path constraints: values against closed forms, proofs against dense sampling."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.verify.arms import joint, link, mixed_arm, planar_arm, quintic, reduced, robot, wavy
from trajopt.errors import FrameNotFound, JointNotFound, ProblemError
from trajopt.model.frame_attachment import FrameAttachment
from trajopt.model.placement import Placement, placement
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import (
    Requirement,
    RotationCoordinates,
    axis_alignment,
    frame_placement,
    joint_positions,
)
from trajopt.model.scene import Scene
from trajopt.model.shapes import Sphere
from trajopt.model.trajectory import Trajectory
from trajopt.verify import Check, Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.checks.frame_placement import euler_angles
from trajopt.verify.checks.quantities import quantities
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import Motion

END = (0.9, 0.4)
MANY = settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def check(model: ReducedModel, trajectory: Trajectory, wanted: Requirement, when: When) -> tuple[Check, ...]:
    motion = Motion(model, trajectory, kinematics=Kinematics(model), options=VerifyOptions())
    return check_requirement(wanted, motion, when)


@pytest.fixture
def model(tmp_path: Path) -> ReducedModel:
    return reduced(Scene(planar_arm(tmp_path)), [-0.5, 0.2])


def reach(model: ReducedModel, *knots: tuple[float, float], duration: float = 1.0) -> Trajectory:
    return quintic(model, [[-0.5, 0.2], *(list(knot) for knot in knots)], duration)


def tip(shoulder: float, elbow: float) -> Placement:
    """Where the tip is, by trigonometry."""
    x = 0.5 * np.cos(shoulder) + 0.5 * np.cos(shoulder + elbow)
    y = 0.5 * np.sin(shoulder) + 0.5 * np.sin(shoulder + elbow)
    return placement((x, y, 0.0), rpy=(0, 0, shoulder + elbow))


def test_every_kind_of_requirement_has_a_check() -> None:
    for kind in walk(Requirement):
        assert quantities.dispatch(kind) is not quantities.dispatch(object), kind


def walk(kind: type[Requirement]) -> Iterator[type[Requirement]]:
    for child in kind.__subclasses__():
        if child.__module__.startswith("trajopt."):
            yield child
            yield from walk(child)


def test_an_unknown_requirement_is_refused(model: ReducedModel) -> None:
    @dataclass(frozen=True)
    class Strange(Requirement):
        pass

    with pytest.raises(ProblemError, match="Strange"):
        check(model, reach(model, END), Strange(), When.END)


def test_joint_goals(model: ReducedModel) -> None:
    good = joint_positions({"shoulder": 0.9, "elbow": 0.4})
    (found,) = check(model, reach(model, END), good, When.END)
    assert found.holds
    assert found.name == "goal: joints"
    assert found.evidence is Evidence.PROVEN
    off = joint_positions({"shoulder": 0.9, "elbow": 0.42}, below={"elbow": 0.01})
    (found,) = check(model, reach(model, END), off, When.END)
    assert not found.holds
    assert found.subject == "elbow"
    assert found.slack == pytest.approx(-0.01)
    allowed = joint_positions({"elbow": 0.42}, below={"elbow": 0.03})
    assert check(model, reach(model, END), allowed, When.END)[0].holds
    with pytest.raises(JointNotFound, match="elbow"):
        check(model, reach(model, END), joint_positions({"elbov": 0.0}), When.END)


def test_joint_constraints_hold_between_the_points(model: ReducedModel) -> None:
    """There and back: the extreme is between the ends, exact."""
    there = reach(model, (0.9, 0.2), (-0.5, 0.2))
    wanted = joint_positions({"shoulder": 0.0}, tolerance=0.9)
    (found,) = check(model, there, wanted, When.ALWAYS)
    assert found.holds
    assert found.value == pytest.approx(0.9)
    assert found.time == pytest.approx(0.5, abs=1e-3)
    (found,) = check(model, there, joint_positions({"shoulder": 0.0}, tolerance=0.8999), When.ALWAYS)
    assert not found.holds
    assert found.evidence is Evidence.PROVEN
    (found,) = check(model, there, joint_positions({"elbow": 0.2}, tolerance=0.0), When.ALWAYS)
    assert found.holds


def test_joints_that_follow_or_stand_still_are_known(tmp_path: Path) -> None:
    model = reduced(Scene(mixed_arm(tmp_path)), [0.0, 0.0, 0.0, 0.4])
    trajectory = quintic(model, [[0.0, 0.0, 0.0, 0.4], [0.0, 0.0, 0.0, 1.0]], 1.0)
    assert check(model, trajectory, joint_positions({"j5": -0.4}), When.END)[0].holds
    (found,) = check(model, trajectory, joint_positions({"j5": -0.1}, tolerance=0.2), When.ALWAYS)
    assert not found.holds
    assert found.value == pytest.approx(-0.4)


@pytest.mark.parametrize("coordinates", RotationCoordinates)
def test_frame_goals(model: ReducedModel, coordinates: RotationCoordinates) -> None:
    exact = frame_placement("tip", tip(*END), coordinates=coordinates)
    position, rotation = check(model, reach(model, END), exact, When.END)
    assert position.holds
    assert rotation.holds
    assert position.name == "goal: position"
    turned = tip(*END) * placement((0.0, 0.002, 0.0), rpy=(0, 0, 0.03))
    position, rotation = check(
        model, reach(model, END), frame_placement("tip", turned, coordinates=coordinates), When.END
    )
    assert not position.holds
    assert not rotation.holds
    assert rotation.value == pytest.approx(0.03)
    assert position.value == pytest.approx(0.002 * np.cos(0.03), rel=1e-9), "along the goal's own axes"
    loose = frame_placement(
        "tip", turned, position_tolerance=(1e-3, 3e-3, 1e-3), rotation_tolerance=(0.0, 0.0, 0.031)
    )
    assert all(found.holds for found in check(model, reach(model, END), loose, When.END))
    free = frame_placement("tip", turned, position_tolerance=np.inf, rotation_tolerance=(0.0, 0.0, np.inf))
    (rotation,) = check(model, reach(model, END), free, When.END)
    assert rotation.holds
    with pytest.raises(FrameNotFound, match="tip"):
        check(model, reach(model, END), frame_placement("tipp", turned), When.END)


def test_offset_reference_and_moving_reference(tmp_path: Path) -> None:
    scene = Scene(planar_arm(tmp_path)).add("bin", Sphere(0.01), placement((0.3, 0.7, 0.2), rpy=(0, 0, 1.0)))
    scene = scene.add(
        "cup", Sphere(0.01), placement((0.1, 0.0, 0.0), rpy=(np.pi, 0, 0)), frame="tip", touch_links=["tip"]
    )
    model = reduced(scene, [-0.5, 0.2])
    where = scene.placement_of("bin", model.start).inverse() * (
        tip(*END) * placement((0.1, 0, 0), rpy=(np.pi, 0, 0))
    )
    shifted = Placement(where.rotation, where * np.array((0.0, 0.05, 0.0)))
    wanted = frame_placement("cup", shifted, reference="bin", offset=(0.0, 0.05, 0.0))
    assert all(found.holds for found in check(model, reach(model, END), wanted, When.END))
    missed = frame_placement("cup", shifted, reference="bin")
    assert check(model, reach(model, END), missed, When.END)[0].value == pytest.approx(0.05)
    # Seen from the upper link the tip only turns with the elbow, which stands still.
    seen = frame_placement(
        "tip", placement((0.5 + 0.5 * np.cos(0.2), 0.5 * np.sin(0.2), 0), rpy=(0, 0, 0.2)), reference="upper"
    )
    found = check(model, reach(model, (0.9, 0.2)), seen, When.ALWAYS)
    assert all(one.holds and one.evidence is Evidence.PROVEN for one in found)
    found = check(model, reach(model, (0.9, 0.3)), seen, When.ALWAYS)
    assert not any(one.holds for one in found)
    inverse = frame_placement("upper", seen.placement.inverse(), reference="tip")
    assert all(one.holds for one in check(model, reach(model, (0.9, 0.2)), inverse, When.ALWAYS))


def test_an_axis_within_a_cone(tmp_path: Path) -> None:
    """A wrist that tilts by the angle of its joint."""
    wrist = robot(tmp_path, link("base"), link("cup"), joint("tilt", "base", "cup", axis="0 1 0"))
    model = reduced(Scene(wrist), [0.0])
    tilt = quintic(model, [[0.0], [0.3], [0.0]], 1.0)
    for when, holds in ((When.ALWAYS, False), (When.END, True)):
        (found,) = check(model, tilt, axis_alignment("cup", tolerance=0.299), when)
        assert found.holds == holds
    (found,) = check(model, tilt, axis_alignment("cup", tolerance=0.301), When.ALWAYS)
    assert found.holds
    assert found.evidence is Evidence.PROVEN
    assert found.value == pytest.approx(0.3, abs=1e-6)
    (found,) = check(model, tilt, axis_alignment("cup", tolerance=0.3), When.ALWAYS)
    assert found.holds, "a bound that is just reached is proven, to the accepted excess"
    down = axis_alignment("cup", direction=(0, 0, -1), tolerance=np.pi - 0.301)
    (found,) = check(model, tilt, down, When.ALWAYS)
    assert not found.holds
    assert check(model, tilt, axis_alignment("cup", direction=(1, 0, 0), tolerance=1.58), When.ALWAYS)[
        0
    ].holds
    along = axis_alignment("cup", axis=(0, 1, 0), direction=(0, 1, 0), tolerance=1e-6)
    assert check(model, tilt, along, When.ALWAYS)[0].holds


def test_a_line_is_held_as_well_as_it_is(tmp_path: Path) -> None:
    """Two slides and a turn: the point stays on a line exactly, or bulges by a known amount."""
    gantry = robot(
        tmp_path,
        link("base"), link("a"), link("b"), link("c"),
        joint("x", "base", "a", kind="prismatic", axis="1 0 0"),
        joint("y", "a", "b", kind="prismatic", axis="0 1 0"),
        joint("turn", "b", "c"),
    )  # fmt: skip
    model = reduced(Scene(gantry), [0.0, 0.0, 0.0])
    straight = quintic(model, [[0.0, 0.0, 0.0], [0.5, 0.0, 2.0]], 1.0)
    line = frame_placement(
        "c", Placement(), position_tolerance=(np.inf, 1e-6, 1e-6), rotation_tolerance=np.inf
    )
    (found,) = check(model, straight, line, When.ALWAYS)
    assert found.holds, found.detail
    bulged = quintic(model, [[0.0, 0.0, 0.0], [0.25, 0.01, 1.0], [0.5, 0.0, 2.0]], 1.0)
    tolerant = frame_placement(
        "c", Placement(), position_tolerance=(np.inf, 0.0101, 1e-6), rotation_tolerance=np.inf
    )
    assert check(model, bulged, tolerant, When.ALWAYS)[0].holds
    strict = frame_placement(
        "c", Placement(), position_tolerance=(np.inf, 0.0099, 1e-6), rotation_tolerance=np.inf
    )
    (found,) = check(model, bulged, strict, When.ALWAYS)
    assert not found.holds
    assert found.value == pytest.approx(0.01, abs=2e-4)
    assert found.time == pytest.approx(0.5, abs=0.05)


def test_a_linear_trajectory_is_judged_between_its_corners(model: ReducedModel) -> None:
    corner = Trajectory(
        model.joint_names, np.array((0.0, 0.37, 1.0)), np.array(((-0.5, 0.2), (0.4, 0.2), (-0.5, 0.2)))
    )
    peak = tip(0.4, 0.2)
    wanted = axis_alignment("tip", axis=(1, 0, 0), direction=peak.rotation[:, 0], tolerance=0.8999)
    (found,) = check(model, corner, wanted, When.ALWAYS)
    assert not found.holds
    mirrored = axis_alignment(
        "tip", axis=(1, 0, 0), direction=tip(-0.5, 0.2).rotation[:, 0], tolerance=0.9001
    )
    (found,) = check(model, corner, mirrored, When.ALWAYS)
    assert found.holds
    assert found.time == pytest.approx(0.37)
    assert not check(
        model,
        corner,
        axis_alignment("tip", axis=(1, 0, 0), direction=tip(-0.5, 0.2).rotation[:, 0], tolerance=0.8999),
        When.ALWAYS,
    )[0].holds


@given(seed=st.integers(0, 10**6), coordinates=st.sampled_from(RotationCoordinates))
@MANY
def test_path_verdicts_agree_with_dense_sampling(
    tmp_path: Path, seed: int, coordinates: RotationCoordinates
) -> None:
    """Tolerances a little above or below the densely sampled largest errors."""
    rng = np.random.default_rng(seed)
    arm = mixed_arm(tmp_path)
    model = reduced(Scene(arm), [0.1, -0.2, 0.05, 0.3])
    trajectory = wavy(model, seed, size=rng.choice((0.05, 0.3, 1.0)))
    frame, reference = ("finger", "world") if seed % 2 else ("d", "a")
    offset = rng.uniform(-0.2, 0.2, 3)
    goal = placement(rng.uniform(-0.5, 0.5, 3), rpy=rng.uniform(-1.0, 1.0, 3))
    if seed % 3:
        goal = relative(model, frame, reference, model.start_positions)
    times = np.linspace(0.0, trajectory.duration, 200)
    errors = np.array(
        [error(goal, relative(model, frame, reference, q), offset, coordinates) for q in trajectory(times)]
    )
    largest = np.abs(errors).max(axis=0)
    for factor, holds in ((1.02, True), (0.98, False)):
        wanted = frame_placement(
            frame,
            goal,
            reference=reference,
            position_tolerance=factor * largest[:3] + 1e-5 * holds,
            rotation_tolerance=factor * largest[3:] + 1e-5 * holds,
            coordinates=coordinates,
            offset=offset,
        )
        for found, angles in zip(check(model, trajectory, wanted, When.ALWAYS), (False, True), strict=False):
            singular = coordinates is RotationCoordinates.XYZ_EULER and np.abs(errors[:, 4]).max() > 1.5
            turned = (
                coordinates is RotationCoordinates.ROTATION_VECTOR
                and np.linalg.norm(errors[:, 3:], axis=1).max() > 3.0
            )
            if not (holds and angles and (singular or turned)):
                assert found.holds == holds, found
            if found.holds:
                assert found.evidence is Evidence.PROVEN


def relative(model: ReducedModel, frame: str, reference: str, positions: np.ndarray) -> Placement:
    scene, everything = model.scene, model.all_positions(positions)
    return scene.placement_of(reference, everything).inverse() * scene.placement_of(frame, everything)


def error(
    goal: Placement, seen: Placement, offset: np.ndarray, coordinates: RotationCoordinates
) -> np.ndarray:
    turn = Rotation.from_matrix(goal.rotation.T @ seen.rotation)
    rotation = (
        turn.as_rotvec() if coordinates is RotationCoordinates.ROTATION_VECTOR else turn.as_euler("XYZ")
    )
    return np.concatenate((goal.rotation.T @ (seen * offset - goal.translation), rotation))


@given(seed=st.integers(0, 10**6))
@MANY
def test_axis_verdicts_agree_with_dense_sampling(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])
    trajectory = wavy(model, seed, size=rng.choice((0.05, 0.3, 1.0)))
    axis, direction = rng.normal(size=(2, 3))
    axis, direction = axis / np.linalg.norm(axis), direction / np.linalg.norm(direction)
    if seed % 2:
        direction = relative(model, "finger", "a", model.start_positions).rotation @ axis
    angles = [
        np.arccos(np.clip(relative(model, "finger", "a", q).rotation @ axis @ direction, -1, 1))
        for q in trajectory(np.linspace(0.0, trajectory.duration, 200))
    ]
    for factor, holds in ((1.02, True), (0.98, False)):
        tolerance = factor * max(angles)
        if tolerance < np.pi:
            wanted = axis_alignment(
                "finger", axis=axis, direction=direction, tolerance=tolerance, reference="a"
            )
            (found,) = check(model, trajectory, wanted, When.ALWAYS)
            assert found.holds == holds, found


def test_euler_angles_where_they_are_singular() -> None:
    """Only the sum of the outer angles is known; it goes where the tolerance lets it (MoveIt's rule)."""
    turn = Rotation.from_euler("XYZ", [[0.3, np.pi / 2, 0.4], [0.1, -0.5, 0.2]]).as_matrix()
    turn[np.abs(turn) < 1e-15] = 0.0
    roll = euler_angles(turn, np.array((1.0, 2.0, 0.1)))
    np.testing.assert_allclose(roll, ((0.7, np.pi / 2, 0.0), (0.1, -0.5, 0.2)), atol=1e-9)
    yaw = euler_angles(turn, np.array((0.1, 2.0, 1.0)))
    np.testing.assert_allclose(yaw[0], (0.0, np.pi / 2, 0.7), atol=1e-9)


def test_a_tool_frame_of_the_robot(tmp_path: Path) -> None:
    arm = planar_arm(tmp_path)
    path = tmp_path / "arm.urdf"
    tool = {"pen": FrameAttachment("tip", placement((0.1, 0.0, 0.0)))}
    model = reduced(Scene(type(arm).from_urdf(path, frames=tool)), [-0.5, 0.2])
    wanted = frame_placement("pen", tip(*END) * placement((0.1, 0.0, 0.0)))
    assert all(found.holds for found in check(model, reach(model, END), wanted, When.END))
