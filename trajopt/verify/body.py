"""Which body the judge runs on: its native core, or plain Python with the same results.

This module decides, once, by what is installed; a judge can be told to use either.
"""

from enum import Enum
from importlib.util import find_spec


class Body(Enum):
    """What the judge's geometry and kinematics are computed by."""

    NATIVE = "native"
    PYTHON = "python"


def _installed() -> Body:
    # A folder of sources without a compiled core beside it is found, too, as a package without origin.
    spec = find_spec("trajopt.native.proof")
    return Body.PYTHON if spec is None or spec.origin is None else Body.NATIVE


INSTALLED = _installed()
"""The fastest body that is installed."""
