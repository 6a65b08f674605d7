"""MuJoCo, importable even if MUJOCO_GL names an OpenGL backend not installed, which it loads at import.

Other modules import `mujoco` from here.
"""

import os
from importlib import import_module

__all__ = ["mujoco"]


def _load_mujoco() -> None:
    try:
        import_module("mujoco")
    except (AttributeError, OSError, RuntimeError):
        backend = os.environ.get("MUJOCO_GL")
        if backend is None:
            raise
        platform = os.environ.pop("PYOPENGL_PLATFORM", None)
        os.environ["MUJOCO_GL"] = "disable"
        try:
            import_module("mujoco")
        finally:
            os.environ["MUJOCO_GL"] = backend
            if platform is not None:
                os.environ["PYOPENGL_PLATFORM"] = platform


_load_mujoco()
import mujoco  # noqa: E402
