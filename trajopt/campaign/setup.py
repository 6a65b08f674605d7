"""What a worker is told first, and what it answers."""

from collections.abc import Mapping
from dataclasses import dataclass

from trajopt.campaign.documents import Documents
from trajopt.campaign.options import Options


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
