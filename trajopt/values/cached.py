"""Caches of what is derived from immutable values."""

import atexit
from collections.abc import Callable
from functools import wraps
from typing import Generic, TypeVar
from weakref import ref

Owner = TypeVar("Owner")
Made = TypeVar("Made")


def cached_per_value(make: Callable[[Owner], Made]) -> Callable[[Owner], Made]:
    """Return a function that computes its result once for each value, and forgets it with the value.

    What is made must be as immutable as the value, since all threads share it, and must not refer to the
    value, which would then never be freed: `cached_in_value` is for that. At worst two threads that call at
    once both compute it.
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
    """Return a function that computes its result once for each value, and keeps it in the value.

    So what is made may refer to the value: both are freed together. The value must have a `__dict__`, of
    which its copies and pickles do not take more than its fields. The rest is as in `cached_per_value`.
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
    """The values of a few keys, those used last.

    Keys are compared one by one, so that they need no hash, and long shared ones compare
    quickly. Threads may share a memory: the entries are replaced as a whole, so that at worst two
    threads compute the same value, or one computes it again.
    """

    def __init__(self, size: int) -> None:
        """Remember nothing yet.

        Args:
            size: How many values are kept, at least 1.
        """
        self._size = size
        self._entries: tuple[tuple[Key, Value], ...] = ()

    def get(self, key: Key, make: Callable[[], Value]) -> Value:
        """Return the value of a key, computed unless it is remembered."""
        entries = self._entries
        for place, entry in enumerate(entries):
            if entry[0] == key:
                if place:
                    self._entries = (entry, *entries[:place], *entries[place + 1 :])
                return entry[1]
        value = make()
        self._entries = ((key, value), *self._entries[: self._size - 1])
        return value
