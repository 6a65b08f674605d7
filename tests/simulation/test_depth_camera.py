"""The depth camera measures to a hundredth of a millimetre, and errs as requested."""

import numpy as np
import pytest

import trajopt as to
from tests.lab.perception.scenes import AT, CAN, ROBOT, SMALL, TABLE, camera_over, depth_of
from trajopt.lab.perception import (
    Camera,
    DepthImage,
    DepthNoise,
    Intrinsics,
    Lens,
    Sensing,
    looking_at,
    perceive,
)
from trajopt.simulation import DepthCamera, Flaws
from trajopt.values.errors import FrameNotFound, GroupNotFound, ProblemError, RenderingUnavailable, ShapeError

OFF_CENTRE = Intrinsics(160, 120, 131.0, 125.0, 70.3, 66.1)


@pytest.fixture(scope="module", autouse=True)
def opengl() -> None:
    from trajopt.simulation.studio import open_context

    try:
        open_context(16, 16).free()
    except RenderingUnavailable as error:
        pytest.skip(str(error))


def boxes_scene() -> to.Scene:
    scene = to.Scene(ROBOT)
    for name, (lower, upper) in (("table", TABLE), ("can", CAN)):
        scene = scene.add(name, to.Box(*(upper - lower)), to.placement((lower + upper) / 2))
    return scene


@pytest.mark.parametrize("lens", [SMALL, OFF_CENTRE])
def test_depths_equal_those_of_ray_casting(lens: Intrinsics) -> None:
    scene = boxes_scene()
    # Low and from the side the robot is not in view.
    where = looking_at(np.array((1.3, 0.3, 0.25)), np.array((0.55, -0.1, 0.05)))
    camera = Camera(lens, placement=where, nearest=0.2, farthest=3.0)
    with DepthCamera(scene, "panda_arm", camera) as eye:
        drawn = eye.exact(AT)
    rays = depth_of([TABLE, CAN], camera, where)
    both = np.isfinite(drawn) & np.isfinite(rays)
    robot = np.isfinite(drawn) & ~np.isfinite(rays)
    assert (
        both.mean() > 0.3 and robot.mean() < 0.2 and (np.isfinite(rays) & ~np.isfinite(drawn)).mean() < 0.002
    )
    off = np.abs(drawn[both] - rays[both])
    assert np.percentile(off, 99) < 1e-4 and (off > 1e-3).mean() < 0.01  # of pixels on edges


def test_camera_on_the_hand_moves_with_it() -> None:
    scene = boxes_scene()
    camera = Camera(
        SMALL, frame="panda_hand", placement=to.placement((0.08, 0.0, 0.0)), nearest=0.05, farthest=3.0
    )
    turned = np.array(AT)
    turned[5] -= 0.2
    opened = np.array(turned)
    opened[-2:] = 0.03  # the fingers are not of the group
    with DepthCamera(scene, "panda_arm", camera) as eye:
        for at in (AT, turned, opened):
            points = perceive(scene, DepthImage(camera, eye.exact(at), at)).cloud.points
            on = (points[:, 2] < 0.003) & (points[:, 2] > -0.003)
            assert on.sum() > 300


def test_noise_has_the_stated_size_and_bound() -> None:
    noise = DepthNoise(0.002, 0.0, 0.001)
    scene, camera = boxes_scene(), camera_over(noise=noise)
    with DepthCamera(scene, "panda_arm", camera) as eye:
        exact = eye.exact(AT)
        measured = eye.measure(AT, np.random.default_rng(0), Flaws(beyond=2.5))
        again = eye.measure(AT, np.random.default_rng(0), Flaws(beyond=2.5))
        wild = eye.measure(AT, np.random.default_rng(0), Flaws(beyond=np.inf))
    assert np.array_equal(measured, again, equal_nan=True)
    seen = np.isfinite(exact)
    assert np.array_equal(seen, np.isfinite(measured))
    share = (measured[seen] - exact[seen]) / noise.sigmas(exact)[seen]
    assert np.abs(share).max() <= 2.501 and 0.9 < share.std() < 1.0 and abs(share.mean()) < 0.05
    assert np.abs((wild[seen] - exact[seen]) / noise.sigmas(exact)[seen]).max() > 3.0


def test_holes_are_at_edges_and_grazing_surfaces() -> None:
    scene, camera = boxes_scene(), camera_over()
    with DepthCamera(scene, "panda_arm", camera) as eye:
        exact = eye.exact(AT)
        at_edges = np.isnan(eye.measure(AT, np.random.default_rng(0), Flaws(edge=0.05)))
        anywhere = np.isnan(eye.measure(AT, np.random.default_rng(0), Flaws(lost=0.1)))
        grazing = np.isnan(eye.measure(AT, np.random.default_rng(0), Flaws(grazing=np.deg2rad(30))))
    jump = np.zeros(exact.shape, dtype=bool)
    jump[:, 1:] |= np.abs(np.diff(np.minimum(exact, 3.0), axis=1)) > 0.05
    jump[1:] |= np.abs(np.diff(np.minimum(exact, 3.0), axis=0)) > 0.05
    assert 0.0 < at_edges.mean() < 0.1 and at_edges[jump & np.isfinite(exact)].all()
    assert 0.08 < anywhere.mean() < 0.12
    assert grazing.mean() > at_edges.mean()


def test_measured_points_are_within_the_cloud_of_the_surface() -> None:
    """With noise within the model, every point of the true surface in view is in a ball of the cloud."""
    noise = DepthNoise(0.001, 0.0, 0.002)
    scene, camera = boxes_scene(), camera_over(noise=noise)
    with DepthCamera(scene, "panda_arm", camera) as eye:
        exact, measured = eye.exact(AT), eye.measure(AT, np.random.default_rng(1))
    empty = to.Scene(ROBOT)
    truth = perceive(empty, DepthImage(camera, exact, AT), Sensing(cell=1e-3)).cloud
    seen = perceive(empty, DepthImage(camera, measured, AT), Sensing(padding=0.0)).cloud
    from scipy.spatial import cKDTree

    farthest = cKDTree(seen.points).query(truth.points)[0].max()
    assert farthest <= seen.radius.whole + truth.radius.cell


def test_lens_distortion_is_refused() -> None:
    scene = boxes_scene()
    with pytest.raises(ProblemError, match="lens distortion"):
        DepthCamera(scene, "panda_arm", Camera(Intrinsics(64, 48, 50, 50, 31.5, 23.5, Lens(k1=0.1))))
    with pytest.raises(FrameNotFound, match="panda_hnd"):
        DepthCamera(scene, "panda_arm", Camera(SMALL, frame="panda_hnd"))
    with pytest.raises(GroupNotFound, match="panda_am"):
        DepthCamera(scene, "panda_am", Camera(SMALL))
    with DepthCamera(scene, "panda_arm", Camera(SMALL)) as eye, pytest.raises(ShapeError, match="positions"):
        eye.exact(AT[:2])
    with pytest.raises(ProblemError, match="lost"):
        Flaws(lost=2.0)
