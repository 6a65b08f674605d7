"""Frames at placements: formulas, verdicts, and what every kind is asked."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import trajopt as to
import trajopt.optimise.terms
from tests.optimise.terms.worlds import World
from tests.problem.requirements.kind import Kind
from tests.problem.requirements.sound import (
    END,
    MANY_CONFIGURATIONS,
    MANY_MOTIONS,
    check,
    planar_tip,
    positions,
    reach,
    relative,
)
from tests.verify.arms import joint, link, mixed_arm, planar_arm, quintic, reduced, robot, wavy
from trajopt.geometry import Query
from trajopt.optimise.terms.frame_placement import FramePlacementError
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import (
    FramePlacement,
    RotationCoordinates,
    frame_placement,
)
from trajopt.problem.residual import Residual
from trajopt.robot.robot import FrameAttachment
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.errors import FrameNotFound
from trajopt.values.placement import Placement, placement
from trajopt.values.shapes.shapes import Sphere
from trajopt.verify import Evidence, When
from trajopt.verify.checks.frames import euler_angles

angles = st.floats(-1.4, 1.4)


@MANY_CONFIGURATIONS
@given(at=positions, rpy=st.tuples(angles, angles, angles))
def test_placement_error_rebuilds_the_frame(
    odd: ReducedModel, at: tuple[float, ...], rpy: tuple[float, ...]
) -> None:
    """Composing the goal with the error must give the frame back, in both coordinates."""
    goal = to.placement((0.2, -0.1, 0.4), rpy=rpy)
    frame = odd.scene.placement_of("tip", odd.all_positions(np.array(at)))
    for coordinates in RotationCoordinates:
        required = to.frame_placement("tip", goal, coordinates=coordinates)
        value = FramePlacementError(odd, required).linearise(Motion.single(np.array(at), Query(odd))).value
        error = (
            Rotation.from_rotvec(value[3:])
            if coordinates is RotationCoordinates.ROTATION_VECTOR
            else Rotation.from_euler("XYZ", value[3:])
        )
        assert goal.rotation @ error.as_matrix() == pytest.approx(frame.rotation, abs=1e-7)
        assert goal.translation + goal.rotation @ value[:3] == pytest.approx(frame.translation, abs=1e-9)


@pytest.mark.parametrize("coordinates", RotationCoordinates)
def test_frame_goals(model: ReducedModel, coordinates: RotationCoordinates) -> None:
    exact = frame_placement("tip", planar_tip(*END), coordinates=coordinates)
    position, rotation = check(model, reach(model, END), exact, When.END)
    assert position.holds
    assert rotation.holds
    assert position.name == "goal: position"
    turned = planar_tip(*END) * placement((0.0, 0.002, 0.0), rpy=(0, 0, 0.03))
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
        planar_tip(*END) * placement((0.1, 0, 0), rpy=(np.pi, 0, 0))
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


@pytest.mark.filterwarnings("ignore::trajopt.values.errors.UnitWarning")  # wavy motions go far astray
@given(seed=st.integers(0, 10**6), coordinates=st.sampled_from(RotationCoordinates))
@MANY_MOTIONS
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


def error(
    goal: Placement, seen: Placement, offset: np.ndarray, coordinates: RotationCoordinates
) -> np.ndarray:
    turn = Rotation.from_matrix(goal.rotation.T @ seen.rotation)
    rotation = (
        turn.as_rotvec() if coordinates is RotationCoordinates.ROTATION_VECTOR else turn.as_euler("XYZ")
    )
    return np.concatenate((goal.rotation.T @ (seen * offset - goal.translation), rotation))


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
    wanted = frame_placement("pen", planar_tip(*END) * placement((0.1, 0.0, 0.0)))
    assert all(found.holds for found in check(model, reach(model, END), wanted, When.END))


def frame_error(coordinates: RotationCoordinates, reference: str) -> Callable[[World], Residual]:
    def build(at: World) -> Residual:
        required = to.frame_placement(
            "held",
            to.placement((0.4, 0.1, 0.2), rpy=(0.3, -0.2, 0.5)),
            reference=reference,
            coordinates=coordinates,
            offset=(0.02, -0.01, 0.03),
        )
        return FramePlacementError(at.reduced, required)

    return build


AT, INF = to.placement((0.41, 0.3, 0.14)), np.inf
TOLERANCES: list[tuple[dict[str, Any], str]] = [
    ({}, "within 0.1 mm and 0.0573 deg"),
    (
        {"position_tolerance": 1e-3, "rotation_tolerance": (np.deg2rad(5), np.deg2rad(5), INF)},
        "within 1 mm and 5 deg, free about z",
    ),
    (
        {"position_tolerance": (INF, 1e-3, 2e-3), "rotation_tolerance": INF},
        "within y 1, z 2 mm, free along x, free about x, y, z",
    ),
]
KIND = Kind(
    requirement=FramePlacement,
    printed=[
        (
            to.frame_placement("cup", AT, reference=reference, **tolerances),
            f"cup at (0.41, 0.3, 0.14) m{seen}, {said}",
        )
        for reference, seen in (("world", ""), ("tray", " from tray"))
        for tolerances, said in TOLERANCES
    ],
    relaxed=[
        to.frame_placement(
            "tip", to.placement((0.4, 0.1, 0.2)), position_tolerance=0.05, rotation_tolerance=0.3
        )
    ],
    residuals={
        FramePlacementError: [
            frame_error(coordinates, reference)
            for coordinates in RotationCoordinates
            for reference in ("world", "thing", "slide")
        ]
    },
    calls={
        "frame_placement": {
            "frame": "panda_hand_tcp",
            "placement": AT,
            "position_tolerance": 0.01,
            "rotation_tolerance": 0.1,
            "reference": "world",
            "offset": (0.1, 0.0, 0.2),
        }
    },
)
