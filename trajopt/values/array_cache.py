"""A cache on disk for arrays that are expensive to compute."""

import hashlib
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Arrays: TypeAlias = Mapping[str, NDArray[Any]]
"""Arrays by name."""


def cached_arrays(
    kind: str, key: Iterable[bytes], names: Sequence[str], make: Callable[[], Arrays]
) -> Arrays:
    """Return arrays from the cache folder, or compute and store them.

    A damaged file is computed again. If the folder is not writable, nothing is stored.

    Args:
        kind: First part of the file's name.
        key: All inputs of the computation, including the version of the algorithm.
        names: Names of the arrays.
        make: Computes the arrays.
    """
    digest = hashlib.sha256()
    for part in key:
        digest.update(part)
    file = cache_folder() / f"{kind}-{digest.hexdigest()}.npz"
    arrays = _read(file, names)
    if arrays is None:
        arrays = make()
        _write(file, arrays)
    return arrays


def cache_folder() -> Path:
    """Return $TRAJOPT_CACHE_DIR, or the cache folder of the platform."""
    if chosen := os.environ.get("TRAJOPT_CACHE_DIR"):
        return Path(chosen)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        base = "~/Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(os.path.expanduser(base)) / "trajopt"


def _read(file: Path, names: Sequence[str]) -> Arrays | None:
    import zipfile

    try:
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as kept:
            return {name: kept[name] for name in names}
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile):
        return None


def _write(file: Path, arrays: Arrays) -> None:
    import tempfile

    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=file.parent, suffix=".tmp")
    except OSError:
        return
    try:
        with os.fdopen(handle, "wb") as stream:
            named: dict[str, Any] = dict(arrays)
            np.savez(stream, **named)
        os.replace(name, file)
    except OSError:
        Path(name).unlink(missing_ok=True)
