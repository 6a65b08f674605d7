"""The results used last: a small memory that an immutable value keeps of what was made from it."""

from collections.abc import Callable
from typing import Generic, TypeVar

Key = TypeVar("Key")
Value = TypeVar("Value")


class Recent(Generic[Key, Value]):
    """The values of a few keys, those asked for last.

    Keys are compared one by one, so that they need no hash and long ones that are shared are equal at
    a glance. Threads may share a memory: the entries are replaced as a whole, so that at worst two
    threads make the same value, or one that another made is made again.
    """

    def __init__(self, size: int) -> None:
        """Remember nothing yet.

        Args:
            size: So many values are kept, at least 1.
        """
        self._size = size
        self._entries: tuple[tuple[Key, Value], ...] = ()

    def get(self, key: Key, make: Callable[[], Value]) -> Value:
        """Return the value of a key, made now unless it is remembered."""
        entries = self._entries
        for place, entry in enumerate(entries):
            if entry[0] == key:
                if place:
                    self._entries = (entry, *entries[:place], *entries[place + 1 :])
                return entry[1]
        value = make()
        self._entries = ((key, value), *self._entries[: self._size - 1])
        return value
