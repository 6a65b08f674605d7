"""Caches of results that are derived from immutable values."""

import atexit
from collections.abc import Callable
from functools import wraps
from typing import Generic, TypeVar
from weakref import ref

Owner = TypeVar("Owner")
Made = TypeVar("Made")


def cached_per_value(make: Callable[[Owner], Made]) -> Callable[[Owner], Made]:
    """Return a function that computes its result once for each value, as long as the value exists.

    The result must be immutable, since all threads share it, and must not refer to the value, which would
    then never be freed; use `cached_in_value` for that. Two threads that call it simultaneously may both
    compute it.
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

    The result may refer to the value: both are freed together. The value must have a `__dict__` whose cached
    entries are left out of copies and pickles. Otherwise as `cached_per_value`.
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

    Keys are compared one by one, so they need no hash, and long shared keys compare quickly. Threads may
    share a cache: entries are replaced as a whole, so at worst a value is computed twice.
    """

    def __init__(self, size: int) -> None:
        """Create an empty cache.

        Args:
            size: Number of values, at least 1.
        """
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
