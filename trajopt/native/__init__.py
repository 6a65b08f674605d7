"""Native cores: the hot loops of other rooms, compiled. Each has a body in plain Python as its oracle.

| core | room that calls it | what it does |
|---|---|---|
| `proximity` | `query` | kinematics of all samples, and the rows of all pairs that come near |
| `banded` | `solvers` | the quadratic program of a step, by an interior point method on a band |
| `reachability` | `retime` | the passes that give the fastest profile, and the extremes of quintics |
| `proof` | `verify` | clearance over all time, distances, kinematics, torques; shares no code with others |
"""

from functools import cache
from importlib.util import find_spec


@cache
def installed(core: str) -> bool:
    """Say whether a native core was compiled at installation.

    Where it was not, as its user then asked for, the plain Python body of the same interface answers.

    Args:
        core: Name of the core.
    """
    spec = find_spec(f"trajopt.native.{core}")
    return spec is not None and spec.origin is not None  # the folder of its sources alone has no origin


def native_cores() -> tuple[str, ...]:
    """Return the names of the cores that are installed."""
    return tuple(core for core in ("proximity", "banded", "reachability", "proof") if installed(core))
