"""Points in regions, on lines and on planes: formulas, verdicts, and what every kind is asked."""

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
    OFFSET,
    TIP_OFFSET,
    check,
    points,
    positions,
    rpys,
    tip,
    verdict,
    violation,
)
from tests.verify.arms import mixed_arm, quintic, reduced, wavy
from trajopt.optimise.terms import constrain
from trajopt.optimise.terms.positions import RegionCoordinates
from trajopt.problem.requirements import (
    PositionInRegion,
    Requirement,
    point_on_arc,
    point_on_line,
    point_on_plane,
    position_in_region,
)
from trajopt.problem.residual import WHOLE, Residual
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.placement import placement
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere
from trajopt.verify import When


@MANY_CONFIGURATIONS
@given(at=positions, where=points, rpy=rpys, size=st.floats(0.05, 0.8))
def test_regions(
    odd: ReducedModel,
    at: tuple[float, ...],
    where: tuple[float, ...],
    rpy: tuple[float, ...],
    size: float,
) -> None:
    placed = to.placement(where, rpy=rpy)
    x, y, z = placed.inverse() * tip(odd, at, "slide")
    inside = {
        to.Box(size, 2 * size, 0.5 * size): max(abs(x) - size / 2, abs(y) - size, abs(z) - size / 4),
        to.Sphere(size): (x * x + y * y + z * z) ** 0.5 - size,
        to.Cylinder(size, 2 * size): max((x * x + y * y) ** 0.5 - size, abs(z) - size),
        to.Plane(): z,
    }
    for shape, excess in inside.items():
        need = to.position_in_region("tip", shape, placed, reference="slide", offset=TIP_OFFSET)
        assert violation(odd, need, at) == pytest.approx(excess, abs=1e-9)
    union = to.position_in_region(
        "tip",
        [(s, placed) for s in inside if not isinstance(s, to.Plane)],
        reference="slide",
        offset=TIP_OFFSET,
    )
    solid = min(excess for shape, excess in inside.items() if not isinstance(shape, to.Plane))
    assert (violation(odd, union, at) <= 0.0) == (solid <= 0.0)


@MANY_CONFIGURATIONS
@given(at=positions, through=points, direction=rpys)
def test_lines_and_planes(
    odd: ReducedModel, at: tuple[float, ...], through: tuple[float, ...], direction: tuple[float, ...]
) -> None:
    axis = np.array(direction)
    if np.linalg.norm(axis) < 1e-3:
        return
    unit = axis / np.linalg.norm(axis)
    off = tip(odd, at) - np.array(through)
    line = to.point_on_line("tip", through, axis, tolerance=0.01, offset=TIP_OFFSET)
    expected = float(np.linalg.norm(np.cross(off, unit))) - 0.01
    assert violation(odd, line, at) == pytest.approx(expected, abs=1e-8)
    plane = to.point_on_plane("tip", through, axis, tolerance=0.01, offset=TIP_OFFSET)
    assert violation(odd, plane, at) == pytest.approx(abs(float(off @ unit)) - 0.01, abs=1e-8)


def test_the_program_keeps_a_share_of_the_tolerance_in_hand(odd: ReducedModel) -> None:
    need = to.position_in_region("tip", to.Box(0.1, 0.02, 2.0))
    (item,) = constrain(need, odd, WHOLE)
    assert item.upper[:3] == pytest.approx((0.045, 0.009, 0.995))
    (item,) = constrain(to.distance_between("tip", "slide", lower=0.2, upper=0.24), odd, WHOLE)
    assert (item.lower[3], item.upper[3]) == pytest.approx((0.202, 0.238))


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


@given(seed=st.integers(0, 10**6), kind=st.integers(0, 5))
@MANY_MOTIONS
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


def test_bad_input_is_refused() -> None:
    for call in (
        lambda: to.position_in_region("tip", []),
        lambda: to.position_in_region("tip", [(to.Cone(0.1, 0.1), to.placement((0, 0, 0)))]),  # type: ignore[list-item]
        lambda: to.point_on_line("tip", (0, 0, 0), (0, 0, 1), tolerance=0.0),
    ):
        with pytest.raises(ProblemError):
            call()
    with pytest.raises(ShapeError, match="normal"):
        to.point_on_plane("tip", (0, 0, 0), (0, 0, 0), tolerance=0.1)


def region(at: World) -> Residual:
    union = [
        (Box(0.2, 0.3, 0.4), to.placement((0.3, 0.1, 0.2), rpy=(0.1, 0.2, 0.3))),
        (Sphere(0.1), to.placement((-0.2, 0.3, 0.4))),
        (Cylinder(0.1, 0.3), to.placement((0.1, -0.3, 0.3), rpy=(0.5, 0, 0))),
        (Plane(), to.placement((0, 0, -0.2), rpy=(0, 0.2, 0))),
    ]
    return RegionCoordinates(
        at.reduced, to.position_in_region("held", union, reference="slide", offset=(0.01, 0.02, 0.03))
    )


HERE, THREE = to.placement((0.4, 0.1, 0.2)), to.placement((0.5, 0, 0.2))
POINT, AXIS, THERE = (0.1, 0.0, 0.2), (0.0, 0.0, 1.0), to.placement((0.4, 0.0, 0.4), rpy=(np.pi, 0.0, 0.0))
KIND = Kind(
    requirement=PositionInRegion,
    printed=[
        (
            to.position_in_region("tip", to.Sphere(0.05), THREE),
            "tip in a sphere of radius 50 mm at (0.5, 0, 0.2) m",
        ),
        (
            to.position_in_region("tip", to.Box(0.05, 0.2, 0.3), THREE, reference="tray"),
            "tip in a box of 50 mm x 0.2 m x 0.3 m at (0.5, 0, 0.2) m from tray",
        ),
        (
            to.position_in_region("tip", [(to.Cylinder(0.05, 0.2), THREE), (to.Plane(), THREE)]),
            "tip in a cylinder of radius 50 mm and length 0.2 m along z at (0.5, 0, 0.2) m "
            "or below the plane through (0.5, 0, 0.2) m with normal z",
        ),
        (
            to.point_on_line("tip", (0.5, 0, 0.2), (1, 0, 0), tolerance=1e-3),
            "tip on the line through (0.5, 0, 0.2) m along x, within 1 mm",
        ),
        (
            to.point_on_plane("tip", (0.5, 0, 0.2), (0, 0, -1), tolerance=1e-3),
            "tip on the plane through (0.5, 0, 0.2) m with normal -z, within 1 mm",
        ),
    ],
    relaxed=[
        to.position_in_region("tip", shape, HERE)
        for shape in (to.Box(0.2, 0.1, 0.1), to.Sphere(0.1), to.Cylinder(0.1, 0.3), to.Plane())
    ],
    residuals={RegionCoordinates: [region]},
    calls={
        "position_in_region": {"frame": "panda_hand_tcp", "region": to.Box(1, 1, 1), "placement": THERE},
        "point_on_line": {"frame": "panda_hand_tcp", "through": POINT, "direction": AXIS, "tolerance": 0.01},
        "point_on_plane": {"frame": "panda_hand_tcp", "through": POINT, "normal": AXIS, "tolerance": 0.01},
    },
)


@pytest.mark.parametrize(
    "endless",
    [
        point_on_plane("cup", (0.0, 0.0, 0.1), (0.0, 0.0, 1.0), tolerance=0.01),
        point_on_line("cup", (0.0, 0.0, 0.1), (0.0, 0.0, 1.0), tolerance=0.01),
    ],
)
def test_unbounded_regions_are_padded_at_their_bounds(endless: PositionInRegion) -> None:
    """A slab and a tube stand for a plane and a line: their length is the largest that there is."""
    grown = endless.relaxations[0].apply(0.002)
    assert isinstance(grown, PositionInRegion)
    match endless.members[0][0], grown.members[0][0]:
        case (Box() as before, Box() as after):
            assert (after.x, after.y) == (before.x, before.y)
            assert after.z == pytest.approx(before.z + 0.004)
        case (Cylinder() as before, Cylinder() as after):
            assert after.length == before.length
            assert after.radius == pytest.approx(before.radius + 0.002)
        case shapes:
            pytest.fail(f"{shapes} are neither slabs nor tubes")
