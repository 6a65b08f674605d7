"""Storage: where memories are kept; in the memory of the process alone, or by whoever offers as much."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Protocol

from trajopt.planning.experience.memory import Memory


class Storage(Protocol):
    """Where memories are kept; `trajopt.server.warehouse.Warehouse` has one in its file."""

    @property
    def version(self) -> int:
        """How often it was changed."""
        ...

    def all(self) -> Mapping[int, Memory]:
        """Return all memories by number."""
        ...

    def change(
        self, *, new: Memory | None = None, changed: Iterable[Memory] = (), gone: Iterable[int] = ()
    ) -> tuple[int, Memory | None]:
        """Add, change and remove memories in one step.

        Args:
            new: One to add; it gets the next number.
            changed: Memories that have other counts.
            gone: The numbers of those to remove.

        Returns:
            The version afterwards, and the new memory with its number.
        """
        ...


class InProcess:
    """Memories that end with the process."""

    def __init__(self) -> None:
        """Begin without any."""
        self._memories: dict[int, Memory] = {}
        self._version, self._last = 0, 0

    @property
    def version(self) -> int:
        """How often it was changed."""
        return self._version

    def all(self) -> Mapping[int, Memory]:
        """Return all memories by number."""
        return dict(self._memories)

    def change(
        self, *, new: Memory | None = None, changed: Iterable[Memory] = (), gone: Iterable[int] = ()
    ) -> tuple[int, Memory | None]:
        """Add, change and remove memories in one step; see `Storage.change`."""
        self._version += 1
        for each in changed:
            if each.number in self._memories:
                self._memories[each.number] = each
        for number in gone:
            self._memories.pop(number, None)
        if new is not None:
            self._last += 1
            new = replace(new, number=self._last, used=self._version)
            self._memories[self._last] = new
        return self._version, new
