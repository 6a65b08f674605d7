"""A depth camera in MuJoCo: what it would measure of a scene, exactly, or as a real one does."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from trajopt.scene.camera import Camera, Singles
from trajopt.scene.reduced import ReducedModel, reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, at_least, floats, one_of
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked

if TYPE_CHECKING:
    from trajopt.simulation.studio import DrawnDepth


@checked
@dataclass(frozen=True)
class Flaws(Value):
    """What a real depth camera does beside noise.

    Attributes:
        beyond: Noise beyond so many standard deviations does not occur [standard deviations]. Infinite for
            a normal distribution as it is.
        lost: Share of pixels that measure nothing, anywhere.
        edge: A pixel measures nothing where the depth changes from it to a neighbour by more than this [m].
        grazing: Nor where the surface is steeper than this to its ray [rad], from facing it.
    """

    beyond: float = 3.0
    lost: float = 0.0
    edge: float = float("inf")
    grazing: float = float(np.pi / 2)

    def __post_init__(self) -> None:
        """Check the numbers."""
        at_least(self, 0.0, "beyond", "lost", "edge", "grazing")
        if self.lost > 1.0:
            raise ProblemError(f"Flaws: lost must be a share, is {self.lost:g}")


FLAWLESS = Flaws()


class DepthCamera:
    """A depth camera among a robot and objects; use it in a `with` statement.

    It sees what pictures show: the robot's visual meshes, and the shapes of objects; no floor that the scene
    does not have.
    """

    def __init__(self, scene: Scene, group: str, camera: Camera) -> None:
        """Set it up.

        Args:
            scene: The robot among objects, as they really are.
            group: The group whose joints move between two measurements; others cost more time.
            camera: The camera; its lens bends nothing.

        Raises:
            ProblemError: If its lens bends rays: it is drawn as a pinhole.
            FrameNotFound: If the scene has no such frame as the camera is fixed on.
        """
        self._scene, self._group = one_of("scene", scene, Scene), one_of("group", group, str)
        self._camera = one_of("camera", camera, Camera)
        if not camera.intrinsics.lens.straight:
            raise ProblemError(
                "camera: its lens bends rays, and pictures are drawn as by a pinhole: leave it out"
            )
        scene.robot.group(group)
        scene.holder(camera.frame)
        self._drawn: DrawnDepth | None = None

    def __enter__(self) -> "DepthCamera":
        """Return itself."""
        return self

    def __exit__(self, *stop: object) -> None:
        """Free the graphics memory."""
        if self._drawn is not None:
            self._drawn.screen.__exit__(None, None, None)
            self._drawn = None

    def exact(self, positions: Floats) -> Singles:
        """Return the depths along its axis, shape (height, width) [m]; infinite where nothing is in range.

        Args:
            positions: Of all joints, shape (number of joints,) [rad | m].

        Raises:
            RenderingUnavailable: If no OpenGL works here.
            ShapeError: If there is not one finite position for each joint.
        """
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
        """Return the depths with the camera's noise, not a number where it measures nothing.

        Args:
            positions: As of `exact`.
            rng: Draws noise and losses.
            flaws: What goes wrong beside noise.

        Raises:
            RenderingUnavailable: If no OpenGL works here.
            ShapeError: If there is not one finite position for each joint.
        """
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
        """Return the positions of what the group does not move."""
        others = [
            count
            for count, name in enumerate(self._scene.robot.joint_names)
            if name not in reduced.moving_joints
        ]
        return reduced.start[others]


def _lost(depth: Floats, camera: Camera, flaws: Flaws) -> NDArray[np.bool_]:
    """Say which pixels measure nothing because of what they look at."""
    lost = np.zeros(depth.shape, dtype=np.bool_)
    steps = np.zeros(depth.shape)
    for axis in (0, 1):
        change = np.abs(np.diff(depth, axis=axis))
        before = tuple(slice(0, -1) if each == axis else slice(None) for each in (0, 1))
        after = tuple(slice(1, None) if each == axis else slice(None) for each in (0, 1))
        for side in (before, after):
            lost[side] |= change > flaws.edge
            steps[side] = np.maximum(steps[side], change)
    # A surface that turns away by this angle recedes by so much from one pixel to the next.
    lens = camera.intrinsics
    return lost | (steps > depth / max(lens.fx, lens.fy) * np.tan(min(flaws.grazing, 1.57)))
