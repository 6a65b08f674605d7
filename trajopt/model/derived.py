"""What is made of values: once for each, for as long as it lives, and kept outside of it."""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import ref

Owner = TypeVar("Owner")
Made = TypeVar("Made")


def once_each(make: Callable[[Owner], Made]) -> Callable[[Owner], Made]:
    """Return a function that makes its result once for each value, and forgets it with the value.

    What is made must be as immutable as the value, since all threads share it, and must not refer to the
    value, which would never end then. At worst two threads that ask at once both make it.
    """
    made: dict[int, tuple[ref[Owner], Made]] = {}

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
