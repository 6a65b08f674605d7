"""A depth image becomes a cloud that contains what was measured, and not the robot."""

import numpy as np
import pytest

import trajopt as to
from tests.lab.perception.scenes import AT, CAN, FRONT, ROBOT, SMALL, TABLE, camera_over, image
from trajopt.lab.perception import (
    Camera,
    DepthImage,
    DepthNoise,
    Intrinsics,
    Lens,
    PointCloud,
    Sensing,
    Workspace,
    perceive,
)
from trajopt.lab.perception.perceive import RobotMask
from trajopt.values.errors import (
    FrameNotFound,
    ModelError,
    ObjectNotFound,
    ProblemError,
    ShapeError,
    SizeError,
)
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Shape


def measured_points(taken: DepthImage, scene: to.Scene) -> np.ndarray:
    """Unproject pixel by pixel, by the book."""
    camera, where = taken.camera, taken.where(scene)
    lens = camera.intrinsics
    rows, columns = np.nonzero(np.isfinite(taken.metres) & (taken.metres > 0.0))
    z = taken.metres[rows, columns].astype(np.float64)
    local = np.stack(((columns - lens.cx) / lens.fx * z, (rows - lens.cy) / lens.fy * z, z), axis=1)
    return where * local


def farthest_outside(points: np.ndarray, cloud: to.Points) -> float:
    """Return how far the farthest point is from the nearest centre."""
    from scipy.spatial import cKDTree

    return float(cKDTree(cloud.points).query(points)[0].max())


def test_every_measured_point_is_within_a_ball() -> None:
    scene, taken = to.Scene(ROBOT), image([TABLE, CAN], camera_over())
    seen = perceive(scene, taken, Sensing(workspace=FRONT, cell=0.01))
    points = measured_points(taken, scene)
    inside = ((points > FRONT.lower) & (points < FRONT.upper)).all(axis=1)
    clear = ~RobotMask.of(scene, AT).covers(points, 0.02 + 0.01)
    assert (inside & clear).sum() > 3000
    shape = seen.cloud.shape
    assert shape is not None
    assert farthest_outside(points[inside & clear], shape) <= seen.cloud.radius.cell
    assert seen.scene.objects["camera"].parts[0][0].radius == pytest.approx(seen.cloud.radius.whole)


def test_single_precision_takes_no_point_out_of_its_ball() -> None:
    """Points at the corners of cells, as far as sensors measure by default: the cell beside may be taken."""
    rng, scene, cell = np.random.default_rng(9), to.Scene(ROBOT), 0.005
    where = to.placement((0.7, -0.4, 0.2), rpy=(0.3, -1.1, 2.2))
    corners = np.round(rng.uniform(-20.0, 20.0, (100_000, 3)) / cell) * cell
    corners = corners[np.abs(corners).max(axis=1) > 3.0]
    corners += rng.uniform(-2e-6, 2e-6, corners.shape)
    points = (where.inverse() * corners).astype(np.float32)
    seen = perceive(scene, PointCloud(points, AT, placement=where), Sensing(cell=cell, padding=0.0))
    assert farthest_outside(where * points.astype(np.float64), seen.cloud.shape) <= seen.cloud.radius.whole


@pytest.mark.parametrize("lens", [Lens(k1=-0.25, k2=0.06, k3=-0.02), Lens(k1=0.2)])
def test_the_surface_between_pixels_of_a_lens_is_within_the_balls(lens: Lens) -> None:
    """A lens that shrinks the border of the image sees more between two pixels there."""
    bent = Intrinsics(80, 60, 60.0, 60.0, 39.5, 29.5, lens)
    camera = Camera(bent, placement=to.placement((2.0, 0.0, 1.0), rpy=(0.0, np.pi / 2, 0.0)))
    seen = perceive(
        to.Scene(ROBOT), DepthImage(camera, np.full((60, 80), 1.5), AT), Sensing(cell=1e-3, tilt=0.0)
    )
    pixels = np.random.default_rng(0).uniform((0.0, 0.0), (79.0, 59.0), (20_000, 2))
    slopes = lens.straightened((pixels - (bent.cx, bent.cy)) / 60.0)
    wall = camera.placement * (1.5 * np.column_stack((slopes, np.ones(len(slopes)))))
    assert farthest_outside(wall, seen.cloud.shape) <= seen.cloud.radius.whole
    assert seen.cloud.radius.gap < 2.5 * 1.5 * np.hypot(1.0, 1.0) / 60.0 / 2.0


def test_the_surface_between_pixels_is_within_the_balls() -> None:
    scene, sensing = to.Scene(ROBOT), Sensing(workspace=FRONT, cell=0.01, padding=0.0)
    coarse = camera_over(intrinsics=SMALL)
    seen = perceive(scene, image([TABLE], coarse), sensing)
    rng = np.random.default_rng(0)
    # Points of the table's top that the camera has in view and not at its edge.
    top = np.column_stack((rng.uniform(0.3, 0.7, 4000), rng.uniform(-0.2, 0.2, 4000), np.zeros(4000)))
    assert farthest_outside(top, seen.cloud.shape) <= seen.cloud.radius.whole
    assert seen.cloud.radius.gap > 0.005  # a hundredth of a metre between pixels, and a tilt of 60 degrees


def test_noise_within_the_model_stays_within_the_balls() -> None:
    noise = DepthNoise(0.001, 0.0, 0.003)
    camera = camera_over(noise=noise)
    scene, exact = to.Scene(ROBOT), image([TABLE, CAN], camera)
    rng = np.random.default_rng(3)
    off = np.clip(rng.standard_normal(exact.depth.shape), -3.0, 3.0) * noise.sigmas(exact.depth)
    noisy = DepthImage(camera, exact.depth + np.where(np.isfinite(off), off, 0.0), AT)
    seen = perceive(scene, noisy, Sensing(workspace=Workspace((0, -1, -1), (1, 1, 1)), padding=0.0))
    truth = measured_points(exact, scene)
    clear = ~RobotMask.of(scene, AT).covers(truth, 0.03)
    radius = seen.cloud.radius
    assert farthest_outside(truth[clear], seen.cloud.shape) <= radius.cell + radius.noise
    without = perceive(scene, noisy, Sensing(sigmas=0.0)).cloud.radius
    assert without.noise == 0.0 and radius.noise > 3.0 * 0.001


def test_the_robot_and_attached_objects_are_removed() -> None:
    scene = to.Scene(ROBOT).add(
        "rod", to.Box(0.04, 0.04, 0.3), to.placement((0, 0, 0.25)), frame="panda_hand"
    )
    where = scene.placement_of("rod", AT)
    rng = np.random.default_rng(1)
    within = where * rng.uniform((-0.02, -0.02, -0.15), (0.02, 0.02, 0.15), (500, 3))
    links = np.concatenate(
        [scene.placement_of(b.frame, AT) * (b.placement * b.shape.vertices) for b in ROBOT.bodies[:9]]
    )
    beside = np.array(((0.6, 0.6, 0.6), (0.6, -0.6, 0.6)))
    cloud = PointCloud(np.concatenate((within, links, beside)), AT)
    seen = perceive(scene, cloud)
    assert len(seen.cloud) == 2
    assert np.abs(seen.cloud.points - beside[::-1]).max() < 0.005
    assert seen.cloud.counts["cells taken for the robot"] > 300
    free = to.plan(to.Problem(scene=seen.scene, group="panda_arm", start="ready", goal="extended"))
    assert free.status is not to.Status.START_IN_COLLISION


@pytest.mark.parametrize(
    "shape",
    [
        to.Sphere(0.1),
        to.Box(0.2, 0.1, 0.3),
        to.Cylinder(0.1, 0.3),
        to.Capsule(0.1, 0.2),
        to.Cone(0.1, 0.3),
        to.convex(np.random.default_rng(5).normal(0.0, 0.1, (30, 3))),
        to.Points(np.random.default_rng(6).normal(0.0, 0.1, (30, 3)), 0.02),
        to.Voxels(np.random.default_rng(7).integers(-5, 5, (30, 3)), 0.02),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_the_padding_is_kept_around_every_shape(shape: Shape) -> None:
    """What is nearer than the padding, by Coal, is always covered; what is clearly farther is not."""
    import coal

    from trajopt.verify.kernel.shapes import coal_geometry

    turned = to.placement((0.3, 0.1, 0.5), rpy=(0.4, -0.3, 0.8))
    scene = to.Scene(ROBOT).add("thing", shape, turned, frame="panda_hand")
    where = scene.placement_of("thing", AT)
    rng = np.random.default_rng(2)
    points = where * rng.uniform(-0.4, 0.4, (400, 3))
    mask, padding = RobotMask.of(to.Scene(ROBOT).add("thing", shape, where), AT, ("thing",)), 0.05
    bare = RobotMask.of(to.Scene(ROBOT), AT)
    covered = mask.covers(points, padding) & ~bare.covers(points, padding)
    shapes = [(coal_geometry(each), place) for each, place in _pieces(shape)]
    request = coal.DistanceRequest()
    for point, found in zip(points, covered.tolist(), strict=True):
        apart = min(
            coal.distance(
                geometry,
                coal.Transform3s((where * place).rotation, (where * place).translation),
                coal.Sphere(1e-6),
                coal.Transform3s(np.eye(3), point),
                request,
                coal.DistanceResult(),
            )
            for geometry, place in shapes
        )
        if bare.covers(point[None], padding)[0]:
            continue
        assert found or apart > padding - 1e-5
        assert not found or apart < 2.0 * padding + 0.02


def _pieces(shape: Shape) -> list[tuple[Shape, to.Placement]]:
    if isinstance(shape, to.Points):
        return [(to.Sphere(shape.radius), to.placement(point)) for point in shape.points]
    if isinstance(shape, to.Voxels):
        return [(to.Box(*[shape.size] * 3), to.placement(point)) for point in shape.centres]
    return [(shape, to.placement())]


def test_a_known_object_is_left_out() -> None:
    scene = to.Scene(ROBOT).add("table", to.Box(0.7, 1.0, 0.1), to.placement((0.55, 0.0, -0.05)))
    sensing = Sensing(workspace=FRONT, known=("table",))
    taken = image([TABLE, CAN], camera_over())
    heights = perceive(scene, taken, sensing).cloud.points[:, 2]
    assert heights.min() > 0.015 and heights.max() > 0.18
    with pytest.raises(ObjectNotFound, match="table"):
        perceive(to.Scene(ROBOT), taken, sensing)


@pytest.mark.parametrize("wall", [0.0, 0.01])
def test_measurements_inside_a_known_bin_stay(wall: float) -> None:
    """Of triangles, open as sheets or closed as plates: within the bin's hull, and no part of the bin."""
    scene = to.Scene(ROBOT).add(
        "bin", _bin(0.4, 0.2, wall), to.placement((0.6, 0.0, 0.0)), meshes=to.MeshPolicy(exact=True)
    )
    rng = np.random.default_rng(8)
    inside = rng.uniform((0.55, -0.05, 0.04), (0.65, 0.05, 0.1), (400, 3))
    floor = rng.uniform((0.45, -0.15, 0.0), (0.75, 0.15, 0.01), (400, 3))
    sensing = Sensing(known=("bin",), padding=0.02)
    assert len(perceive(scene, PointCloud(inside, AT), sensing).cloud) > 300
    assert len(perceive(scene, PointCloud(floor, AT), sensing).cloud) == 0


def _bin(wide: float, high: float, wall: float) -> Mesh:
    """Return a floor and four walls: sheets, or plates where they are so thick [m]."""
    plates = [((wide, wide, wall), (0.0, 0.0, wall / 2.0))]
    for side in (-1.0, 1.0):
        plates.append(((wall, wide, high), (side * wide / 2.0, 0.0, high / 2.0)))
        plates.append(((wide, wall, high), (0.0, side * wide / 2.0, high / 2.0)))
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    hull = to.convex(corners).faces
    vertices = np.concatenate([corners * size + middle for size, middle in plates])
    faces = np.concatenate([hull + 8 * number for number in range(len(plates))])
    return Mesh(vertices, faces)


def test_the_object_is_replaced_whole() -> None:
    scene, camera = to.Scene(ROBOT), camera_over()
    first = perceive(scene, image([TABLE, CAN], camera)).scene.allow("camera", "panda_link0")
    second = perceive(first, image([TABLE], camera)).scene
    assert list(second.objects) == ["camera"] and second.may_touch("camera", "panda_link0")
    fresh = perceive(scene, image([TABLE], camera)).scene.objects["camera"].parts[0][0]
    assert np.array_equal(second.objects["camera"].parts[0][0].points, fresh.points)
    gone = perceive(second, image([], camera)).scene
    assert gone.objects["camera"].parts == () and gone.may_touch("camera", "panda_link0")


def test_a_cloud_takes_the_place_of_no_other_object() -> None:
    scene = to.Scene(ROBOT).add("table", to.Box(1, 1, 0.1))
    with pytest.raises(ModelError, match="'table' is not a cloud"):
        scene.with_cloud("table", to.Points(np.zeros((1, 3)), 0.01))
    with pytest.raises(ModelError, match="cloud must be"):
        scene.with_cloud("camera", np.zeros((1, 3)))
    with pytest.raises(ModelError, match="taken by a frame"):
        scene.with_cloud("panda_hand", None)


def test_several_cameras_see_more() -> None:
    scene = to.Scene(ROBOT)
    one = camera_over()
    other = Camera(
        SMALL, frame="panda_hand", placement=to.placement((0.05, 0.0, 0.0)), nearest=0.1, farthest=2.0
    )
    both = perceive(scene, [image([TABLE, CAN], one), image([TABLE, CAN], other)])
    alone = [perceive(scene, image([TABLE, CAN], each)).cloud for each in (one, other)]
    assert len(both.cloud) > max(map(len, alone))
    assert {*both.cloud.keys} == {*alone[0].keys} | {*alone[1].keys}


def test_a_camera_on_a_link_moves_with_it() -> None:
    scene = to.Scene(ROBOT)
    camera = Camera(SMALL, frame="panda_hand", placement=to.placement((0.05, 0.0, 0.0)), farthest=2.0)
    elsewhere = np.array(AT)
    elsewhere[0] += 0.3
    tops = [perceive(scene, image([TABLE], camera, at=at)).cloud.points for at in (AT, elsewhere)]
    for points in tops:
        assert (
            len(points) > 200 and np.abs(points[:, 2]).max() <= 0.0026
        )  # in the cells beside the table's top
    assert np.abs(tops[0].mean(axis=0) - tops[1].mean(axis=0)).max() > 0.1


def test_whole_numbers_are_millimetres() -> None:
    camera, scene = camera_over(), to.Scene(ROBOT)
    exact = image([TABLE, CAN], camera)
    raw = np.where(np.isfinite(exact.depth), exact.depth * 1000.0, 0.0).round().astype(np.uint16)
    as_read = DepthImage(camera, raw, AT)
    apart = np.abs(as_read.metres - exact.metres)[np.isfinite(exact.metres)]
    assert apart.max() <= as_read.rounding + 1e-6
    radius = [perceive(scene, each).cloud.radius.noise for each in (as_read, exact)]
    assert radius[0] >= 0.0005 and radius[1] == 0.0
    with pytest.raises(ShapeError, match=r"millimetres\? Give scale=0.001"):
        DepthImage(camera, raw.astype(np.float64) + 200.0, AT)
    assert np.allclose(DepthImage(camera, raw.astype(np.float32), AT, scale=1e-3).metres, as_read.metres)


def test_an_image_without_measurements_adds_no_object() -> None:
    camera, scene = camera_over(), to.Scene(ROBOT)
    for nothing in (np.nan, np.inf, -np.inf, 0.0, -1.0, 0.05, 3.5):
        empty = DepthImage(camera, np.full((120, 160), nothing), AT)
        seen = perceive(scene, empty)
        assert len(seen.cloud) == 0 and seen.cloud.shape is None and seen.scene.objects["camera"].parts == ()
    assert to.plan(to.Problem(scene=seen.scene, group="panda_arm", start="ready", goal="extended")).verified
    for none in (np.empty((0, 3)), [], np.full((10, 3), np.nan)):
        assert len(perceive(scene, PointCloud(none, AT)).cloud) == 0


def test_points_that_are_not_finite_are_skipped() -> None:
    points = np.array(((0.5, 0.5, 0.5), (np.nan, 0.0, 0.0), (0.0, np.inf, 1.0), (0.6, 0.5, 0.5)))
    assert len(perceive(to.Scene(ROBOT), PointCloud(points, AT)).cloud) == 2


def test_masked_pixels_are_skipped() -> None:
    camera, scene = camera_over(), to.Scene(ROBOT)
    exact = image([TABLE, CAN], camera)
    for raw in (exact.depth, np.full(exact.depth.shape, 700, dtype=np.uint16)):
        cut = np.array(raw)
        cut[:60] = 0
        mask = np.zeros(raw.shape, dtype=np.bool_)
        mask[:60] = True
        masked = perceive(scene, DepthImage(camera, np.ma.array(raw, mask=mask), AT)).cloud
        assert np.array_equal(masked.keys, perceive(scene, DepthImage(camera, cut, AT)).cloud.keys)


def test_a_million_points() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform((-1, -1, 0), (1, 1, 0.02), (1_000_000, 3)) + np.array((0.0, 0.0, 1.5))
    seen = perceive(to.Scene(ROBOT), PointCloud(points, AT), Sensing(cell=0.02))
    assert 10_000 <= len(seen.cloud) <= 21_000
    some = points[::997].astype(np.float32)
    assert farthest_outside(some, seen.cloud.shape) <= seen.cloud.radius.whole


def test_wrong_input_is_refused_by_name() -> None:
    camera, scene = camera_over(), to.Scene(ROBOT)
    good = np.ones((120, 160))
    with pytest.raises(ShapeError, match=r"depth.*needs shape \(120, 160\).*has \(160, 120\)"):
        DepthImage(camera, good.T, AT)
    with pytest.raises(ShapeError, match=r"depth.*must be numbers"):
        DepthImage(camera, good > 0, AT)
    with pytest.raises(FrameNotFound, match=r"'panda_hnd'.*panda_hand"):
        perceive(scene, DepthImage(Camera(SMALL, frame="panda_hnd"), good, AT))
    with pytest.raises(ShapeError, match="positions"):
        perceive(scene, DepthImage(camera, good, AT[:3]))
    with pytest.raises(ShapeError, match="positions"):
        DepthImage(camera, good, np.full(9, np.nan))
    with pytest.raises(ShapeError, match=r"points.*shape \(any, 3\)"):
        PointCloud(np.zeros((4, 2)), AT)
    with pytest.raises(ShapeError, match=r"points: has nothing nearer than 100 m: is it in millimetres\?"):
        PointCloud([[800.0, 20.0, 300.0], [np.nan] * 3, [0.0] * 3], AT)
    with pytest.raises(ProblemError, match="at least one"):
        perceive(scene, [])
    with pytest.raises(ShapeError, match=r"Workspace\.upper"):
        Workspace((0, 0, 0), (1, 0, 1))
    with pytest.raises(ProblemError, match="cell must be positive"):
        Sensing(cell=0.0)
    with pytest.raises(SizeError, match="too small"):
        Sensing(workspace=Workspace((0, 0, 0), (100, 1, 1)), cell=1e-5)
    with pytest.raises(ShapeError, match=r"Camera\.farthest"):
        Camera(SMALL, nearest=2.0, farthest=1.0)


def test_a_cloud_of_points_inside_the_robot_alone_is_empty() -> None:
    scene = to.Scene(ROBOT)
    inside = np.concatenate(
        [scene.placement_of(b.frame, AT) * (b.placement * b.shape.sphere[0])[None] for b in ROBOT.bodies[:9]]
    )
    seen = perceive(scene, PointCloud(inside, AT))
    assert len(seen.cloud) == 0 and seen.cloud.counts["cells taken for the robot"] == len(inside)
