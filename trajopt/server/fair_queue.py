"""A queue that is fair: of those who wait, each has its turn."""

import asyncio
from collections import OrderedDict, deque
from typing import Generic, TypeVar

Item = TypeVar("Item")


class FairQueue(Generic[Item]):
    """Items with their owners: owners take turns, and the items of one keep their order."""

    def __init__(self) -> None:
        """Hold nothing yet."""
        self._waiting: OrderedDict[object, deque[Item]] = OrderedDict()
        self._there = asyncio.Semaphore(0)

    def __len__(self) -> int:
        """Return how many items wait."""
        return sum(map(len, self._waiting.values()))

    def of(self, owner: object) -> int:
        """Return how many items of an owner wait."""
        return len(self._waiting.get(owner, ()))

    def put(self, owner: object, item: Item) -> None:
        """Add an item."""
        self._waiting.setdefault(owner, deque()).append(item)
        self._there.release()

    def discard(self, owner: object, item: Item) -> bool:
        """Take an item out, and say whether it was there."""
        line = self._waiting.get(owner)
        if line is None or item not in line:
            return False
        line.remove(item)
        if not line:
            del self._waiting[owner]
        return True

    async def take(self) -> Item:
        """Wait for an item, and return it: of the owner whose turn it is, the first."""
        while True:
            await self._there.acquire()
            if not self._waiting:
                continue  # what was added has been taken out
            owner, line = self._waiting.popitem(last=False)
            item = line.popleft()
            if line:
                self._waiting[owner] = line
            return item
