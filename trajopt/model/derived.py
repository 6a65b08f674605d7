"""Values that keep what is derived of them: built when it is first asked for, gone with the value."""

from collections.abc import Callable
from typing import Any, Self, TypeVar

T = TypeVar("T")


class Derived:
    """An immutable value that keeps what functions build of it.

    What is built must be as immutable as the value, since all threads share it. At worst two threads
    that ask at once both build it.
    """

    def derived(self, build: Callable[[Self], T]) -> T:
        """Return what a function builds of this value, built at the first call and kept with it."""
        kept: dict[Callable[[Self], Any], Any] = self.__dict__.setdefault("_kept", {})
        if build not in kept:
            kept[build] = build(self)
        return kept[build]
