"""Forks of a process that has databases open.

What SQLite knows of its locks it keeps in the process's memory: a child that inherits an open file believes
that it holds locks which only its parent holds, and then what it writes can be lost when the parent closes
the file. So no file is open while a process forks; both open it again when they use it.
"""

import os
from abc import ABC, abstractmethod
from threading import RLock
from weakref import WeakSet


class Forked(ABC):
    """Something that is closed before its process forks."""

    def __init__(self) -> None:
        """Be closed before each fork from now on."""
        self.lock = RLock()
        _FORKS.known.add(self)

    @abstractmethod
    def disconnect(self) -> None:
        """Close what is open; the lock is held."""


class _Forks:
    """What is closed before each fork, and cannot be used by other threads until that is over."""

    def __init__(self) -> None:
        self.known, self._held = WeakSet["Forked"](), list["Forked"]()

    def begin(self) -> None:
        held = list(self.known)
        for each in held:
            each.lock.acquire()
            each.disconnect()
        self._held = held

    def end(self) -> None:
        held, self._held = self._held, []
        for each in held:
            each.lock.release()


_FORKS = _Forks()  # of the process as a whole, as forks are
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_FORKS.begin, after_in_parent=_FORKS.end, after_in_child=_FORKS.end)
