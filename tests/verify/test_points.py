"""Requirements about points: the judge's verdicts against dense sampling of independent formulas."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.verify.arms import joint as joint_xml
from tests.verify.arms import link as link_xml
from tests.verify.arms import mixed_arm, quintic, reduced, robot, wavy
from trajopt.model.placement import Placement, placement
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import (
    Requirement,
    distance_between,
    gaze,
    point_on_arc,
    point_on_line,
    point_on_plane,
    position_in_region,
)
from trajopt.model.scene import Scene
from trajopt.model.shapes import Box, Cylinder, Plane, Sphere
from trajopt.model.trajectory import Trajectory
from trajopt.verify import Check, Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import Motion

MANY = settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
OFFSET = np.array((0.05, -0.02, 0.1))


def check(model: ReducedModel, trajectory: Trajectory, wanted: Requirement, when: When) -> tuple[Check, ...]:
    motion = Motion(model, trajectory, kinematics=Kinematics(model), options=VerifyOptions())
    return check_requirement(wanted, motion, when)


@pytest.fixture
def gantry(tmp_path: Path) -> ReducedModel:
    """A point that slides in x and y: its path is known exactly."""
    arm = robot(
        tmp_path,
        link_xml("base"), link_xml("a"), link_xml("b"),
        joint_xml("x", "base", "a", kind="prismatic", axis="1 0 0"),
        joint_xml("y", "a", "b", kind="prismatic", axis="0 1 0"),
    )  # fmt: skip
    return reduced(Scene(arm), [0.0, 0.0])


def verdict(model: ReducedModel, there: Trajectory, wanted: Requirement) -> tuple[bool, Check]:
    found = check(model, there, wanted, When.ALWAYS)
    assert all(one.evidence is Evidence.PROVEN for one in found if one.holds)
    return all(one.holds for one in found), max(found, key=lambda one: -(one.slack or 0.0))


def test_a_union_is_passed_where_members_overlap(gantry: ReducedModel) -> None:
    across = quintic(gantry, [[0.0, 0.0], [1.0, 0.0]], 1.0)
    left, right = placement((0.2, 0, 0)), placement((0.8, 0, 0))
    whole = position_in_region("b", [(Box(0.7, 0.1, 0.1), left), (Box(0.7, 0.1, 0.1), right)])
    assert verdict(gantry, across, whole)[0]
    gap = position_in_region("b", [(Box(0.58, 0.1, 0.1), left), (Box(0.58, 0.1, 0.1), right)])
    holds, worst = verdict(gantry, across, gap)
    assert not holds
    assert worst.time == pytest.approx(0.5, abs=0.05)
    single = position_in_region("b", Box(0.7, 0.1, 0.1), left)
    assert not verdict(gantry, across, single)[0]
    assert check(gantry, across, position_in_region("b", Sphere(0.01), placement((1, 0, 0))), When.END)[
        0
    ].holds


def test_a_corner_of_a_circle_is_cut(gantry: ReducedModel) -> None:
    """A straight way between two points of a circle leaves it by the height of the chord."""
    chord = quintic(gantry, [[0.5, 0.0], [0.5 * np.cos(0.4), 0.5 * np.sin(0.4)]], 1.0)
    height = 0.5 * (1.0 - np.cos(0.2))
    for factor, holds in ((1.001, True), (0.999, False)):
        wanted = point_on_arc("b", Placement(), radius=0.5, sweep=1.0, tolerance=factor * height)
        assert verdict(gantry, chord, wanted)[0] == holds
    short = point_on_arc("b", Placement(), radius=0.5, sweep=0.3, tolerance=height * 1.001)
    holds, worst = verdict(gantry, chord, short)
    assert not holds
    end = 0.5 * np.array((np.cos(0.4) - np.cos(0.3), np.sin(0.4) - np.sin(0.3)))
    reached = check(gantry, chord, short, When.END)[0]
    assert reached.value == pytest.approx(np.linalg.norm(end))
    assert worst.value is not None


def test_the_nearest_moment_of_two_points_is_seen(gantry: ReducedModel) -> None:
    past = quintic(gantry, [[-0.5, 0.1], [0.5, 0.1]], 1.0)
    holds, worst = verdict(gantry, past, distance_between("b", "world", lower=0.1001))
    assert not holds
    assert worst.time == pytest.approx(0.5, abs=0.02)
    assert verdict(gantry, past, distance_between("b", "world", lower=0.0999, upper=0.51))[0]
    assert not verdict(gantry, past, distance_between("b", "world", upper=0.509))[0]


@given(seed=st.integers(0, 10**6), kind=st.integers(0, 5))
@MANY
def test_verdicts_agree_with_dense_sampling(tmp_path: Path, seed: int, kind: int) -> None:
    """Sizes a little above or below what the densely sampled motion needs."""
    rng = np.random.default_rng(seed)
    model = reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])
    there = wavy(model, seed, size=float(rng.choice((0.05, 0.3, 1.0))))
    frame, reference = ("finger", "world") if seed % 2 else ("d", "a")
    where = placement(rng.uniform(-0.3, 0.3, 3), rpy=rng.uniform(-1.0, 1.0, 3))
    scene = model.scene
    dense = []
    for q in there(np.linspace(0.0, there.duration, 300)):
        full = model.all_positions(q)
        dense.append(
            scene.placement_of(reference, full).inverse() * (scene.placement_of(frame, full) * OFFSET)
        )
    x, y, z = (where.inverse() * np.array(dense)).T
    more = {"reference": reference, "offset": OFFSET}
    at, axis = where.translation, where.rotation[:, 2]
    sizes: tuple[tuple[float, Callable[[float], Requirement]], ...] = (
        (np.sqrt(x**2 + y**2 + z**2).max(), lambda s: position_in_region(frame, Sphere(s), where, **more)),
        (np.abs(x).max(), lambda s: position_in_region(frame, Box(2 * s, 20, 20), where, **more)),
        (np.hypot(x, y).max(), lambda s: position_in_region(frame, Cylinder(s, 20), where, **more)),
        (np.hypot(x, y).max(), lambda s: point_on_line(frame, at, axis, tolerance=s, **more)),
        (np.abs(z).max(), lambda s: point_on_plane(frame, at, axis, tolerance=s, **more)),
        (
            np.hypot(np.hypot(x, y) - 2.0, z).max(),
            lambda s: point_on_arc(frame, where, radius=2.0, tolerance=s, **more),
        ),
    )
    needed, build = sizes[kind]
    for factor, holds in ((1.02, True), (0.98, False)):
        if needed * factor < 1.9:
            assert verdict(model, there, build(float(factor * needed)))[0] == holds
    above = position_in_region(frame, Plane(), where * placement((0, 0, float(z.max()) + 1e-3)), **more)
    below = position_in_region(frame, Plane(), where * placement((0, 0, float(z.max()) - 1e-3)), **more)
    assert verdict(model, there, above)[0]
    assert not verdict(model, there, below)[0]


@given(seed=st.integers(0, 10**6))
@MANY
def test_distances_agree_with_dense_sampling(tmp_path: Path, seed: int) -> None:
    model = reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])
    there = wavy(model, seed, size=(0.1, 0.5, 1.0)[seed % 3])
    scene = model.scene
    apart = []
    for q in there(np.linspace(0.0, there.duration, 300)):
        full = model.all_positions(q)
        apart.append(
            np.linalg.norm(
                scene.placement_of("finger", full) * OFFSET - scene.placement_of("a", full).translation
            )
        )
    low, high = min(apart), max(apart)
    for lower, upper, holds in (
        (0.99 * low, 1.01 * high, True),
        (1.01 * low + 1e-4, 1.02 * high, False),
        (0.0, 0.99 * high, False),
    ):
        wanted = distance_between("finger", "a", lower=lower, upper=upper, first_offset=OFFSET)
        assert verdict(model, there, wanted)[0] == holds


@given(seed=st.integers(0, 10**6))
@MANY
def test_gaze_agrees_with_dense_sampling(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])
    there = wavy(model, seed, size=(0.1, 0.5, 1.0)[seed % 3])
    target, axis = rng.uniform(-1.0, 1.0, 3), rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    reference = "world" if seed % 2 else "a"
    scene = model.scene
    angles, distances = [], []
    for q in there(np.linspace(0.0, there.duration, 300)):
        full = model.all_positions(q)
        way = scene.placement_of(reference, full) * target - scene.placement_of("finger", full) * OFFSET
        distances.append(float(np.linalg.norm(way)))
        cosine = way @ (scene.placement_of("finger", full).rotation @ axis) / distances[-1]
        angles.append(float(np.arccos(np.clip(cosine, -1.0, 1.0))))
    if min(distances) < 0.02 or max(angles) > 3.0:
        return
    for factor, holds in ((1.02, True), (0.98, False)):
        wanted = gaze(
            "finger", target, angle=factor * max(angles), axis=axis, origin=OFFSET, reference=reference,
            nearest=0.99 * min(distances), farthest=1.01 * max(distances),
        )  # fmt: skip
        found = check(model, there, wanted, When.ALWAYS)
        assert [one.holds for one in found] == [holds, True, True]
        assert all(one.evidence is Evidence.PROVEN for one in found if one.holds)
    far = gaze(
        "finger",
        target,
        angle=3.1,
        axis=axis,
        origin=OFFSET,
        farthest=0.98 * max(distances),
        reference=reference,
    )
    assert not verdict(model, there, far)[0]
