"""Caches of function results, in memory and on disk."""

import atexit
import hashlib
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar
from weakref import ref

import numpy as np
from numpy.typing import NDArray

Owner = TypeVar("Owner")
Made = TypeVar("Made")


def cached_per_value(make: Callable[[Owner], Made]) -> Callable[[Owner], Made]:
    """Return a function that computes its result once for each value, as long as the value exists.

    The result must be immutable, and must not refer to the value, which would then never be freed
    (`cached_in_value` permits it). Two threads may both compute it.
    """
    made: dict[int, tuple[ref[Owner], Made]] = {}
    atexit.register(made.clear)  # what the cores made must not outlive the interpreter

    @wraps(make)
    def found_or_made(owner: Owner) -> Made:
        key = id(owner)
        entry = made.get(key)
        if entry is not None and entry[0]() is owner:
            return entry[1]
        result = make(owner)
        made[key] = (ref(owner, lambda _: made.pop(key, None)), result)
        return result

    return found_or_made


def cached_in_value(make: Callable[[Owner], Made]) -> Callable[[Owner], Made]:
    """Return a function that computes its result once for each value, and stores it in the value.

    The result may refer to the value: both are freed together. The value's `__dict__` must leave cached
    entries out of copies and pickles.
    """
    name = f"{make.__module__}.{make.__qualname__}"

    @wraps(make)
    def found_or_made(owner: Owner) -> Made:
        kept = vars(owner)
        if name not in kept:
            kept[name] = make(owner)
        return kept[name]

    return found_or_made


Key = TypeVar("Key")
Value = TypeVar("Value")


class LruCache(Generic[Key, Value]):
    """The values of the most recently used keys.

    Keys need no hash. Threads may share a cache: at worst a value is computed twice.
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self._entries: tuple[tuple[Key, Value], ...] = ()

    def get(self, key: Key, make: Callable[[], Value]) -> Value:
        """Return the value of a key; compute it if it is not cached."""
        entries = self._entries
        for place, entry in enumerate(entries):
            if entry[0] == key:
                if place:
                    self._entries = (entry, *entries[:place], *entries[place + 1 :])
                return entry[1]
        value = make()
        self._entries = ((key, value), *self._entries[: self._size - 1])
        return value


Arrays: TypeAlias = Mapping[str, NDArray[Any]]


def cached_arrays(
    kind: str, key: Iterable[bytes], names: Sequence[str], make: Callable[[], Arrays]
) -> Arrays:
    """Return arrays from the cache folder, or compute and store them.

    A damaged file is computed again. If the folder is not writable, nothing is stored.

    Args:
        key: All inputs of the computation, including the version of the algorithm.
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
