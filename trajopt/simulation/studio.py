"""Rendering without a window."""

import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator
from ctypes.util import find_library
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.camera import Camera, Singles
from trajopt.scene.reduced import ReducedModel
from trajopt.simulation.camera import FIELD_OF_VIEW, CameraView, visible_points
from trajopt.simulation.picture_files import Image, labelled
from trajopt.simulation.picture_model import (
    FLOOR_GROUP,
    HALO_GROUP,
    PATH_POINTS,
    UNSEEN_GROUP,
    PosedModel,
    adapt_to_camera,
    picture_spec,
)
from trajopt.simulation.sampled_motion import SampledMotion
from trajopt.simulation.viewpoint import best_viewpoint, in_view, seen_from
from trajopt.values.arrays import Floats
from trajopt.values.errors import RenderingUnavailable
from trajopt.values.placement import Placement, placement, scalar_first

OPTICAL_TO_MUJOCO = placement(rpy=(np.pi, 0.0, 0.0))
"""Cameras of MuJoCo look along -z, with y up; an optical frame has z forward and y down."""
DEPTH_CAMERA = "depth camera"
NEARER = 0.5
"""Near clipping plane as a share of the nearest depth, so that objects in range are not cut."""


class DrawnDepth:
    """Draws the depth image of a camera, for fixed positions of the other joints [rad | m]."""

    def __init__(self, reduced: ReducedModel, camera: Camera, fixed: Floats) -> None:
        lens = camera.intrinsics
        shown = visible_points(reduced, reduced.start_positions[None])
        spec = picture_spec(reduced, shown).spec
        spec.visual.quality.offsamples = 0  # no blending of depths at edges
        spec.visual.map.znear = NEARER * camera.nearest / spec.stat.extent
        spec.visual.map.zfar = (camera.farthest + camera.nearest) / spec.stat.extent
        spec.visual.global_.offwidth, spec.visual.global_.offheight = lens.width, lens.height
        eye = spec.worldbody.add_camera(name=DEPTH_CAMERA)
        eye.resolution = np.array((lens.width, lens.height))
        eye.sensor_size = np.array((lens.width, lens.height)) * 1e-6
        eye.focal_pixel = np.array((lens.fx, lens.fy))
        # MuJoCo measures it from the axis to the middle of the picture, left and up.
        eye.principal_pixel = np.array(((lens.width - 1) / 2 - lens.cx, (lens.height - 1) / 2 - lens.cy))
        self.fixed = fixed
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.options = mujoco.MjvOption()
        for group in (FLOOR_GROUP, HALO_GROUP, UNSEEN_GROUP):
            self.options.geomgroup[group] = 0
        self.view = mujoco.MjvCamera()
        self.view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self.view.fixedcamid = self.model.camera(DEPTH_CAMERA).id
        self.scene = mujoco.MjvScene(self.model, self.model.ngeom + 1)
        names = tuple(reduced.model.names[1:])
        self.address = [self.model.jnt_qposadr[self.model.joint(name).id] for name in names]
        self.screen = Offscreen(self.model, lens.width, lens.height)

    def depth(self, reduced: ReducedModel, where: Placement) -> Singles:
        """Return the depths of robot and objects at the start of the group, in an optical frame."""
        eye = where * OPTICAL_TO_MUJOCO
        place = self.view.fixedcamid
        self.model.cam_pos[place], self.model.cam_quat[place] = eye.translation, scalar_first(eye)
        moved = reduced.mimic_matrix @ reduced.start_positions + reduced.mimic_offset
        self.data.qpos[self.address] = moved
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self.model, self.data, self.options, None, self.view, everything, self.scene)
        extent, planes = self.model.stat.extent, self.model.vis.map
        return self.screen.depth(self.scene, planes.znear * extent, planes.zfar * extent)


PATH_COLOUR = (0.10, 0.45, 0.75, 1.0)
PATH_RADIUS = 0.003
"""Radius of tool paths, as a share of half the size of the shown region."""
SAME_PICTURE = 1e-5
"""Smaller changes of joints give the same picture [rad | m]."""
GHOST = 0.22
"""Opacity of earlier times in a superposed picture."""
TRANSLUCENT = 0.3
"""Opacity of objects between camera and motion, with visible edges."""


@dataclass(frozen=True)
class Canvas:
    """Size of pictures, and of the edge of their shadow map [pixels]."""

    width: int
    height: int
    shadow: int

    @property
    def aspect(self) -> float:
        """Width over height."""
        return self.width / self.height


class Studio:
    """A visual model, a camera and a drawing context; use it in a `with` statement."""

    def __init__(
        self,
        reduced: ReducedModel,
        motion: SampledMotion,
        canvas: Canvas,
        *,
        pictures: int,
        camera: CameraView | None,
        highlight: Collection[str] = (),
    ) -> None:
        shown = in_view(reduced, motion, highlight)
        self._motion = motion
        self._posed = PosedModel(reduced, motion, shown, highlight)
        self._model, self._data = self._posed.model, self._posed.data
        if camera is None:
            view = best_viewpoint(self._posed, shown, canvas.aspect)
        else:
            view = seen_from(self._posed, camera)
        for geom, owner in self._posed.owners.items():
            if owner in view.hiding:
                self._model.geom_rgba[geom, 3] = min(TRANSLUCENT, self._model.geom_rgba[geom, 3])
        adapt_to_camera(self._model, view.camera.azimuth, view.camera.distance)
        model = self._model
        model.vis.global_.offwidth, model.vis.global_.offheight = canvas.width, canvas.height
        model.vis.global_.fovy = float(np.rad2deg(FIELD_OF_VIEW))
        model.vis.quality.shadowsize = canvas.shadow
        self._camera = _mujoco_camera(view.camera)
        self._options = mujoco.MjvOption()
        self._options.geomgroup[HALO_GROUP] = 1
        capacity = (pictures + 1) * self._model.ngeom + 2 * PATH_POINTS * len(self._posed.paths)
        self._scene = mujoco.MjvScene(self._model, capacity)
        self._screen = Offscreen(self._model, canvas.width, canvas.height)

    def __enter__(self) -> "Studio":
        return self

    def __exit__(self, *stop: object) -> None:
        self._screen.__exit__(None, None, None)

    def pictures(self, times: Floats, report: Callable[[float], None]) -> Iterator[Image]:
        """Draw the times one by one."""
        drawn, picture = None, None
        for count, t in enumerate(times):
            positions = self._shown_state(float(t))
            if picture is None or drawn is None or np.abs(positions - drawn).max() > SAME_PICTURE:
                self._compose(float(t))
                drawn, picture = positions, self._screen.picture(self._scene)
            yield labelled(picture, f"{t:.2f} s")
            report((count + 1) / (len(times) + 1))

    def superposed(self, times: Floats) -> Image:
        """Draw the last time solid and the others translucent, halos at the last only."""
        self._compose(float(times[-1]))
        self._options.geomgroup[HALO_GROUP] = 0
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

    def _shown_state(self, t: float) -> Floats:
        places = [where.homogeneous.ravel() for where in self._motion.loose_at(t).values()]
        return np.concatenate((self._motion(t), *places, self._posed.changing.state(t)))

    def _pose(self, t: float) -> None:
        self._posed.pose(t)
        mujoco.mj_camlight(self._model, self._data)

    def _compose(self, t: float) -> None:
        self._pose(t)
        self._screen.update_meshes(self._model, self._posed.grow_halos(t))
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(
            self._model, self._data, self._options, None, self._camera, everything, self._scene
        )
        for path in self._posed.paths:
            self._add_line(path)

    def _add_line(self, points: Floats) -> None:
        radius = PATH_RADIUS * self._model.stat.extent
        previous = points[0]
        for point in points[1:]:
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


Depths = NDArray[np.float32]


def backends() -> tuple[str, ...]:
    """Return the drawing backends to try, the best first.

    The environment variable MUJOCO_GL ("egl", "osmesa", "glfw", "cgl") selects one. Otherwise these are EGL,
    which needs no display, or OSMesa without EGL, and a hidden window.
    """
    selected = os.environ.get("MUJOCO_GL", "").lower().strip()
    if selected in ("egl", "osmesa", "glfw", "cgl"):
        return (selected,)
    if selected in ("disable", "disabled", "off", "false", "0"):
        return ()
    if sys.platform == "darwin":
        return ("cgl", "glfw")
    found: list[str] = []
    if sys.platform.startswith("linux"):
        # PyOpenGL binds to one of the two permanently, so the second is not a fallback of the first.
        if find_library("EGL"):
            found.append("egl")
        elif find_library("OSMesa"):
            found.append("osmesa")
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            return tuple(found)
    return (*found, "glfw")


def open_context(width: int, height: int) -> Any:
    """Open an OpenGL context for pictures up to a size [pixels], and make it current.

    MuJoCo selects its backend at import; so its context classes are used directly.
    """
    tried: list[str] = []
    for backend in backends():
        platform = os.environ.get("PYOPENGL_PLATFORM")
        try:
            context = import_module(f"mujoco.{backend}").GLContext(width, height)
            context.make_current()
            return context
        except Exception as error:
            reason = str(error).rstrip(".")
            tried.append(f"{backend}: {type(error).__name__}: {reason}")
            if platform is None:
                os.environ.pop("PYOPENGL_PLATFORM", None)
    if not tried and os.environ.get("MUJOCO_GL"):
        tried.append(f"MUJOCO_GL={os.environ['MUJOCO_GL']} disables drawing")
    raise RenderingUnavailable(tried)


class Offscreen:
    """An OpenGL context with the meshes and textures of a model; use it in a `with` statement."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        """Open the context; the offscreen buffer must be at least as large as the pictures."""
        self._size = (width, height)
        self._context = open_context(width, height)
        try:
            self._resources = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150.value)
        except mujoco.FatalError as error:
            self._context.free()
            raise RenderingUnavailable([f"MuJoCo: {error}"]) from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._resources)

    def __enter__(self) -> "Offscreen":
        return self

    def __exit__(self, *raised: object) -> None:
        self._resources.free()
        self._context.free()

    def update_meshes(self, model: mujoco.MjModel, meshes: Iterable[int]) -> None:
        for mesh in meshes:
            mujoco.mjr_uploadMesh(model, self._resources, mesh)

    def picture(self, scene: mujoco.MjvScene) -> Image:
        """Draw a scene, shape (height, width, 3), first row on top."""
        width, height = self._size
        rectangle = mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(rectangle, scene, self._resources)
        pixels = np.empty((height, width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(pixels, None, rectangle, self._resources)
        return pixels[::-1]

    def depth(self, scene: mujoco.MjvScene, nearest: float, farthest: float) -> Depths:
        """Return depths (height, width), first row on top [m]; empty pixels have the farthest one."""
        width, height = self._size
        rectangle = mujoco.MjrRect(0, 0, width, height)
        flags = mujoco.mjtRndFlag
        for flag in (flags.mjRND_SHADOW, flags.mjRND_REFLECTION, flags.mjRND_SKYBOX, flags.mjRND_HAZE):
            scene.flags[flag.value] = 0
        # With 0 for the far plane, values near 0 have the full resolution of single precision.
        self._resources.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR.value
        mujoco.mjr_render(rectangle, scene, self._resources)
        inverse = np.empty((height, width), dtype=np.float32)
        mujoco.mjr_readPixels(None, inverse, rectangle, self._resources)
        # The buffer contains a (1 / depth - 1 / farthest), where a gives 1 at the near plane.
        share = inverse[::-1].astype(np.float64)
        depth = 1.0 / (share * (1.0 / nearest - 1.0 / farthest) + 1.0 / farthest)
        return depth.astype(np.float32)
