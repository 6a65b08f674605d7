"""Drawing without a window: finds an OpenGL that works, and reads pictures from it."""

import os
import sys
from collections.abc import Iterable
from ctypes.util import find_library
from importlib import import_module
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.simulation.picture_files import Image
from trajopt.values.errors import RenderingUnavailable

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

    MuJoCo selects its backend when it is imported, and cannot change it later; so its context classes are
    used directly.

    Raises:
        RenderingUnavailable: If no backend works.
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
        """Open the context; the offscreen buffer of the model must be at least as large as the pictures.

        Args:
            model: Model of MuJoCo.
            width: Of the pictures [pixels].
            height: Of the pictures [pixels].

        Raises:
            RenderingUnavailable: If OpenGL does not work.
        """
        self._size = (width, height)
        self._context = open_context(width, height)
        try:
            self._resources = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150.value)
        except mujoco.FatalError as error:
            self._context.free()
            raise RenderingUnavailable([f"MuJoCo: {error}"]) from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._resources)

    def __enter__(self) -> "Offscreen":
        """Return itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Free the graphics memory."""
        self._resources.free()
        self._context.free()

    def update_meshes(self, model: mujoco.MjModel, meshes: Iterable[int]) -> None:
        """Load changed meshes of the model again."""
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
        """Return depths along the axis of the camera, shape (height, width), first row on top [m].

        Args:
            scene: The scene.
            nearest: Depth of the near clipping plane [m].
            farthest: Depth of the far clipping plane, which is the depth of empty pixels [m].
        """
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
