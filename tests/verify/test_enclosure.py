"""Bodies inside exact meshes, whose surface they need not touch: penetration at any time of a motion."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.oracles.judge import PlainJudge
from tests.oracles.judge_geometry import inside
from tests.verify.arms import joint, link, reduced, robot
from trajopt.optimise.kinematics import validity
from trajopt.robot.bodies import MeshPolicy
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Bools, Floats
from trajopt.values.placement import placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Shape, Sphere, convex
from trajopt.values.shapes.surfaces import closed_surface
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Check, Judge, Specification

EXACT = MeshPolicy(exact=True)
CORNERS = convex([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
TIP = 0.02
SAME_FOLDER = settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def cube(size: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    return Mesh(CORNERS.vertices * size + np.array(at), CORNERS.faces)


def joined(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def turned(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices, mesh.faces[:, ::-1])


def hollow(size: float, hole: float) -> Mesh:
    return joined(cube(size), turned(cube(hole)))


def without_lid(size: float) -> Mesh:
    mesh = cube(size)
    top = (mesh.triangles[:, :, 2] > 0.4 * size).all(axis=1)
    assert top.sum() == 2
    return Mesh(mesh.vertices, mesh.faces[~top])


@pytest.fixture(params=[PlainJudge, Judge])
def judge(request: pytest.FixtureRequest) -> type[Judge]:
    return request.param


def slide(
    folder: Path,
    obstacle: Shape,
    carried: Shape | None = None,
    *,
    first: float = 0.0,
    last: float = 0.0,
    depth: float = 1.0,
) -> Scene:
    """A body on a slide along x, through an obstacle about the origin."""
    arm = robot(
        folder, link("base"), link("hand"), joint("x", "base", "hand", kind="prismatic", axis="1 0 0")
    )
    tip = Sphere(TIP) if carried is None else carried
    scene = Scene(arm).add("tip", tip, frame="hand", touch_links=["hand"], meshes=EXACT)
    scene = scene.add("block", obstacle, meshes=EXACT)
    if first or last:
        scene = scene.allow_contact("through", "tip", "block", depth=depth, first=first, last=last)
    return scene


def moved(scene: Scene, judge: type[Judge], times: list[float], places: list[float]) -> Certificate:
    """Judge a motion straight from place to place."""
    model = reduced(scene, [places[0]])
    path = Trajectory(model.joint_names, np.array(times), np.array(places)[:, None])
    return judge(model).certify(path, Specification(goals=()))


def named(certificate: Certificate, name: str) -> Check:
    return next(check for check in certificate.checks if check.name == name)


IN_AND_OUT = [0.0, 0.19, 0.38], [-0.52, 0.0, -0.52]
"""Through the surface of a block of 1 m within the first and the last 0.02 s."""


def test_a_body_let_in_and_out_is_found_inside(tmp_path: Path, judge: type[Judge]) -> None:
    certificate = moved(slide(tmp_path, cube(1.0), first=0.02, last=0.02), judge, *IN_AND_OUT)
    check = named(certificate, "clearance")
    assert not certificate.verified and not check.holds
    assert check.value == pytest.approx(-0.5 - TIP, abs=1e-4), "as deep as it is far from outside, at most"
    assert check.time == pytest.approx(0.19, abs=1e-3)
    assert check.subject in ("tip - block", "block - tip")
    assert certificate.clearance < -0.4


def test_a_body_let_in_to_stay_is_found_inside(tmp_path: Path, judge: type[Judge]) -> None:
    for first, last, places in ((0.02, 0.0, [-0.52, 0.0]), (0.0, 0.02, [0.0, -0.52])):
        scene = slide(tmp_path, cube(1.0), first=first, last=last)
        assert not moved(scene, judge, [0.0, 0.2], places).verified


def test_inside_counts_as_depth_while_contact_is_accepted(tmp_path: Path, judge: type[Judge]) -> None:
    deep = moved(slide(tmp_path, cube(1.0), first=9.0, depth=0.6), judge, *IN_AND_OUT)
    assert deep.verified, str(deep)
    assert named(deep, "contact: through").value == pytest.approx(0.5 + TIP, abs=0.02)
    assert deep.clearance == np.inf
    shallow = moved(slide(tmp_path, cube(1.0), first=9.0, depth=0.3), judge, *IN_AND_OUT)
    contact = named(shallow, "contact: through")
    assert not shallow.verified and not contact.holds
    assert contact.value == pytest.approx(0.5 + TIP, abs=1e-4)


def test_windows_that_hold_all_of_the_visit(tmp_path: Path, judge: type[Judge]) -> None:
    scene = slide(tmp_path, cube(0.2), first=0.5, depth=0.2)
    gone = moved(scene, judge, [0.0, 0.4, 1.0], [0.0, 0.3, 0.6])
    assert gone.verified, str(gone)
    # Outside, the clearance is that where the window closes.
    assert 0.75 * 0.23 - 0.02 <= gone.clearance <= 0.23
    assert not moved(scene, judge, [0.0, 0.7, 1.0], [0.0, 0.0, 0.6]).verified


@pytest.mark.parametrize("carried", [cube(0.1), Box(0.1, 0.1, 0.1), convex(0.1 * CORNERS.vertices)])
def test_a_small_body_in_a_large_mesh(tmp_path: Path, judge: type[Judge], carried: Shape) -> None:
    scene = slide(tmp_path, cube(1.0), carried, first=0.05, last=0.05)
    found = named(moved(scene, judge, [0.0, 0.2, 0.4], [-0.52, 0.0, -0.52]), "clearance")
    assert not found.holds and found.value == pytest.approx(-0.55, abs=1e-4)


def test_a_large_mesh_around_a_small_one(tmp_path: Path, judge: type[Judge]) -> None:
    scene = slide(tmp_path, cube(0.1), cube(1.0), first=0.05, last=0.05)
    found = named(moved(scene, judge, [0.0, 0.2, 0.4], [-0.52, 0.0, -0.52]), "clearance")
    assert not found.holds and found.value == pytest.approx(-0.55, abs=1e-4)
    part = joined(cube(0.1), cube(0.1, (0.0, 3.0, 0.0)))
    assert not moved(slide(tmp_path, cube(1.0), part), judge, [0.0, 1.0], [0.0, 0.1]).verified, (
        "one of two parts"
    )


def test_a_body_in_a_hollow_is_outside(tmp_path: Path, judge: type[Judge]) -> None:
    scene = slide(tmp_path, hollow(1.0, 0.6))
    assert not scene.objects["block"].notes[0].endswith("inside")
    certificate = moved(scene, judge, [0.0, 1.0], [0.0, 0.2])
    assert certificate.verified, str(certificate)
    assert certificate.clearance == pytest.approx(0.3 - 0.2 - TIP, abs=1e-3)
    assert not moved(scene, judge, [0.0, 1.0], [0.4, 0.41]).verified, "in the wall"
    assert not moved(scene, judge, [0.0, 1.0], [0.0, 0.4]).verified, "into the wall"
    # From the hollow through a window into the wall, and to stay there.
    through = slide(tmp_path, hollow(1.0, 0.6), first=0.05)
    assert not moved(through, judge, [0.0, 0.05, 1.0], [0.2, 0.4, 0.41]).verified
    # From the wall through a window into the hollow: let out.
    assert moved(through, judge, [0.0, 0.05, 1.0], [0.4, 0.2, 0.0]).verified
    # Inside out as a whole it is the same solid.
    inverted = slide(tmp_path, turned(hollow(1.0, 0.6)))
    assert moved(inverted, judge, [0.0, 1.0], [0.0, 0.2]).verified
    assert not moved(inverted, judge, [0.0, 1.0], [0.4, 0.41]).verified


def test_an_open_surface_has_no_inside_and_reports_it(tmp_path: Path, judge: type[Judge]) -> None:
    scene = slide(tmp_path, without_lid(1.0))
    certificate = moved(scene, judge, [0.0, 1.0], [0.0, 0.2])
    assert certificate.verified, str(certificate)
    assert certificate.clearance == pytest.approx(0.3 - TIP, abs=1e-3)
    assert any("open and so without an inside" in note for note in certificate.notes)
    assert not moved(scene, judge, [0.0, 1.0], [0.0, 0.5]).verified, "its walls are there"
    mixed = slide(tmp_path, joined(without_lid(1.0), cube(0.2)))
    assert not moved(mixed, judge, [0.0, 1.0], [0.0, 0.01]).verified
    assert mixed.objects["block"].notes == (
        "block: exact mesh of 22 triangles; 1 of 2 parts are open and so without an inside",
    )


def test_narrow_holes_leave_a_surface_closed() -> None:
    open_cube = without_lid(1.0)
    for gap, kept in ((1e-3, True), (0.05, False)):
        lid = cube(1.0)
        faces = lid.faces[(lid.triangles[:, :, 2] > 0.4).all(axis=1)]
        corners = lid.vertices.copy()
        corners[:, 0] = np.minimum(corners[:, 0], 0.5 - gap)
        slit = joined(open_cube, Mesh(corners, faces))
        assert inside(np.zeros((1, 3)), slit).tolist() == [kept]


def test_faces_turned_at_random_make_a_hull(tmp_path: Path) -> None:
    faces = CORNERS.faces.copy()
    faces[::3] = faces[::3, ::-1]
    twisted = Mesh(CORNERS.vertices, faces)
    found = closed_surface(twisted)
    assert (found.parts, found.open, found.twisted) == (1, 0, 1)
    assert "hulls count as solid" in found.note
    assert inside(np.array([(0.1, 0.2, -0.3), (0.6, 0.0, 0.0)]), twisted).tolist() == [True, False]


def test_overlapping_parts_need_not_agree_on_their_faces() -> None:
    both = joined(cube(1.0), turned(cube(1.0, (0.5, 0.0, 0.0))))
    points = np.array([(-0.4, 0.1, 0.0), (0.3, 0.1, 0.0), (0.9, 0.1, 0.0), (1.2, 0.0, 0.0)])
    assert inside(points, both).tolist() == [True, True, True, False]


def test_a_configuration_inside_is_examined_as_such(tmp_path: Path, judge: type[Judge]) -> None:
    scene = slide(tmp_path, cube(1.0), first=0.1, depth=0.2)
    model = reduced(scene, [0.0])
    seen = judge(model).examine(np.zeros(1))
    assert not seen.clear
    assert seen.collisions[0].distance == pytest.approx(-0.5 - TIP, abs=1e-4)
    said = validity(model, np.zeros(1))
    assert not said.valid and "inside" in said.reasons[0]
    assert judge(reduced(slide(tmp_path, hollow(1.0, 0.6)), [0.0])).examine(np.zeros(1)).clear


def crossings(point: Floats, mesh: Mesh, rng: np.random.Generator) -> bool:
    """Even-odd rule along a random ray, by Moller and Trumbore's test of each triangle."""
    ray = rng.normal(size=3)
    a, b, c = np.moveaxis(mesh.triangles, 1, 0)
    edge, other = b - a, c - a
    across = np.cross(ray, other)
    scale = np.einsum("ij,ij->i", edge, across)
    from_a = point - a
    u = np.einsum("ij,ij->i", from_a, across) / scale
    sideways = np.cross(from_a, edge)
    v = sideways @ ray / scale
    along = np.einsum("ij,ij->i", other, sideways) / scale
    return bool(((u > 0.0) & (v > 0.0) & (u + v < 1.0) & (along > 0.0)).sum() % 2)


def ring(count: int = 11) -> Mesh:
    """A closed surface that is not convex: a ring of square section about z."""
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    section = np.array([(0.2, -0.1), (0.5, -0.1), (0.5, 0.1), (0.2, 0.1)])
    points = [(r * np.cos(a), r * np.sin(a), z) for a in angle for r, z in section]
    faces: list[tuple[int, int, int]] = []
    for i in range(count):
        for j in range(4):
            a, b = 4 * i + j, 4 * ((i + 1) % count) + j
            c, d = 4 * ((i + 1) % count) + (j + 1) % 4, 4 * i + (j + 1) % 4
            faces += [(a, b, c), (a, c, d)]
    return Mesh(np.array(points), np.array(faces, dtype=np.int32))


SOLIDS = (cube(0.7), hollow(0.9, 0.5), ring(), joined(cube(0.4), cube(0.3, (0.6, 0.1, 0.0))), turned(ring()))


@given(seed=st.integers(0, 10**6), which=st.sampled_from(range(len(SOLIDS))))
@SAME_FOLDER
def test_random_points_against_the_even_odd_rule(tmp_path: Path, seed: int, which: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = SOLIDS[which]
    points = rng.uniform(-0.6, 0.9, (25, 3))
    expected: Bools = np.array([crossings(point, mesh, rng) for point in points])
    assert inside(points, mesh).tolist() == expected.tolist()


@given(seed=st.integers(0, 10**6), which=st.sampled_from(range(len(SOLIDS))), meshed=st.booleans())
@SAME_FOLDER
def test_random_poses_against_the_even_odd_rule(tmp_path: Path, seed: int, which: int, meshed: bool) -> None:
    """A small body is clear exactly if its middle is outside and its surface meets none."""
    rng = np.random.default_rng(seed)
    mesh = SOLIDS[which]
    size = 0.03
    carried: Shape = cube(2.0 * size / np.sqrt(3.0)) if meshed else Sphere(size)
    arm = robot(tmp_path, link("base"), link("hand"), joint("q", "base", "hand"))
    where = placement(rng.uniform(-1.0, 1.0, 3), rotation=Rotation.random(random_state=rng).as_matrix())
    seen = rng.uniform(-0.6, 0.9, 3)
    scene = Scene(arm).add("block", mesh, where, meshes=EXACT)
    turn = Rotation.random(random_state=rng).as_matrix()
    scene = scene.add("tip", carried, placement(where * seen, rotation=turn), frame="hand", meshes=EXACT)
    model = reduced(scene, [0.0])
    off = float(mesh.distance(seen[None])[0])
    for judge in (PlainJudge, Judge):
        examined = judge(model).examine(np.zeros(1))
        if off > size + 1e-5:
            assert examined.clear == (not crossings(seen, mesh, rng))
        elif not meshed:
            assert not examined.clear
        if not examined.clear:
            assert examined.collisions[0].distance < 0.0


@given(seed=st.integers(0, 10**6), which=st.sampled_from(range(len(SOLIDS))))
@SAME_FOLDER
def test_random_motions_with_windows_are_judged_soundly(tmp_path: Path, seed: int, which: int) -> None:
    """What is verified is outside, by the even-odd rule, at every time at which contact is not accepted."""
    rng = np.random.default_rng(seed)
    mesh = SOLIDS[which]
    arm = robot(
        tmp_path,
        link("base"),
        link("rail"),
        link("hand"),
        joint("x", "base", "rail", kind="prismatic", axis="1 0 0"),
        joint("y", "rail", "hand", kind="prismatic", axis="0 1 0"),
    )
    scene = Scene(arm).add("tip", Sphere(TIP), placement((0.01, 0.02, 0.03)), frame="hand")
    scene = scene.allow("tip", "hand").add("block", mesh, meshes=EXACT)
    first, last = rng.uniform(0.05, 0.4, 2).tolist()
    scene = scene.allow_contact("through", "tip", "block", depth=2.0, first=first, last=last)
    places = rng.uniform(-0.7, 0.7, (4, 2))
    model = reduced(scene, places[0])
    path = Trajectory(model.joint_names, np.linspace(0.0, 1.0, 4), places)
    judged = [judge(model).certify(path, Specification(goals=())) for judge in (PlainJudge, Judge)]
    assert len({certificate.verified for certificate in judged}) == 1
    times = np.linspace(first + 1e-6, 1.0 - last - 1e-6, 60)
    points = np.column_stack((path(times), np.zeros(len(times)))) + np.array((0.01, 0.02, 0.03))
    apart = mesh.distance(points) - TIP
    clear = (apart > 0.0) & ~np.array([crossings(point, mesh, rng) for point in points])
    if not clear.all():
        assert not judged[0].verified
    elif apart.min() > 0.05:
        assert judged[0].verified, str(judged[0])
