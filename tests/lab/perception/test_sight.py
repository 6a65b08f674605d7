"""What an image sees through: what was there before goes, what nobody saw stays unknown."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import trajopt as to
from tests.lab.perception.scenes import AT, CAN, FRONT, ROBOT, TABLE, camera_over, image
from trajopt.lab.perception import (
    Camera,
    DepthImage,
    DepthNoise,
    Intrinsics,
    Lens,
    Sensing,
    Workspace,
    perceive,
    with_unseen,
)
from trajopt.lab.perception.perceive import RobotMask
from trajopt.lab.perception.sensing import packed
from trajopt.values.errors import ProblemError, SizeError


def test_points_seen_through_are_removed_and_hidden_points_stay() -> None:
    scene, camera, sensing = to.Scene(ROBOT), camera_over(), Sensing(workspace=FRONT, cell=0.01)
    hidden = (np.array((0.25, -0.02, 0.0)), np.array((0.3, 0.02, 0.03)))  # behind the can, from the camera
    before = perceive(scene, image([TABLE, hidden], camera), sensing).cloud
    moved = (CAN[0] + (0.0, 0.25, 0.0), CAN[1] + (0.0, 0.25, 0.0))
    blocked = perceive(scene, image([TABLE, hidden, CAN], camera), sensing, before=before).cloud
    after = perceive(scene, image([TABLE, moved], camera), sensing, before=blocked).cloud
    on_can = (blocked.points[:, 2] > 0.05).sum()
    assert on_can > 50
    there = np.abs(after.points - (CAN[0] + CAN[1]) / 2) < (0.07, 0.07, 0.12)
    assert not (there.all(axis=1) & (after.points[:, 2] > 0.04)).any()  # the can's place is seen through
    assert (after.points[:, 2] > 0.05).sum() > 20  # and there is one where it is now
    # What was behind the can while it stood there was kept; now that its place is seen empty, it is gone.
    low = (np.abs(blocked.points - (0.275, 0.0, 0.02)) < (0.03, 0.03, 0.02)).all(axis=1)
    assert low.sum() > 4
    unseen = perceive(
        scene, DepthImage(camera, np.full((120, 160), np.nan), AT), sensing, before=blocked
    ).cloud
    assert np.array_equal(unseen.keys, blocked.keys)  # a camera that sees nothing forgets nothing
    with pytest.raises(ProblemError, match=r"cells of 0\.01 m"):
        perceive(scene, image([TABLE], camera), Sensing(cell=0.02), before=before)


def test_nothing_that_is_there_is_ever_seen_through() -> None:
    """Random boxes, seen again and again with noise: no point of a surface that is still there goes."""
    noise = DepthNoise(0.001, 0.0, 0.002)
    camera, scene = camera_over(noise=noise), to.Scene(ROBOT)
    rng = np.random.default_rng(8)
    sensing = Sensing(workspace=FRONT, cell=0.01)
    for _ in range(5):
        middle, half = rng.uniform((0.3, -0.3, 0.05), (0.7, 0.3, 0.2)), rng.uniform(0.01, 0.06, 3)
        boxes = [TABLE, (middle - half, middle + half)]
        exact = image(boxes, camera).depth
        sigma, seen = noise.sigmas(np.minimum(exact, 3.0)), np.isfinite(exact)
        noisy = [
            np.where(seen, exact + np.clip(rng.standard_normal(exact.shape), -3.0, 3.0) * sigma, np.inf)
            for _ in range(2)
        ]
        first = perceive(scene, DepthImage(camera, noisy[0], AT), sensing).cloud
        again = perceive(scene, DepthImage(camera, noisy[1], AT), sensing, before=first).cloud
        assert np.isin(first.keys, again.keys).all()


def test_unseen_space_is_solid_and_seen_space_is_not() -> None:
    scene, camera = to.Scene(ROBOT), camera_over()
    shelf = Workspace((0.3, -0.25, 0.02), (0.7, 0.25, 0.3))
    solid = with_unseen(scene, image([TABLE, CAN], camera), Sensing(workspace=shelf), cell=0.02)
    shape = solid.objects["unseen"].parts[0][0]
    assert isinstance(shape, to.Voxels)
    rng = np.random.default_rng(4)
    points = rng.uniform(shelf.lower, shelf.upper, (20_000, 3))
    inside = np.isin(
        np.floor(points / 0.02).astype(int) @ (1, 1000, 1_000_000), shape.keys @ (1, 1000, 1_000_000)
    )
    # By the book: a point is in view if nothing is nearer along its ray.
    where = camera.at(scene, AT)
    rays = points - where.translation
    hit = np.zeros(len(points), dtype=bool)
    for lower, upper in (TABLE, CAN):
        one, other = (lower - where.translation) / rays, (upper - where.translation) / rays
        first, last = np.minimum(one, other).max(axis=-1), np.maximum(one, other).min(axis=-1)
        hit |= (first <= last) & (first < 1.0) & (last > 0.0)
    robot = RobotMask.of(scene, AT).covers(points, 0.02 + 0.04)
    assert (inside | ~hit | robot).all()  # what is hidden is solid
    assert 0.05 < inside.mean() < 0.3  # and much of what is in view is not
    can = ((points > CAN[0]) & (points < CAN[1])).all(axis=1)
    assert can.sum() > 200 and inside[can].all()
    with pytest.raises(ProblemError, match="requires a workspace"):
        with_unseen(scene, image([TABLE], camera), Sensing())
    with pytest.raises(SizeError, match="cubes"):
        with_unseen(scene, image([TABLE], camera), Sensing(workspace=shelf), cell=1e-4)


def test_a_lost_pixel_is_like_its_neighbours_and_a_hole_is_not() -> None:
    scene, camera = to.Scene(ROBOT), camera_over()
    shelf = Workspace((0.35, -0.15, 0.05), (0.65, 0.15, 0.25))
    exact = image([TABLE], camera).depth
    spots, hole = exact.copy(), exact.copy()
    spots[5::8, 5::8] = np.nan
    hole[55:65, 75:85] = np.nan

    def solid(depth: np.ndarray, *, bridged: int = 2) -> int:
        scene_then = with_unseen(
            scene, DepthImage(camera, depth, AT), Sensing(workspace=shelf, bridged=bridged)
        )
        return sum(len(shape.keys) for shape, _ in scene_then.objects["unseen"].parts)

    assert solid(spots) <= solid(exact) + 5 < solid(spots, bridged=0)
    assert solid(hole) > solid(exact)


def test_states_that_unseen_space_beside_the_robot_is_taken_for_free() -> None:
    scene, camera = to.Scene(ROBOT), camera_over()
    around = Workspace((-0.3, -0.3, 0.0), (0.3, 0.3, 0.6))
    sensing = Sensing(workspace=around)
    solid = with_unseen(scene, image([TABLE], camera), sensing, cell=0.02)
    (given,) = solid.objects["unseen"].given
    assert "that no image shows, up to 54.6 mm from where the robot was" in given
    problem = to.Problem(scene=solid, group="panda_arm", start=AT, goal=AT)
    names, start = problem.reduced.joint_names, problem.reduced.start_positions
    rest = np.zeros((2, len(names)))
    motion = to.Trajectory(names, np.array((0.0, 1.0)), np.stack((start, start)), rest, rest)
    assert f"proven given that {given}" in to.judge(problem, motion).notes


def test_states_fewer_cubes_where_less_is_taken_for_the_robot() -> None:
    def count(padding: float) -> int:
        sensing = Sensing(workspace=Workspace((-0.3, -0.3, 0.0), (0.3, 0.3, 0.6)), padding=padding)
        solid = with_unseen(to.Scene(ROBOT), image([TABLE], camera_over()), sensing, cell=0.02)
        (given,) = solid.objects["unseen"].given
        return int(given.split()[3])

    assert 0 < count(0.0) < count(0.02)


def test_states_nothing_where_the_robot_is_outside_the_workspace() -> None:
    far = Workspace((3.0, 3.0, 0.0), (3.2, 3.2, 0.2))
    solid = with_unseen(to.Scene(ROBOT), image([TABLE], camera_over()), Sensing(workspace=far), cell=0.02)
    assert solid.objects["unseen"].given == ()


@pytest.mark.parametrize("lens", [Lens(k1=-0.25, k2=0.06, k3=-0.02), Lens(k1=-0.3), Lens(k1=0.2)])
def test_a_lens_shows_nothing_beside_the_image(lens: Lens) -> None:
    """Far to the side a lens model turns back, and its pixels are those of other places."""
    bent = Intrinsics(160, 120, 120.0, 120.0, 79.5, 59.5, lens)
    camera = Camera(bent, placement=to.placement((2.0, 0.0, 1.0), rpy=(0.0, np.pi / 2, 0.0)), farthest=9.0)
    room = Workspace((2.5, -4.0, -3.0), (4.5, 4.0, 5.0))
    seen = DepthImage(camera, np.full((120, 160), 3.0), AT)
    ((unseen, _),) = (
        with_unseen(to.Scene(ROBOT), seen, Sensing(workspace=room), cell=0.1).objects["unseen"].parts
    )
    every = np.indices((20, 80, 80)).reshape(3, -1).T + np.array((25, -40, -30))
    empty = every[~np.isin(packed(every), packed(unseen.keys))]
    middles = camera.placement.inverse() * ((empty + 0.5) * 0.1)
    rays = np.stack(np.broadcast_arrays(*bent.slopes), axis=-1).reshape(-1, 2)
    aside = cKDTree(rays[np.isfinite(rays).all(axis=1)]).query(middles[:, :2] / middles[:, 2:])[0]
    assert len(empty) > 4000 and aside.max() < bent.pixel
