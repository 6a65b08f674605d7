"""Engines: what a campaign's problems are planned by. Each opens a pool of workers that take blocks."""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from struct import Struct
from typing import Protocol

from trajopt.lab.campaign.campaign import Options, Task
from trajopt.lab.campaign.columns import Row
from trajopt.lab.campaign.documents import Documents
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.values.errors import ProblemError, shown

AHEAD = 2
"""Blocks that a worker has at once: one that it plans, and the next, for which it need not wait."""


@dataclass(frozen=True, eq=False)
class Block:
    """Problems that are handed to one worker at once.

    Attributes:
        tasks: The problems.
        losses: Times that a machine was lost under its one problem; 0 as long as it has several.
    """

    tasks: Sequence[Task]
    losses: int = 0


@dataclass(frozen=True, eq=False)
class Planned:
    """A block whose problems all have a row.

    Attributes:
        block: The block.
        shard: The rows, as `encoded` returns them.
        seconds: Wall-clock time of making and planning its problems [s].
        busy: Process time of planning [s].
        waited: Wall-clock time that its worker waited for it [s].
        verified: Rows with a verified motion.
    """

    block: Block
    shard: bytes
    seconds: float
    busy: float
    waited: float
    verified: int


@dataclass(frozen=True, eq=False)
class Lost:
    """A block whose worker was lost, with its machine or its engine's process.

    Attributes:
        block: The block.
        why: What the engine says of it.
        begun: Whether it was planned at the time; else it waited, and has nothing to do with the loss.
    """

    block: Block
    why: str
    begun: bool


class Pool(Protocol):
    """Workers that take blocks."""

    @property
    def workers(self) -> int:
        """How many there are at most."""
        ...

    @property
    def idle(self) -> int:
        """How many blocks can be submitted now."""
        ...

    def submit(self, block: Block) -> None:
        """Hand a block to a worker: first to one that has none."""
        ...

    def wait(self, seconds: float) -> Sequence[Planned | Lost]:
        """Return what ended, waiting for it for so long at most [s].

        Raises:
            CampaignError: If there are no workers, and will be none.
        """
        ...


class Engine(Protocol):
    """Opens pools."""

    def pool(self, folder: CampaignFolder) -> AbstractContextManager[Pool]:
        """Return the workers of a campaign, which end with the context."""
        ...


def check_workers(workers: int) -> None:
    """Refuse a number of workers that is negative; 0 leaves it to the engine.

    Raises:
        ProblemError: If it is negative.
    """
    if workers < 0:
        raise ProblemError(f"workers must not be negative, is {shown(workers)}")


MARK = Struct("<Qd")
"""Written by a worker that begins a problem: how many it has begun, and when, by the monotonic clock [s]."""


@dataclass(frozen=True)
class Setup:
    """What a worker is told first.

    Attributes:
        documents: What the problems share: its folder, or the members of each document by its key.
        options: The ways in which problems are planned.
        versions: With which the campaign was begun.
        most_seconds: Wall-clock time after which a problem is given up [s].
    """

    documents: Documents
    options: tuple[Options, ...]
    versions: Mapping[str, str]
    most_seconds: float


@dataclass(frozen=True)
class Ready:
    """The worker waits for problems; why not, where it cannot plan."""

    reason: str = ""


@dataclass(frozen=True, eq=False)
class Bunch:
    """Rows of some problems, which the worker tells at once.

    Attributes:
        rows: In the order in which it was given them.
        waited: Wall-clock time that it waited for problems since it told of others [s].
    """

    rows: Sequence[Row]
    waited: float
