"""The passes over a grid: by the native core where it is installed, else by their body in plain Python."""

from collections.abc import Callable
from typing import TypeAlias

from trajopt.arrays import Floats
from trajopt.retime import reachability
from trajopt.retime.stages import Stages

Passes: TypeAlias = Callable[[Floats, Floats, Floats, Floats], Floats]
"""Half-planes (onward, held, room) and bound -> control values: see `trajopt.retime.reachability.fastest`."""


def _native_passes() -> Passes | None:
    try:
        from trajopt.native.reachability import fastest as compiled
    except ModuleNotFoundError:
        return None
    return compiled


_COMPILED = _native_passes()
NATIVE = _COMPILED is not None
"""Whether the native core is in use; installing without a compiler leaves it out."""


def fastest(stages: Stages, room: Floats, bound: Floats) -> Floats:
    """Find the pointwise largest control values of a profile from rest to rest.

    Args:
        stages: Half-planes at the k grid points.
        room: Their right-hand sides, positive, shape (k, 4 m).
        bound: Bound at the stations, positive, shape (k + 1,).

    Returns:
        Control values of x = (ds/dt)² at the stations, shape (k + 1,); 0 at both ends.
    """
    if _COMPILED is None:
        return reachability.fastest(stages, room, bound)
    return _COMPILED(stages.onward, stages.held, room, bound)
