"""Memories of motions, and the protocol of the storage that keeps them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from trajopt.values.arrays import Floats, Value


@dataclass(frozen=True, eq=False, kw_only=True)
class Memory(Value):
    """A motion that solved a problem, and its record of success.

    Attributes:
        number: Its number; numbers are not given again.
        key: Must be equal for another problem: robot, group, and the kinds of the requirements.
        start: Start of the group's joints, shape (n,) [rad | m].
        goal: The numbers of the goal: positions, placements, tolerances, shape (g,).
        scene: Positions and sizes of the objects, shape (objects, 6) [m]; see `scene_signature`.
        knots: The path, shape (k, n) [rad | m].
        wins: Number of motions found from it.
        failures: Number of failures since its last win.
        used: The version of the memory when it was learnt, or last won.
    """

    number: int
    key: str
    start: Floats
    goal: Floats
    scene: Floats
    knots: Floats
    wins: int = 0
    failures: int = 0
    used: int = 0


class Storage(Protocol):
    """Storage of memories; `trajopt.server.warehouse.Warehouse` has one in its file."""

    @property
    def version(self) -> int:
        """Number of its changes."""
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
            gone: The numbers of the memories to remove.

        Returns:
            The version afterwards, and the new memory with its number.
        """
        ...


class InProcessStorage:
    """Memories that end with the process."""

    def __init__(self) -> None:
        """Begin without any."""
        self._memories: dict[int, Memory] = {}
        self._version, self._last = 0, 0

    @property
    def version(self) -> int:
        """Number of its changes."""
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
