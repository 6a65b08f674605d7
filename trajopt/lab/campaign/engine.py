"""Engines: they plan a campaign's problems. Each opens a pool of workers that take blocks."""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from struct import Struct
from typing import Protocol

from trajopt.lab.campaign.campaign import CampaignTask, Options
from trajopt.lab.campaign.columns import Row
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.recipes import Documents
from trajopt.values.errors import ProblemError, shown

AHEAD = 2
"""Blocks of a worker: one that it plans, and the next, for which it need not wait."""


@dataclass(frozen=True, eq=False)
class Block:
    """Problems passed to one worker together."""

    tasks: Sequence[CampaignTask]
    losses: int = 0


@dataclass(frozen=True, eq=False)
class PlannedBlock:
    """A finished block.

    Attributes:
        shard: The rows, as from `encoded`.
        waited: Wall-clock time that its worker waited for it [s].
    """

    block: Block
    shard: bytes
    seconds: float
    busy: float
    waited: float
    verified: int


@dataclass(frozen=True, eq=False)
class Lost:
    """A block whose worker was lost; `begun` if it was being planned, and may be the cause."""

    block: Block
    why: str
    begun: bool


class EnginePool(Protocol):
    """Workers that plan blocks."""

    @property
    def workers(self) -> int:
        """Most workers."""
        ...

    @property
    def idle(self) -> int:
        """Number of blocks that can be submitted now."""
        ...

    def submit(self, block: Block) -> None:
        """Pass a block to a worker, preferably an idle one."""
        ...

    def wait(self, seconds: float) -> Sequence[PlannedBlock | Lost]:
        """Return finished blocks; wait at most a number of seconds."""
        ...


class Engine(Protocol):
    """Opens pools."""

    def pool(self, folder: CampaignFolder) -> AbstractContextManager[EnginePool]:
        """Return the workers of a campaign, which end with the context."""
        ...


def check_workers(workers: int) -> None:
    if workers < 0:
        raise ProblemError(f"workers must not be negative, is {shown(workers)}")


MARK = Struct("<Qd")
"""Written by a worker at the start of a problem: number of started problems, and monotonic time [s]."""


@dataclass(frozen=True)
class Setup:
    """Initial message to a worker."""

    documents: Documents
    options: tuple[Options, ...]
    versions: Mapping[str, str]
    most_seconds: float


@dataclass(frozen=True)
class StartReport:
    """The worker is ready, or why it cannot plan."""

    reason: str = ""


@dataclass(frozen=True, eq=False)
class Bunch:
    """Rows of some problems, sent together after the worker waited for a time [s]."""

    rows: Sequence[Row]
    waited: float
