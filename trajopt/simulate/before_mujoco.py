"""Imports MuJoCo also where MUJOCO_GL names an OpenGL that is not installed.

MuJoCo loads what MUJOCO_GL names when it is imported, and fails there with an AttributeError. Physics
needs no OpenGL, and a picture asked for later fails with an error that says what is missing.
"""

import os
from importlib import import_module


def load_mujoco() -> None:
    """Import MuJoCo, without its OpenGL if that cannot be loaded."""
    try:
        import_module("mujoco")
    except (AttributeError, OSError, RuntimeError):
        asked = os.environ.get("MUJOCO_GL")
        if asked is None:
            raise
        platform = os.environ.pop("PYOPENGL_PLATFORM", None)
        os.environ["MUJOCO_GL"] = "disable"
        try:
            import_module("mujoco")
        finally:
            os.environ["MUJOCO_GL"] = asked
            if platform is not None:
                os.environ["PYOPENGL_PLATFORM"] = platform


load_mujoco()
