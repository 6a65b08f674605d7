"""Depth cameras: intrinsics, lens, placement and noise."""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, above_zero, at_least, floats, number, readonly
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import IDENTITY, WORLD, Placement

STEPS = 50
"""Most Newton steps to undistort; common lenses need five."""
EXACT = 1e-10
"""Tolerance of undistortion in units of the focal length: below a millionth of a pixel."""


@checked
@dataclass(frozen=True)
class Lens(Value):
    """Brown's lens model, as in OpenCV and ROS: "plumb_bob" has five numbers, "rational_polynomial" eight.

    With x, y the slopes of a ray and r2 = x^2 + y^2, the distorted slopes are
    x s + 2 p1 x y + p2 (r2 + 2 x^2) and y s + p1 (r2 + 2 y^2) + 2 p2 x y, where
    s = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3).

    Attributes:
        p1: Tangential, of a lens tilted up or down.
        p2: Tangential, of a lens tilted sideways.
    """

    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0
    k4: float = 0.0
    k5: float = 0.0
    k6: float = 0.0

    def __post_init__(self) -> None:
        for name in ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"):
            object.__setattr__(self, name, number(f"Lens.{name}", getattr(self, name)))

    @property
    def straight(self) -> bool:
        """Whether it has no distortion."""
        radial, tangential = (self.k1, self.k2, self.k3, self.k4, self.k5, self.k6), (self.p1, self.p2)
        return not any((*radial, *tangential))

    def bent(self, slopes: Floats) -> Floats:
        """Return the distorted slopes (..., 2) of rays."""
        return self._bent_with_slope(slopes)[0]

    def straightened(self, slopes: Floats) -> Floats:
        """Return the slopes (..., 2) of the rays with these distorted slopes; NaN if there is no such ray."""
        if slopes.shape[-1:] != (2,):
            raise ShapeError("slopes", f"needs pairs, has shape {slopes.shape}")
        if self.straight:
            return slopes
        found = np.array(slopes)
        with np.errstate(all="ignore"):
            for _ in range(STEPS):
                value, jacobian = self._bent_with_slope(found)
                off = value - slopes
                if not (np.abs(off) > EXACT).any():
                    break
                a, b, c, d = (
                    jacobian[..., 0, 0],
                    jacobian[..., 0, 1],
                    jacobian[..., 1, 0],
                    jacobian[..., 1, 1],
                )
                step = np.stack(
                    (d * off[..., 0] - b * off[..., 1], a * off[..., 1] - c * off[..., 0]), axis=-1
                )
                found = found - step / (a * d - b * c)[..., None]
            value, jacobian = self._bent_with_slope(found)
            # Beyond its turning point the polynomial folds the picture over, or turns it around.
            folded = np.linalg.det(np.nan_to_num(jacobian)) <= 0.0
            turned = np.einsum("...i,...i", found, slopes) < 0.0
            wrong = ~(np.abs(value - slopes) <= 100.0 * EXACT).all(axis=-1) | folded | turned
        found[wrong] = np.nan
        return found

    def stretch(self, slopes: Floats) -> float:
        """Return the largest local magnification of slopes over the given ones (..., 2)."""
        seen = slopes[np.isfinite(slopes).all(axis=-1)]
        return float(np.linalg.norm(self._bent_with_slope(seen)[1], ord=2, axis=(-2, -1)).max())

    def _bent_with_slope(self, slopes: Floats) -> tuple[Floats, Floats]:
        x, y = slopes[..., 0], slopes[..., 1]
        r2 = x * x + y * y
        above = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        below = 1.0 + r2 * (self.k4 + r2 * (self.k5 + r2 * self.k6))
        above_rate = self.k1 + r2 * (2.0 * self.k2 + 3.0 * self.k3 * r2)
        below_rate = self.k4 + r2 * (2.0 * self.k5 + 3.0 * self.k6 * r2)
        scale = above / below
        rate = 2.0 * (above_rate - scale * below_rate) / below
        p1, p2 = self.p1, self.p2
        value = np.stack(
            (
                x * scale + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                y * scale + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            ),
            axis=-1,
        )
        cross = rate * x * y + 2.0 * p1 * x + 2.0 * p2 * y
        along_x = scale + rate * x * x + 2.0 * p1 * y + 6.0 * p2 * x
        along_y = scale + rate * y * y + 6.0 * p1 * y + 2.0 * p2 * x
        jacobian = np.stack(
            (np.stack((along_x, cross), axis=-1), np.stack((cross, along_y), axis=-1)), axis=-2
        )
        return value, jacobian


STRAIGHT = Lens()


Singles: TypeAlias = NDArray[np.float32]
"""Single-precision coordinates: depths are known to a tenth of a millimetre at best."""
MOST_PIXELS = 1 << 26
"""Most pixels of an image."""
ROUNDED_UP = 1.0 + 1e-6
"""Factor that covers the rounding of slopes in single precision."""
BEYOND = 1.05
"""Magnification is evaluated at pixels; between them it differs by far less than this share."""


@checked
@dataclass(frozen=True, eq=False)
class Intrinsics(Value):
    """The viewing direction of each pixel of a camera.

    In the camera's optical frame x points right, y down and z forward. The centre of the top left pixel has
    the coordinates (0, 0), as in ROS and OpenCV.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    lens: Lens = STRAIGHT

    def __post_init__(self) -> None:
        at_least(self, 1, "width", "height")
        above_zero(self, "fx", "fy")
        for name in ("fx", "fy", "cx", "cy"):
            object.__setattr__(self, name, number(f"Intrinsics.{name}", getattr(self, name)))
        if self.width * self.height > MOST_PIXELS:
            raise ShapeError("Intrinsics", f"{self.width} x {self.height} pixels are more than {MOST_PIXELS}")

    @cached_property
    def slopes(self) -> tuple[Singles, Singles]:
        """Slopes of the pixels' rays, x/z and y/z, each broadcastable to (height, width).

        NaN for pixels that no ray reaches.
        """
        across = (np.arange(self.width) - self.cx) / self.fx
        down = (np.arange(self.height) - self.cy) / self.fy
        if self.lens.straight:
            return _single(across[None, :]), _single(down[:, None])
        grid = np.stack(np.broadcast_arrays(across[None, :], down[:, None]), axis=-1)
        straight = self.lens.straightened(grid)
        return _single(straight[..., 0]), _single(straight[..., 1])

    @cached_property
    def widest(self) -> float:
        """Largest slope of a pixel's ray: beyond it a lens model may turn back into the image."""
        across, down = self.slopes
        return float(np.nanmax(np.hypot(across, down))) * ROUNDED_UP

    @property
    def longest_ray(self) -> float:
        """Largest length of a pixel's ray up to a depth of 1."""
        return float(np.hypot(1.0, self.widest))

    @cached_property
    def stretch(self) -> float:
        """Largest magnification of slopes by the lens in the image and a little beyond."""
        if self.lens.straight:
            return 1.0
        across, down = self.slopes
        return self.lens.stretch(np.stack((across, down), axis=-1).astype(np.float64)) * BEYOND

    @cached_property
    def pixel(self) -> float:
        """Largest diagonal of a pixel at a depth of 1; a ray is at most half of it from that of a pixel."""
        straight = 1.0 / self.fy, 1.0 / self.fx
        if self.lens.straight:
            return float(np.hypot(*straight))
        rays = np.stack(self.slopes, axis=-1)
        sides = [np.linalg.norm(np.diff(rays, axis=axis), axis=-1) for axis in (0, 1)]
        return float(np.hypot(*(np.nanmax(each, initial=f) for each, f in zip(sides, straight, strict=True))))

    def pixels_of(self, points: Floats) -> Floats:
        """Return the pixel coordinates of points, (k, 3) in the optical frame [m] -> (k, 2) [pixels].

        NaN for points that are not in front of the camera, or farther aside than any pixel's ray.
        """
        depth = np.where(points[:, 2] > 0.0, points[:, 2], np.nan)
        slopes = points[:, :2] / depth[:, None]
        slopes[np.hypot(slopes[:, 0], slopes[:, 1]) > self.widest] = np.nan
        return self.lens.bent(slopes) * (self.fx, self.fy) + (self.cx, self.cy)


@checked
@dataclass(frozen=True)
class DepthNoise(Value):
    """Standard deviation of a measured depth: a + b z + c z^2 at a depth z.

    Attributes:
        constant: a, independent of the depth [m].
        linear: b, a share of the depth, for time-of-flight cameras.
        quadratic: c, for cameras that triangulate [1/m].
    """

    constant: float = 0.0
    linear: float = 0.0
    quadratic: float = 0.0

    def __post_init__(self) -> None:
        at_least(self, 0.0, "constant", "linear", "quadratic")

    def sigma(self, depth: float) -> float:
        """Return the standard deviation at a depth [m]; it never decreases with the depth."""
        return self.constant + depth * (self.linear + depth * self.quadratic)

    def sigmas(self, depths: NDArray[np.floating]) -> NDArray[np.floating]:
        """Return the standard deviations at depths of any shape [m]."""
        return self.constant + depths * (self.linear + depths * self.quadratic)


NOISELESS = DepthNoise()


@checked
@dataclass(frozen=True, eq=False)
class Camera(Value):
    """A depth camera, fixed in the world or on a robot.

    Attributes:
        frame: "world", a link, a tool frame or an object of the scene.
        placement: Of its optical frame (x right, y down, z forward) in that frame.
        nearest: Smallest measurable depth [m].
        farthest: Largest measurable depth [m].
    """

    intrinsics: Intrinsics
    frame: str = WORLD
    placement: Placement = IDENTITY
    nearest: float = 0.1
    farthest: float = 4.0
    noise: DepthNoise = NOISELESS

    def __post_init__(self) -> None:
        above_zero(self, "nearest", "farthest")
        if not self.nearest < self.farthest < np.inf:
            raise ShapeError("Camera.farthest", f"must be beyond {self.nearest:g} m, is {self.farthest:g} m")

    @checked
    def at(self, scene: Scene, positions: Floats | None) -> Placement:
        """Return the placement of the optical frame in the world.

        Args:
            positions: Of all joints, shape (number of joints,) [rad | m]; None if no joint moves the camera.

        Raises:
            FrameNotFound: If the scene has no such frame.
            ShapeError: If a joint moves the frame and the positions are not one finite number for each joint.
        """
        return placed_on(scene, self.frame, positions) * self.placement


def placed_on(scene: Scene, frame: str, positions: Floats | None) -> Placement:
    """Return the placement of a frame in the world; raises as `Camera.at`."""
    holder = scene.holder(frame)
    if holder.link == WORLD:
        return holder.placement
    if positions is None:
        raise ShapeError("positions", f"are needed: {frame} moves with the robot's joints")
    return scene.placement_of(frame, positions)


def looking_at(eye: Floats, target: Floats) -> Placement:
    """Return the placement of an optical frame that looks from one point at another, without roll."""
    eye, target = floats("eye", eye, (3,)), floats("target", target, (3,))
    forward = target - eye
    length = float(np.linalg.norm(forward))
    if length < 1e-9:
        raise ShapeError("target", "is the place of the camera")
    forward = forward / length
    right = np.cross(forward, (0.0, 0.0, 1.0))
    # Straight up or down every direction is level.
    right = np.array((0.0, -1.0, 0.0)) if np.linalg.norm(right) < 1e-9 else right / np.linalg.norm(right)
    axes = np.stack((right, np.cross(forward, right), forward), axis=1)
    return Placement(readonly(axes.astype(np.float64)), eye)


def _single(values: NDArray[np.floating]) -> Singles:
    single = values.astype(np.float32)
    single.flags.writeable = False
    return single
