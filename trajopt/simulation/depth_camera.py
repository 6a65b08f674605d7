"""A depth camera in MuJoCo, exact or with flaws."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from trajopt.scene.camera import Camera, Singles
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, at_least, floats, one_of
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked

if TYPE_CHECKING:
    from trajopt.simulation.studio import DrawnDepth


@checked
@dataclass(frozen=True)
class Flaws(Value):
    """Flaws of a real depth camera beyond noise.

    Attributes:
        beyond: Bound of the noise [standard deviations]; infinite for an unbounded normal distribution.
        lost: Share of random pixels without a measurement.
        edge: A pixel has no measurement if its depth differs from a neighbour's by more than this [m].
        grazing: Largest angle between ray and surface normal with a measurement [rad].
    """

    beyond: float = 3.0
    lost: float = 0.0
    edge: float = float("inf")
    grazing: float = float(np.pi / 2)

    def __post_init__(self) -> None:
        at_least(self, 0.0, "beyond", "lost", "edge", "grazing")
        if self.lost > 1.0:
            raise ProblemError(f"Flaws: lost must be from 0 to 1, is {self.lost:g}")


FLAWLESS = Flaws()


class DepthCamera:
    """A depth camera in a scene; use it in a `with` statement.

    It sees the visual meshes of the robot and the shapes of objects, without the floor of pictures.
    """

    def __init__(self, scene: Scene, group: str, camera: Camera) -> None:
        """Prepare the camera.

        Raises:
            ProblemError: If the camera has lens distortion.
            FrameNotFound: If the frame of the camera does not exist.
        """
        self._scene, self._group = one_of("scene", scene, Scene), one_of("group", group, str)
        self._camera = one_of("camera", camera, Camera)
        if not camera.intrinsics.lens.straight:
            raise ProblemError(
                "camera has lens distortion, but pictures are drawn by a pinhole camera; leave out the lens"
            )
        scene.robot.group(group)
        scene.holder(camera.frame)
        self._drawn: DrawnDepth | None = None

    def __enter__(self) -> "DepthCamera":
        return self

    def __exit__(self, *stop: object) -> None:
        if self._drawn is not None:
            self._drawn.screen.__exit__(None, None, None)
            self._drawn = None

    def exact(self, positions: Floats) -> Singles:
        """Return depths (height, width) [m] at positions of all joints; infinite beyond the range."""
        at = floats("positions", positions, (len(self._scene.robot.joint_names),))
        reduced = reduce_model(self._scene, self._group, at)
        from trajopt.simulation.studio import DrawnDepth

        if self._drawn is None or not np.array_equal(self._fixed(reduced), self._drawn.fixed):
            self.__exit__()
            self._drawn = DrawnDepth(reduced, self._camera, self._fixed(reduced))
        depth = self._drawn.depth(reduced, self._camera.at(self._scene, at))
        depth[(depth < self._camera.nearest) | (depth > self._camera.farthest)] = np.inf
        return depth

    @checked
    def measure(self, positions: Floats, rng: np.random.Generator, flaws: Flaws = FLAWLESS) -> Singles:
        """Return the depths with the noise of the camera; NaN for pixels without a measurement."""
        exact = self.exact(positions)
        seen = np.isfinite(exact)
        depth = np.where(seen, exact, self._camera.farthest)
        off = rng.standard_normal(depth.shape)
        if np.isfinite(flaws.beyond):
            while (wild := np.abs(off) > flaws.beyond).any():
                off[wild] = rng.standard_normal(int(wild.sum()))
        measured = exact + np.where(seen, off * self._camera.noise.sigmas(depth), 0.0)
        measured[_lost(depth, self._camera, flaws) & seen] = np.nan
        measured[rng.random(depth.shape) < flaws.lost] = np.nan
        return measured.astype(np.float32)

    def _fixed(self, reduced: ReducedModel) -> Floats:
        others = [
            count
            for count, name in enumerate(self._scene.robot.joint_names)
            if name not in reduced.moving_joints
        ]
        return reduced.start[others]


def _lost(depth: Floats, camera: Camera, flaws: Flaws) -> NDArray[np.bool_]:
    lost = np.zeros(depth.shape, dtype=np.bool_)
    steps = np.zeros(depth.shape)
    for axis in (0, 1):
        change = np.abs(np.diff(depth, axis=axis))
        before = tuple(slice(0, -1) if each == axis else slice(None) for each in (0, 1))
        after = tuple(slice(1, None) if each == axis else slice(None) for each in (0, 1))
        for side in (before, after):
            lost[side] |= change > flaws.edge
            steps[side] = np.maximum(steps[side], change)
    # At this angle between ray and normal the depth changes by this step between pixels.
    lens = camera.intrinsics
    return lost | (steps > depth / max(lens.fx, lens.fy) * np.tan(min(flaws.grazing, 1.57)))
