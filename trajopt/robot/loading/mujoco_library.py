"""MuJoCo, importable even where MUJOCO_GL names an OpenGL backend that is not installed.

MuJoCo loads the backend that MUJOCO_GL names when it is imported, and fails there with an AttributeError.
Physics needs no OpenGL; rendering raises an error of its own that says what is missing. All other modules
take `mujoco` from here, and import it only when it is used.
"""

import os
from importlib import import_module

__all__ = ["mujoco"]


def _load_mujoco() -> None:
    """Import MuJoCo, without its OpenGL if that cannot be loaded."""
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
