"""Drawing without a window: finds an OpenGL that works here, and reads pictures from it."""

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
    """Return the drawing backends that are worth trying here, best first.

    The environment variable MUJOCO_GL ("egl", "osmesa", "glfw", "cgl") decides alone when set.
    Otherwise EGL, which needs no display; OSMesa where there is no EGL; and a hidden window.
    """
    asked = os.environ.get("MUJOCO_GL", "").lower().strip()
    if asked in ("egl", "osmesa", "glfw", "cgl"):
        return (asked,)
    if asked in ("disable", "disabled", "off", "false", "0"):
        return ()
    if sys.platform == "darwin":
        return ("cgl", "glfw")
    found: list[str] = []
    if sys.platform.startswith("linux"):
        # PyOpenGL binds to one of the two for good, so the second is no fallback of the first.
        if find_library("EGL"):
            found.append("egl")
        elif find_library("OSMesa"):
            found.append("osmesa")
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            return tuple(found)
    return (*found, "glfw")


def open_context(width: int, height: int) -> Any:
    """Open an OpenGL context for pictures of up to this many pixels, and make it current.

    MuJoCo's own choice is made when it is imported, which is too late to be corrected; its
    context classes are used directly instead.

    Raises:
        RenderingUnavailable: If none works.
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
        tried.append(f"MUJOCO_GL={os.environ['MUJOCO_GL']} turns drawing off")
    raise RenderingUnavailable(tried)


class Offscreen:
    """An OpenGL context with a model's meshes and textures loaded; use it in a `with`."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        """Open the context; the model's offscreen buffer must be at least this large.

        Args:
            model: MuJoCo's model.
            width: Of the pictures [pixels].
            height: Of the pictures [pixels].

        Raises:
            RenderingUnavailable: If there is no OpenGL.
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

    def draw_anew(self, model: mujoco.MjModel, meshes: Iterable[int]) -> None:
        """Take meshes of the model as they are now."""
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
        """Draw how far away things are, shape (height, width), first row on top; in metres along the axis.

        Args:
            scene: What is drawn.
            nearest: Depth of the plane before which nothing is drawn [m].
            farthest: Depth of the plane behind which nothing is drawn, which is what is seen where nothing
                is [m].
        """
        width, height = self._size
        rectangle = mujoco.MjrRect(0, 0, width, height)
        flags = mujoco.mjtRndFlag
        for flag in (flags.mjRND_SHADOW, flags.mjRND_REFLECTION, flags.mjRND_SKYBOX, flags.mjRND_HAZE):
            scene.flags[flag.value] = 0
        # With 0 for far, the numbers near 0 are as fine as single precision has them.
        self._resources.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR.value
        mujoco.mjr_render(rectangle, scene, self._resources)
        inverse = np.empty((height, width), dtype=np.float32)
        mujoco.mjr_readPixels(None, inverse, rectangle, self._resources)
        # What is drawn is a (1 / depth - 1 / farthest) with a such that the nearest plane has 1.
        share = inverse[::-1].astype(np.float64)
        depth = 1.0 / (share * (1.0 / nearest - 1.0 / farthest) + 1.0 / farthest)
        return depth.astype(np.float32)
