"""What a worker is told first, and what it answers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from struct import Struct

from trajopt.lab.campaign.columns import Row
from trajopt.lab.campaign.documents import Documents
from trajopt.lab.campaign.options import Options

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
