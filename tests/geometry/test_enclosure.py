"""Inside an exact mesh: a negative distance, whichever body answers, and a plan that keeps out."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.oracles.query import PlainQuery
from tests.verify.arms import joint, link, reduced, robot
from tests.verify.test_enclosure import EXACT, SOLIDS, crossings, cube, hollow, without_lid
from trajopt.geometry import Query
from trajopt.values.shapes.shapes import Shape

TIP = 0.02
BODIES = (PlainQuery, Query)


def slide(folder: Path, obstacle: Shape, carried: Shape) -> to.Scene:
    rail = joint("x", "base", "hand", kind="prismatic", axis="1 0 0")
    arm = robot(folder, link("base"), link("hand"), rail)
    scene = to.Scene(arm).add("tip", carried, frame="hand", touch_links=["hand"], meshes=EXACT)
    return scene.add("block", obstacle, meshes=EXACT)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("carried", [to.Sphere(TIP), cube(2.0 * TIP)], ids=["sphere", "mesh"])
def test_the_way_to_the_surface_and_its_slope(
    tmp_path: Path, body: type[PlainQuery] | type[Query], carried: Shape
) -> None:
    for obstacle, at, expected, slope in (
        (cube(1.0), 0.2, -(0.3 - TIP), 1.0),
        (cube(1.0), -0.2, -(0.3 - TIP), -1.0),
        (cube(1.0), 0.8, 0.3 - TIP, 1.0),
        (hollow(1.0, 0.6), 0.1, 0.2 - TIP, -1.0),
        (hollow(1.0, 0.6), 0.39, -(0.09 - TIP), -1.0),
        (without_lid(1.0), 0.2, 0.3 - TIP, -1.0),
    ):
        asked = body(reduced(slide(tmp_path, obstacle, carried), [0.0]))
        found = asked.close_pairs(np.array([[at]]), np.array([1.0]))
        assert found.distance == pytest.approx([expected], abs=1e-6)
        assert found.jacobian.ravel() == pytest.approx([slope], abs=1e-6)
        found = asked.close_pairs(np.array([[at]]), np.array([0.001]))
        assert len(found.distance) == (expected < 0.0), "also where the surface is beyond the reach"


@pytest.mark.parametrize("body", BODIES)
def test_a_mesh_around_another_body(tmp_path: Path, body: type[PlainQuery] | type[Query]) -> None:
    asked = body(reduced(slide(tmp_path, cube(0.1), cube(1.0)), [0.0]))
    found = asked.close_pairs(np.array([[0.1]]), np.array([0.0]))
    assert found.distance == pytest.approx([-(0.5 - 0.15)], abs=1e-6)


@pytest.mark.parametrize("which", range(len(SOLIDS)))
def test_random_places_against_the_even_odd_rule(tmp_path: Path, which: int) -> None:
    rng = np.random.default_rng(which)
    mesh, size = SOLIDS[which], 0.01
    arm = robot(tmp_path, link("base"), link("hand"), joint("q", "base", "hand"))
    outside = within = 0
    for _ in range(60):
        where = to.placement(rng.uniform(-1, 1, 3), rotation=Rotation.random(random_state=rng).as_matrix())
        seen = rng.uniform(-0.5, 0.7, 3) * (1.0, 1.0, rng.choice((0.2, 1.0)))
        scene = to.Scene(arm).add("block", mesh, where, meshes=EXACT)
        scene = scene.add("tip", to.Sphere(size), to.placement(where * seen), frame="hand")
        model = reduced(scene, [0.0])
        off = float(mesh.distance(seen[None])[0])
        if off < size + 1e-5:
            continue
        expected = size - off if crossings(seen, mesh, rng) else off - size
        outside, within = outside + (expected > 0.0), within + (expected < 0.0)
        for body in BODIES:
            found = body(model).close_pairs(np.zeros((1, 1)), np.array([2.0]))
            assert found.distance == pytest.approx([expected], abs=1e-6)
    assert outside > 2 and within > 2


def test_a_plan_does_not_end_inside_nor_begin_there(tmp_path: Path) -> None:
    scene = slide(tmp_path, cube(1.0), to.Sphere(TIP))
    outside = scene.robot.positions({"x": -1.0})
    for start, goal in ((outside, 0.0), (scene.robot.positions({"x": 0.0}), -1.0)):
        problem = to.Problem(scene=scene, group="all", start=start, goal=to.joint_positions({"x": goal}))
        result = to.plan(problem)
        assert not result.verified
        assert "tip" in result.reason and "block" in result.reason
