"""Native cores: the hot loops of other rooms, compiled (docs/decisions/native.md)."""

from importlib.util import find_spec

from trajopt.values.errors import NativeCoresMissing

CORES = ("proximity", "banded", "descent", "timing", "servo", "proof", "checker", "covers")
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
