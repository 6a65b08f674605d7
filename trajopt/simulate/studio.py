"""The studio draws robot, objects and the tool's path at one moment of a motion."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, floats
from trajopt.errors import ShapeError
from trajopt.io.engine import mujoco
from trajopt.model.placement import Placement
from trajopt.model.reduced import ReducedModel, tool_frame, tool_point
from trajopt.model.trajectory import Trajectory
from trajopt.simulate.camera import FIELD_OF_VIEW, CameraView, automatic_view, visible_points
from trajopt.simulate.controller import in_group_order
from trajopt.simulate.film import labelled
from trajopt.simulate.offscreen import Image, Offscreen
from trajopt.simulate.rollout import Rollout, SequenceLog
from trajopt.simulate.spec import scalar_first
from trajopt.simulate.stage import adapt_to_camera, picture_spec

PATH_COLOUR = (0.10, 0.45, 0.75, 1.0)
"""Colour of the line that the tool draws."""
PATH_RADIUS = 0.003
"""Its radius, as a share of half the size of what is shown."""
PATH_POINTS = 61
"""Points of that line."""
NEAR_TOOL = 0.1
"""Objects closer to the tool than this do not count as hiding it from the camera [m]."""
SAME_PICTURE = 1e-5
"""Joints that moved less than this [rad | m] give the same picture."""
GHOST = 0.22
"""Opacity of the earlier moments in a superposed picture."""
MOST_SAMPLES = 100_000
"""Most samples that a planned motion is drawn with."""
MOST_PICTURES = 100_000
"""Most frames of one film."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Positions of a group over time, wherever they come from; linear between samples.

    Attributes:
        times: Increasing from 0, shape (k,), k >= 2 [s].
        positions: Shape (k, n) [rad | m].
        loose: An object that moves by itself; empty for none.
        placements: Of that object in the world, k of them.
    """

    times: Floats
    positions: Floats
    loose: str = ""
    placements: tuple[Placement, ...] = ()

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.times[-1])

    def loose_at(self, t: float) -> Placement:
        """Return where the loose object is at the last sample before a time."""
        return self.placements[max(int(np.searchsorted(self.times, t, side="right")) - 1, 0)]

    def __call__(self, t: float) -> Floats:
        """Return the positions at a time, shape (n,)."""
        after = min(int(np.searchsorted(self.times, t, side="right")), len(self.times) - 1)
        before = after - 1
        share = (t - self.times[before]) / (self.times[after] - self.times[before])
        return self.positions[before] + float(np.clip(share, 0.0, 1.0)) * (
            self.positions[after] - self.positions[before]
        )


def motion_of(reduced: ReducedModel, motion: Rollout | Trajectory | SequenceLog) -> Motion:
    """Return a planned or simulated motion as positions over time.

    Raises:
        ModelError: If its joints are not the group's.
    """
    if isinstance(motion, SequenceLog):
        columns = reduced.scene.robot.index(reduced.joint_names)
        return Motion(motion.times, motion.positions[:, columns], motion.loose, motion.placements)
    if isinstance(motion, Rollout):
        if motion.joint_names != reduced.joint_names:
            in_group_order(reduced, motion.trajectory)  # raises
        if len(motion.times) == 1:  # it blew up at once
            return Motion(np.array((0.0, 1e-3)), np.repeat(motion.positions, 2, axis=0))
        return Motion(motion.times, motion.positions)
    trajectory = in_group_order(reduced, motion)
    step = max(0.01, trajectory.duration / MOST_SAMPLES)
    between = step * np.arange(int(trajectory.duration / step) + 1)
    times = np.array(sorted({*between.tolist(), *trajectory.times.tolist()}))
    return Motion(times, trajectory(times))


def moments_of(motion: Motion, moments: Sequence[float] | None) -> Floats:
    """Return the times to show [s]: those stated, or start, end and two between.

    Raises:
        ShapeError: If there are none, or one is outside the motion.
    """
    end = motion.duration
    if moments is None:
        # Even shares of the path, not of the time: most happens in the middle of a motion.
        steps = np.linalg.norm(np.diff(motion.positions, axis=0), axis=1) + 1e-6 * np.diff(motion.times)
        way = np.append(0.0, np.cumsum(steps))
        places = np.searchsorted(way / way[-1], (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0))
        return motion.times[places]
    times = floats("moments", moments, (None,))
    if len(times) == 0 or (times < 0.0).any() or (times > end + 1e-9).any():
        raise ShapeError("moments", f"need at least one, each from 0 to {end:g} s")
    return times


def frame_times(motion: Motion, fps: float) -> Floats:
    """Return the time of every frame of a film [s].

    Raises:
        ShapeError: If there are too many.
    """
    if motion.duration * fps > MOST_PICTURES:
        raise ShapeError(
            "fps", f"of {fps:g} over {motion.duration:g} s makes more than {MOST_PICTURES} pictures"
        )
    return np.array([k / fps for k in range(int(motion.duration * fps + 1.5))])


class Studio:
    """A visual model, a camera and a drawing context; use it in a `with` statement."""

    def __init__(
        self,
        reduced: ReducedModel,
        motion: Motion,
        *,
        width: int,
        height: int,
        shadow: int,
        pictures: int,
        camera: CameraView | None,
        highlight: frozenset[str] = frozenset(),
    ) -> None:
        """Set everything up.

        Args:
            reduced: Robot and scene.
            motion: What will be shown.
            width: Of the pictures [pixels].
            height: Of the pictures [pixels].
            shadow: Edge of the square that shadows are computed on [pixels].
            pictures: How many moments one picture may show.
            camera: The camera; chosen when None.
            highlight: Links and objects that are drawn in a colour of their own.

        Raises:
            RenderingUnavailable: If no OpenGL works here.
        """
        self._reduced, self._motion = reduced, motion
        on_the_way = [motion(motion.duration * share) for share in np.linspace(0.0, 1.0, 9)]
        shown = visible_points(reduced, np.array(on_the_way))
        spec = picture_spec(reduced, shown, loose=motion.loose, highlight=highlight)
        spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
        spec.visual.global_.fovy = np.rad2deg(FIELD_OF_VIEW)
        spec.visual.quality.shadowsize = shadow
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        names = tuple(reduced.model.names[1:])
        self._address = [self._model.jnt_qposadr[self._model.joint(name).id] for name in names]
        tool = tool_frame(reduced)
        self._moments = [motion.duration * k / (PATH_POINTS - 1) for k in range(PATH_POINTS)]
        self._path = np.array([tool_point(reduced, tool, motion(t)) for t in self._moments])
        view = camera or automatic_view(shown, self._path, width / height, self._share_seen)
        adapt_to_camera(self._model, view.azimuth, view.distance)
        self._camera = _mujoco_camera(view)
        self._options = mujoco.MjvOption()
        room = (pictures + 1) * self._model.ngeom + 2 * PATH_POINTS
        self._scene = mujoco.MjvScene(self._model, room)
        self._screen = Offscreen(self._model, width, height)

    def __enter__(self) -> "Studio":
        """Return itself."""
        return self

    def __exit__(self, *stop: object) -> None:
        """Free the graphics memory."""
        self._screen.__exit__(None, None, None)

    def pictures(self, times: Floats, report: Callable[[float], None]) -> Iterator[Image]:
        """Draw the moments one by one."""
        drawn, picture = None, None
        for count, t in enumerate(times):
            positions = self._seen(float(t))
            if picture is None or drawn is None or np.abs(positions - drawn).max() > SAME_PICTURE:
                self._compose(float(t))
                drawn, picture = positions, self._screen.picture(self._scene)
            yield labelled(picture, f"{t:.2f} s")
            report((count + 1) / (len(times) + 1))

    def superposed(self, times: Floats) -> Image:
        """Draw the last moment solid and the others translucent."""
        self._compose(float(times[-1]))
        for t in times[:-1]:
            self._pose(float(t))
            first = self._scene.ngeom
            dynamic = mujoco.mjtCatBit.mjCAT_DYNAMIC.value
            mujoco.mjv_addGeoms(
                self._model, self._data, self._options, mujoco.MjvPerturb(), dynamic, self._scene
            )
            for geom in self._scene.geoms[first : self._scene.ngeom]:
                geom.rgba[3] = GHOST
        return self._screen.picture(self._scene)

    def _share_seen(self, eye: Floats) -> float:
        """Return the share of the motion during which the tool is visible from a point (3,) in the world."""
        seen = 0
        looks = range(0, PATH_POINTS, PATH_POINTS // 6)
        for k in looks:
            self._pose(self._moments[k])
            ray = self._path[k] - eye
            share = mujoco.mj_ray(self._model, self._data, eye, ray, None, True, -1, None)
            # What is nearer to the tool than this is the hand itself, or what it carries.
            seen += not 0.0 <= share < 1.0 - NEAR_TOOL / float(np.linalg.norm(ray))
        return seen / len(looks)

    def _seen(self, t: float) -> Floats:
        """Return numbers that are equal for equal pictures."""
        where = self._motion.loose_at(t).homogeneous.ravel() if self._motion.loose else ()
        return np.concatenate((self._motion(t), where))

    def _pose(self, t: float) -> None:
        reduced = self._reduced
        if self._motion.loose:
            where = self._motion.loose_at(t)
            self._data.mocap_pos[0], self._data.mocap_quat[0] = where.translation, scalar_first(where)
        self._data.qpos[self._address] = reduced.mimic_matrix @ self._motion(t) + reduced.mimic_offset
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)

    def _compose(self, t: float) -> None:
        """Put robot, objects and the tool's path of a moment into the scene."""
        self._pose(t)
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(
            self._model, self._data, self._options, None, self._camera, everything, self._scene
        )
        radius = PATH_RADIUS * self._model.stat.extent
        previous = self._path[0]
        for point in self._path[1:]:
            if np.linalg.norm(point - previous) < radius:
                continue
            geom = self._scene.geoms[self._scene.ngeom]
            mujoco.mjv_initGeom(
                geom,
                mujoco.mjtGeom.mjGEOM_CAPSULE,
                np.zeros(3),
                np.zeros(3),
                np.eye(3).ravel(),
                np.array(PATH_COLOUR, dtype=np.float32),
            )
            mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, radius, previous, point)
            geom.category = mujoco.mjtCatBit.mjCAT_DECOR.value
            self._scene.ngeom += 1
            previous = point


def _mujoco_camera(view: CameraView) -> mujoco.MjvCamera:
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = view.target
    camera.distance = view.distance
    camera.azimuth, camera.elevation = np.rad2deg(view.azimuth), np.rad2deg(view.elevation)
    return camera
