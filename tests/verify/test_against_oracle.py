"""The native core against its oracle in plain Python: the same distances, verdicts, torques and extremes."""

from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.oracles.judge import PlainJudge, PlainKinematics
from tests.oracles.judge_distances import PlainDistances
from tests.oracles.judge_geometry import inside
from tests.oracles.judge_polynomials import largest, smallest
from tests.verify.arms import joint, link, mixed_arm, quintic, reduced, robot, wavy
from tests.verify.test_clearance import densest
from tests.verify.test_distances import CLOUD, SOLIDS, cube_mesh
from trajopt.robot.bodies import MeshPolicy
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.placement import Placement, placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Plane, Shape, Sphere, convex
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Examination, Judge, Specification, VerifyOptions
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.pair_distances import PairDistances

ERROR = 1e-6
SAME_FOLDER = settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
EXACT = MeshPolicy(exact=True)


def bowl(count: int = 24) -> Mesh:
    """A closed non-convex surface: a ring of square section about z."""
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    section = np.array([(0.2, -0.05), (0.3, -0.05), (0.3, 0.05), (0.2, 0.05)])
    points = [(r * np.cos(a), r * np.sin(a), z) for a in angle for r, z in section]
    faces: list[tuple[int, int, int]] = []
    for i in range(count):
        for j in range(4):
            a, b = 4 * i + j, 4 * ((i + 1) % count) + j
            c, d = 4 * ((i + 1) % count) + (j + 1) % 4, 4 * i + (j + 1) % 4
            faces += [(a, b, c), (a, c, d)]
    return Mesh(np.array(points), np.array(faces, dtype=np.int64))


SHAPES: tuple[Shape, ...] = (*SOLIDS, Plane(), cube_mesh(), bowl())


def both(model: ReducedModel) -> tuple[PairDistances, PlainDistances]:
    return PairDistances(Kinematics(model), error=ERROR), PlainDistances(model, error=ERROR)


def two_bodies(folder: Path, first: Shape, second: Shape, where: Placement) -> ReducedModel:
    arm = robot(folder, link("base"), link("a"), joint("j", "base", "a"))
    scene = Scene(arm).add("fixed", first, meshes=EXACT)
    return reduced(scene.add("moved", second, where, frame="a", meshes=EXACT), [0.0])


@pytest.mark.parametrize(
    ("first", "second"),
    [
        pair
        for pair in combinations_with_replacement(SHAPES, 2)
        if not all(isinstance(s, Plane) for s in pair)
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_distances(tmp_path: Path, first: Shape, second: Shape) -> None:
    rng = np.random.default_rng(5)
    for reach in (0.0, 0.05, 0.15, 0.3, 0.8):
        direction = rng.normal(size=3)
        where = placement(
            reach * direction / np.linalg.norm(direction),
            rotation=Rotation.random(random_state=rng).as_matrix(),
        )
        native, plain = both(two_bodies(tmp_path, first, second, where))
        rest = np.zeros((1, 1))
        poses = PlainKinematics(plain.reduced).poses(rest)
        cell, pair = np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64)
        found, oracle = (float(own.measure(poses, cell, pair)[0]) for own in (native, plain))
        assert found == pytest.approx(oracle, abs=2e-6 if oracle > 0.0 else 1e-4)
        assert (found > 0.0) == (oracle > 0.0)
        deep, sure = (float(own.search_depths(poses, cell, pair)[0]) for own in (native, plain))
        # Both stop where no gap nearby is larger by more than 1e-10 m.
        assert deep == pytest.approx(sure, abs=1e-7)
        if not isinstance(first, Plane) and not isinstance(second, Plane):
            hulls = [float(own.measure_hulls(poses, cell, pair)[0]) for own in (native, plain)]
            assert hulls[0] == pytest.approx(hulls[1], abs=2e-6 if hulls[1] > 0.0 else 1e-4)
        nearest = [float(own.nearest(poses)[0]) for own in (native, plain)]
        assert nearest[0] == pytest.approx(nearest[1], abs=2e-6 if nearest[1] > 0.0 else 1e-4)


def test_a_large_hull_is_climbed_to_its_farthest_vertex(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    ball = rng.normal(size=(2000, 3))
    large = convex(0.2 * ball / np.linalg.norm(ball, axis=1)[:, None] * (1.0, 0.6, 1.7))
    assert len(large.vertices) > 256, "small hulls are searched vertex by vertex"
    for _ in range(20):
        where = placement(rng.uniform(-1.0, 1.0, 3), rpy=rng.uniform(-3.0, 3.0, 3))
        native, plain = both(two_bodies(tmp_path, large, convex(CLOUD), where))
        poses, item = PlainKinematics(plain.reduced).poses(np.zeros((1, 1))), np.zeros(1, dtype=np.int64)
        found = native.measure(poses, item, item)[0]
        assert found == pytest.approx(plain.measure(poses, item, item)[0], abs=1e-4)


def test_points_inside_a_fine_mesh_are_found_by_its_far_field(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    ring = bowl(300)
    points = rng.uniform(-0.35, 0.35, (60, 3)) * (1.0, 1.0, 0.3)
    within, depth = inside(points, ring), ring.distance(points)
    assert (within & (depth > 0.002)).any() and (~within & (depth > 0.002)).any()
    for point, is_within, off in zip(points, within, depth, strict=True):
        model = two_bodies(tmp_path, ring, Sphere(0.001), placement(point))
        kinematics = Kinematics(model)
        native = PairDistances(kinematics, error=ERROR)
        poses, item = kinematics.poses(np.zeros((1, 1))), np.zeros(1, dtype=np.int64)
        found = float(native.measure(poses, item, item)[0])
        assert (found < 0.0) == bool(is_within or off <= 0.001 + ERROR)


def test_a_hull_that_coal_refuses_has_a_depth(tmp_path: Path) -> None:
    """A vertex with more than 255 neighbours."""
    model = two_bodies(tmp_path, bowl(300), Box(0.1, 0.1, 0.1), placement((0.25, 0.0, 0.08)))
    seen = Judge(model).examine(np.zeros(1))
    assert seen.collisions[0].distance == pytest.approx(-0.02, abs=1e-4)


def crowded(folder: Path, rng: np.random.Generator) -> ReducedModel:
    """An arm that carries something among things of all kinds, exact meshes and a half-space too."""
    scene = Scene(mixed_arm(folder))
    for a, b in (("a", "c"), ("c", "finger"), ("b", "d"), ("a", "d"), ("a", "finger"), ("b", "finger")):
        scene = scene.allow(a, b)
    kinds = [shape for shape in SHAPES if not isinstance(shape, Plane)]
    for number in range(4):
        shape = kinds[int(rng.integers(len(kinds)))]
        where = placement(rng.uniform(-1.1, 1.4, 3), rpy=rng.uniform(-3.0, 3.0, 3))
        scene = scene.add(f"thing {number}", shape, where, meshes=EXACT)
    scene = scene.add("floor", Plane(), placement((0.0, 0.0, rng.uniform(-1.2, -0.2))))
    scene = scene.allow("floor", "base").allow("floor", "a")
    held = kinds[int(rng.integers(len(kinds)))]
    scene = scene.add("held", held, placement((0.5, 0.0, 0.0)), frame="d", meshes=EXACT)
    for name in ("b", "c", "d", "finger"):
        scene = scene.allow("held", name)
    return reduced(scene, [0.1, -0.2, 0.05, 0.3])


def judged(model: ReducedModel, trajectory: Trajectory, judge: type[Judge]) -> Certificate:
    return judge(model).certify(trajectory, Specification(goals=()))


@given(seed=st.integers(0, 10**6))
@SAME_FOLDER
def test_certificates(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = crowded(tmp_path, rng)
    trajectory = wavy(model, seed, size=float(rng.uniform(0.1, 0.8)))
    if seed % 3 == 0:
        trajectory = Trajectory(trajectory.joint_names, trajectory.times, trajectory.positions)
    native, plain = (judged(model, trajectory, judge) for judge in (Judge, PlainJudge))
    assert [(check.name, check.holds) for check in native.checks] == [
        (check.name, check.holds) for check in plain.checks
    ]
    if plain.verified or native.checks[0].holds:
        assert native.clearance <= densest(model, trajectory, 200) + 1e-9, "the proof is sound"
        assert native.clearance >= min(plain.clearance - VerifyOptions().resolution, VerifyOptions().far)
    else:
        assert native.checks[0].evidence is plain.checks[0].evidence
    for mine, oracle in zip(native.checks[1:], plain.checks[1:], strict=True):
        assert mine.slack == pytest.approx(oracle.slack, abs=1e-7)
    assert [seen.clear for seen in ends(model, trajectory, Judge)] == [
        seen.clear for seen in ends(model, trajectory, PlainJudge)
    ]


def ends(model: ReducedModel, trajectory: Trajectory, judge: type[Judge]) -> list[Examination]:
    own = judge(model)
    return [own.examine(trajectory.positions[row]) for row in (0, -1)]


@given(seed=st.integers(0, 10**6))
@SAME_FOLDER
def test_kinematics_torques_and_extremes(tmp_path: Path, seed: int) -> None:
    model = reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])
    native, plain = Kinematics(model), PlainKinematics(model)
    motion = JudgedMotion(model, wavy(model, seed), kinematics=plain, options=VerifyOptions())
    positions = motion.trajectory(np.linspace(0.0, 2.0, 7))
    mine, oracle = native.poses(positions), plain.poses(positions)
    for one, other in zip(
        (mine.rotation, mine.translation), (oracle.rotation, oracle.translation), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-12)
    np.testing.assert_array_equal(mine.configurations, oracle.configurations)
    rates = np.random.default_rng(seed).normal(size=(2, 7, len(model.mimic_matrix)))
    np.testing.assert_allclose(native.torques(positions, *rates), plain.torques(positions, *rates), atol=1e-9)
    for functions in motion.group:
        oracles = largest(functions), smallest(functions)
        for one, other in zip(functions.extremes(), oracles, strict=True):
            np.testing.assert_allclose(one.values, other.values, rtol=1e-8, atol=1e-8)


def test_far_obstacles_cost_no_distances(tmp_path: Path) -> None:
    scene = Scene(mixed_arm(tmp_path)).add("near", Box(0.1, 0.1, 0.1), placement((1.3, 0.4, 0.2)))
    counts: list[int] = []
    rng = np.random.default_rng(0)
    for number in range(60):
        if number in (10, 59):
            model = reduced(scene, [0.1, -0.2, 0.05, 0.3])
            trajectory = quintic(model, [[0.1, -0.2, 0.05, 0.3], [0.3, 0.1, 0.1, 0.2]], 1.0)
            counts.append(judged(model, trajectory, Judge).counts.distances)
        away = rng.normal(size=3)
        where = placement(6.0 * away / np.linalg.norm(away))
        scene = scene.add(f"far {number}", Box(0.3, 0.3, 0.3), where)
    assert counts[0] == counts[1]
