"""Which body the judge runs on: its native core, or plain Python with the same results.

This module decides, once, by what is installed; a judge can be told to use either.
"""

from enum import Enum

from trajopt.native import installed


class Body(Enum):
    """What the judge's geometry and kinematics are computed by."""

    NATIVE = "native"
    PYTHON = "python"


INSTALLED = Body.NATIVE if installed("proof") else Body.PYTHON
"""The fastest body that is installed."""
