"""A robot, a camera and what they look at: exact depths by rays, computed without the code that is tested."""

import numpy as np

import trajopt as to
from trajopt.lab.perception import Camera, DepthImage, DepthNoise, Intrinsics, Workspace, looking_at
from trajopt.simulation import DepthCamera

SMALL = Intrinsics(160, 120, 131.0, 131.0, 79.5, 59.5)
"""A quarter of a usual camera in each direction."""
VGA = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)


def panda() -> to.Robot:
    return to.load("panda")


def ready(robot: to.Robot) -> np.ndarray:
    named = robot.state("ready")
    return np.array([named.get(name, 0.0) for name in robot.joint_names])


def camera_over(
    table: float = 0.0, *, intrinsics: Intrinsics = SMALL, noise: DepthNoise | None = None
) -> Camera:
    """Return a camera beside the robot that looks down on a table in front of it."""
    where = looking_at(np.array((1.1, 0.1, 0.9 + table)), np.array((0.5, 0.0, table)))
    return Camera(intrinsics, placement=where, nearest=0.2, farthest=3.0, noise=noise or DepthNoise())


def depth_of(boxes: list[tuple[np.ndarray, np.ndarray]], camera: Camera, where: to.Placement) -> np.ndarray:
    """Return depths of boxes along the world's axes (lower, upper corner), by the slabs that rays cross."""
    across, down = camera.intrinsics.slopes
    across, down = np.broadcast_arrays(across, down)
    rays = np.stack((across, down, np.ones_like(across)), axis=-1).astype(np.float64) @ where.rotation.T
    depth = np.full(across.shape, np.inf)
    for lower, upper in boxes:
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (lower - where.translation) / rays, (upper - where.translation) / rays
        first, last = np.minimum(one, other).max(axis=-1), np.maximum(one, other).min(axis=-1)
        hit = (first <= last) & (first > 0.0)
        depth = np.where(hit & (first < depth), first, depth)
    return depth


TABLE = (np.array((0.2, -0.5, -0.1)), np.array((0.9, 0.5, 0.0)))
CAN = (np.array((0.45, -0.05, 0.0)), np.array((0.55, 0.05, 0.2)))

ROBOT = panda()
AT = ready(ROBOT)
FRONT = Workspace((0.1, -0.6, -0.2), (1.0, 0.6, 0.5))


def image(boxes: list, camera: Camera, *, at: np.ndarray = AT) -> DepthImage:
    return DepthImage(camera, depth_of(boxes, camera, camera.at(to.Scene(ROBOT), at)), at)


def cameras(scene: to.Scene, group: str) -> dict[str, object]:
    """Return a depth camera, an image of it, and the same camera in MuJoCo, by their classes."""
    camera = Camera(Intrinsics(16, 12, 13.0, 13.0, 7.5, 5.5))
    taken = DepthImage(camera, np.ones((12, 16)), np.zeros(len(scene.robot.joint_names)))
    return {"Camera": camera, "DepthImage": taken, "DepthCamera": DepthCamera(scene, group, camera)}
