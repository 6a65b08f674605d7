"""Two campaigns side by side: the same problems, planned by two methods, versions or options."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from trajopt.lab.campaign.columns import Row
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.summary import COLUMNS, Estimate, changed_by_chance, quantile
from trajopt.values.errors import CampaignError
from trajopt.values.errors.arguments import checked

Key = tuple[str, int]
"""A problem, and the number of the options it was planned with."""


@dataclass(frozen=True)
class Change:
    """A problem with another outcome in the second campaign.

    Attributes:
        id: Of its row in the second campaign.
        family: Its set in the statistics.
        before: Its status in the first.
        after: Its status in the second.
    """

    id: str
    family: str
    before: str
    after: str


@dataclass(frozen=True)
class Comparison:
    """Differences of two campaigns on their common problems.

    Attributes:
        first: Name of the first.
        second: Name of the second.
        common: Number of common problems.
        only_first: Number of problems of the first only.
        only_second: Number of problems of the second only.
        verified: Verified motions of the common problems, in the first and in the second.
        gained: Problems solved only by the second.
        lost: Problems solved only by the first.
        chance: Probability of such an uneven change by chance, by McNemar's exact test.
        cpu_ratio: CPU time of the second over the first, the median over the common problems.
        faster: Numbers of common problems that took the second less CPU time, and more.
        speed_chance: Probability of such an uneven count by chance, by the exact sign test.
        duration_ratio: Likewise `cpu_ratio` for the motions' durations.
    """

    first: str
    second: str
    common: int
    only_first: int
    only_second: int
    verified: tuple[int, int]
    gained: tuple[Change, ...]
    lost: tuple[Change, ...]
    chance: float
    cpu_ratio: Estimate | None
    faster: tuple[int, int]
    speed_chance: float
    duration_ratio: Estimate | None

    def as_dict(self) -> dict[str, Any]:
        """Return plain data that JSON can hold."""
        return asdict(self)


@checked
def compare_campaigns(first: CampaignFolder, second: CampaignFolder) -> Comparison:
    """Compare two campaigns, problem by problem.

    Args:
        first: The first campaign.
        second: The second campaign, with another method, options or version.

    Raises:
        CampaignError: If they have no problem in common.
    """
    before, after = _rows(first), _rows(second)
    common = [key for key in before if key in after]
    if not common:
        raise CampaignError(f"{first.path} and {second.path} have no problem in common")
    pairs = [(before[key], after[key]) for key in common]
    gained = [(a, b) for a, b in pairs if b["verified"] and not a["verified"]]
    lost = [(a, b) for a, b in pairs if a["verified"] and not b["verified"]]
    times = [
        (a["cpu_seconds"]["total"], b["cpu_seconds"]["total"])
        for a, b in pairs
        if a["cpu_seconds"] and b["cpu_seconds"]
    ]
    durations = [(a["duration"], b["duration"]) for a, b in pairs if a["verified"] and b["verified"]]
    faster, slower = sum(b < a for a, b in times), sum(b > a for a, b in times)
    return Comparison(
        first=first.name,
        second=second.name,
        common=len(common),
        only_first=len(before) - len(common),
        only_second=len(after) - len(common),
        verified=(sum(a["verified"] for a, _ in pairs), sum(b["verified"] for _, b in pairs)),
        gained=_changes(gained),
        lost=_changes(lost),
        chance=changed_by_chance(len(gained), len(lost)),
        cpu_ratio=_ratio(times),
        faster=(faster, slower),
        speed_chance=changed_by_chance(faster, slower),
        duration_ratio=_ratio(durations),
    )


def _rows(folder: CampaignFolder) -> Mapping[Key, Row]:
    """Return the rows by problem; without the options if each problem has only one."""
    one = len(folder.options) == 1
    return {(str(row["problem_id"]), 0 if one else int(row["options"])): row for row in folder.rows(COLUMNS)}


def _changes(pairs: list[tuple[Row, Row]]) -> tuple[Change, ...]:
    return tuple(Change(b["id"], b["family"], a["status"], b["status"]) for a, b in pairs)


def _ratio(pairs: list[tuple[float, float]]) -> Estimate | None:
    known = [b / a for a, b in pairs if a > 0.0]
    return quantile(np.array(known), 0.5) if known else None
