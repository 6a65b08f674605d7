"""Which body the judge runs on: its native core, or plain Python with the same results.

This module decides, once, by what is installed; a judge can be told to use either.
"""

from enum import Enum
from importlib.util import find_spec


class Body(Enum):
    """What the judge's geometry and kinematics are computed by."""

    NATIVE = "native"
    PYTHON = "python"


INSTALLED = Body.PYTHON if find_spec("trajopt.native.proof") is None else Body.NATIVE
"""The fastest body that is installed."""
