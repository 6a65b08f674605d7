"""Native cores: the hot loops of other rooms, compiled; plain twins in `tests/oracles` are their oracles.

| core | room that calls it | what it does |
|---|---|---|
| `proximity` | `query` | kinematics of all samples, rows of all pairs that come near, and paths searched |
| `banded` | `solvers` | the quadratic program of a step, by an interior point method on a band |
| `descent` | `solvers` | steps of the SQP, of programs whose terms it can evaluate |
| `timing` | `retime` | paths made smooth, and timed within all limits |
| `proof` | `verify` | clearance over all time, distances, kinematics, torques; shares no code with others |
| `checker` | `files.proof` | the fast kernel, which checks proof files; shares no code with others |
| `covers` | `model` | convex pieces that cover a mesh, when a robot or an object is loaded |
"""

from importlib.util import find_spec

from trajopt.values.errors import NativeCoresMissing

CORES = ("proximity", "banded", "descent", "timing", "proof", "checker", "covers")
"""Names of all cores."""


def native_cores() -> tuple[str, ...]:
    """Return the names of the cores installed for this Python: all of them, or the import fails."""
    return tuple(core for core in CORES if _installed(core))


def _installed(core: str) -> bool:
    spec = find_spec(f"trajopt.native.{core}")
    return spec is not None and spec.origin is not None  # the folder of its sources alone has no origin


_missing = [core for core in CORES if not _installed(core)]
if _missing:
    raise NativeCoresMissing(_missing)
