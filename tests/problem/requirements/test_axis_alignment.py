"""Axes along directions: formulas, verdicts, and what every kind is asked."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trajopt as to
import trajopt.optimise.terms
from tests.optimise.terms.worlds import World
from tests.problem.requirements.kind import Kind
from tests.problem.requirements.sound import (
    MANY_CONFIGURATIONS,
    MANY_MOTIONS,
    check,
    planar_tip,
    positions,
    relative,
)
from tests.verify.arms import joint, link, mixed_arm, quintic, reduced, robot, wavy
from trajopt.geometry import Query
from trajopt.optimise.terms.alignment import AxisAngle
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import (
    AxisAlignment,
    axis_alignment,
)
from trajopt.problem.residual import Residual
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Evidence, When


@MANY_CONFIGURATIONS
@given(at=positions)
def test_tilt_is_the_angle(odd: ReducedModel, at: tuple[float, ...]) -> None:
    required = to.axis_alignment("tip", axis=(0, 1, 1), direction=(1, 0, 2), tolerance=0.2)
    value = AxisAngle(odd, required).linearise(Motion.single(np.array(at), Query(odd))).value[0]
    frame = odd.scene.placement_of("tip", odd.all_positions(np.array(at)))
    cosine = (frame.rotation @ required.axis) @ required.direction
    assert np.cos(value) == pytest.approx(cosine, abs=1e-9)
    assert 0.0 <= value <= np.pi


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


def test_a_linear_trajectory_is_judged_between_its_corners(model: ReducedModel) -> None:
    corner = Trajectory(
        model.joint_names, np.array((0.0, 0.37, 1.0)), np.array(((-0.5, 0.2), (0.4, 0.2), (-0.5, 0.2)))
    )
    peak = planar_tip(0.4, 0.2)
    wanted = axis_alignment("tip", axis=(1, 0, 0), direction=peak.rotation[:, 0], tolerance=0.8999)
    (found,) = check(model, corner, wanted, When.ALWAYS)
    assert not found.holds
    mirrored = axis_alignment(
        "tip", axis=(1, 0, 0), direction=planar_tip(-0.5, 0.2).rotation[:, 0], tolerance=0.9001
    )
    (found,) = check(model, corner, mirrored, When.ALWAYS)
    assert found.holds
    assert found.time == pytest.approx(0.37)
    assert not check(
        model,
        corner,
        axis_alignment(
            "tip", axis=(1, 0, 0), direction=planar_tip(-0.5, 0.2).rotation[:, 0], tolerance=0.8999
        ),
        When.ALWAYS,
    )[0].holds


@given(seed=st.integers(0, 10**6))
@MANY_MOTIONS
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


def tilt(reference: str) -> Callable[[World], Residual]:
    def build(at: World) -> Residual:
        required = to.axis_alignment(
            "held", axis=(0.1, 0.2, 1.0), direction=(0.3, 0, 1), tolerance=0.1, reference=reference
        )
        return AxisAngle(at.reduced, required)

    return build


AXIS = (0.0, 0.0, 1.0)
KIND = Kind(
    requirement=AxisAlignment,
    printed=[
        (to.axis_alignment("cup", tolerance=np.deg2rad(5)), "z of cup along z of world, within 5 deg"),
        (
            to.axis_alignment("cup", axis=(0, -1, 0), direction=(3, 4, 0), tolerance=0.1, reference="tray"),
            "-y of cup along (0.6, 0.8, 0) of tray, within 5.73 deg",
        ),
    ],
    relaxed=[to.axis_alignment("tip", tolerance=0.3)],
    residuals={AxisAngle: [tilt("world"), tilt("slide")]},
    calls={
        "axis_alignment": {
            "frame": "panda_hand_tcp",
            "axis": AXIS,
            "direction": AXIS,
            "tolerance": 0.1,
            "reference": "world",
        }
    },
)
