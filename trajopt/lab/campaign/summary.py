"""Summary of a campaign, and the comparison of two."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from math import sqrt
from typing import Any

import numpy as np

from trajopt.lab.campaign.columns import Row
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors import CampaignError
from trajopt.values.errors.arguments import checked

LEVEL = 0.95
NORMAL = 1.959963984540054
"""Quantile of the normal distribution for 95 %."""


@dataclass(frozen=True)
class Estimate:
    """Number with its confidence interval at 95 %."""

    value: float
    low: float
    high: float


def share(count: int, total: int) -> Estimate:
    """Return a share with its interval.

    Source: Wilson, Probable inference, the law of succession, and statistical inference, 1927.
    """
    part, square = count / total, NORMAL**2
    middle = (part + square / (2.0 * total)) / (1.0 + square / total)
    half = NORMAL / (1.0 + square / total) * sqrt(part * (1.0 - part) / total + square / (4.0 * total**2))
    return Estimate(part, max(0.0, min(part, middle - half)), min(1.0, max(part, middle + half)))


def quantile(values: Sequence[float] | Floats, level: float) -> Estimate:
    """Return a quantile with its distribution-free interval, whose ends are two of the values.

    The number of n values below the quantile is binomial. With too few values for an interval at 95 % the
    ends are the smallest and the largest. Source: David and Nagaraja, Order Statistics, 2003, section 7.1.
    """
    from scipy.stats import binom

    ordered = np.sort(np.asarray(values, dtype=np.float64))
    count = len(ordered)
    outside = (1.0 - LEVEL) / 2.0
    low = int(binom.ppf(outside, count, level)) - 1
    high = int(binom.ppf(1.0 - outside, count, level))
    middle = float(np.quantile(ordered, level))
    ends = (float(ordered[max(0, low)]), float(ordered[min(count - 1, high)]))
    return Estimate(middle, min(middle, ends[0]), max(middle, ends[1]))


def changed_by_chance(gained: int, lost: int) -> float:
    """Return the probability of so uneven a change of the same problems by chance (McNemar's exact test)."""
    from scipy.stats import binomtest

    changes = gained + lost
    return float(binomtest(gained, changes, 0.5).pvalue) if changes else 1.0


COLUMNS = (
    *("problem_id", "robot", "family", "options", "status", "verified", "cause", "clearance", "duration"),
    *("cpu_seconds", "parameters"),
)
"""Columns that a summary reads; not the motions."""
AXES = ("x", "y", "yaw")


@dataclass(frozen=True)
class RowGroup:
    """Statistics of some rows of a campaign.

    Attributes:
        cpu_median: Median CPU time of one problem [s]; None if not measured.
        duration: Median duration of the verified motions [s]; None without any.
        clearance: Smallest proven one [m]; None without any.
    """

    name: str
    rows: int
    verified: int
    success: Estimate
    cpu_median: Estimate | None
    cpu_p90: Estimate | None
    duration: float | None
    clearance: float | None


@dataclass(frozen=True)
class PlaceMap(Value):
    """Success of each place of a base, over all turns and tasks.

    Attributes:
        x: Places along x, shape (a,) [m].
        verified: Rows with a verified motion by place, shape (b, a).
        best: The best placement: x, y [m], yaw [rad], and its share of verified tasks.
    """

    x: Floats
    y: Floats
    verified: Floats
    rows: Floats
    best: tuple[float, float, float, float]


@dataclass(frozen=True)
class CampaignSummary(Value):
    """Summary of a campaign.

    Attributes:
        times: CPU times of all rows, ascending [s].
    """

    name: str
    total: int
    whole: RowGroup
    by_robot: Sequence[RowGroup]
    by_family: Sequence[RowGroup]
    by_options: Sequence[RowGroup]
    causes: Mapping[str, int]
    times: Floats = field(repr=False)
    places: PlaceMap | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return plain JSON data, without the times of single rows."""
        groups = {"by_robot": self.by_robot, "by_family": self.by_family, "by_options": self.by_options}
        return {
            "name": self.name,
            "total": self.total,
            "whole": asdict(self.whole),
            **{name: [asdict(each) for each in found] for name, found in groups.items()},
            "causes": dict(self.causes),
            "best_place": None
            if self.places is None
            else dict(zip((*AXES, "share"), self.places.best, strict=True)),
        }


@checked
def summary(folder: CampaignFolder) -> CampaignSummary:
    """Summarise the present results of a campaign, at least one."""
    rows = list(folder.rows(COLUMNS))
    if not rows:
        raise CampaignError(f"{folder.path} has no row yet")
    ways = [str(each) for each in folder.options]
    times = np.sort([row["cpu_seconds"]["total"] for row in rows if row["cpu_seconds"]])
    failures = Counter(str(row["cause"]) for row in rows if not row["verified"])
    return CampaignSummary(
        folder.name,
        folder.total,
        group("all", rows),
        groups(rows, lambda row: str(row["robot"])),
        groups(rows, lambda row: str(row["family"])),
        groups(rows, lambda row: ways[int(row["options"])]),
        dict(failures.most_common()),
        np.asarray(times, dtype=np.float64),
        place_map(rows),
    )


def groups(rows: Iterable[Row], name: Callable[[Row], str]) -> tuple[RowGroup, ...]:
    found: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        found[name(row)].append(row)
    return tuple(group(each, found[each]) for each in sorted(found))


def group(name: str, rows: Sequence[Row]) -> RowGroup:
    """Return statistics of at least one row."""
    solved = [row for row in rows if row["verified"]]
    times = [row["cpu_seconds"]["total"] for row in rows if row["cpu_seconds"]]
    near = [row["clearance"] for row in solved if row["clearance"] is not None]
    return RowGroup(
        name=name,
        rows=len(rows),
        verified=len(solved),
        success=share(len(solved), len(rows)),
        cpu_median=quantile(times, 0.5) if times else None,
        cpu_p90=quantile(times, 0.9) if times else None,
        duration=float(np.median([row["duration"] for row in solved])) if solved else None,
        clearance=min(near, default=None),
    )


def place_map(rows: Iterable[Row]) -> PlaceMap | None:
    """Return the success of each place of a base; None if no row has a placement."""
    at: dict[tuple[float, float, float], list[bool]] = defaultdict(list)
    for row in rows:
        if set(AXES) <= row["parameters"].keys():
            x, y, yaw = (row["parameters"][axis] for axis in AXES)
            at[x, y, yaw].append(bool(row["verified"]))
    if not at:
        return None
    along_x, along_y = (sorted({place[axis] for place in at}) for axis in (0, 1))
    verified, count = np.zeros((2, len(along_y), len(along_x)))
    for (x, y, _), held in at.items():
        cell = along_y.index(y), along_x.index(x)
        verified[cell] += sum(held)
        count[cell] += len(held)
    best = max(at, key=lambda place: (sum(at[place]) / len(at[place]), tuple(-abs(value) for value in place)))
    share_there = sum(at[best]) / len(at[best])
    return PlaceMap(np.array(along_x), np.array(along_y), verified, count, (*best, share_there))


Key = tuple[str, int]
"""A problem, and the number of the options it was planned with."""


@dataclass(frozen=True)
class RowChange:
    """A problem with another outcome in the second campaign."""

    id: str
    family: str
    before: str
    after: str


@dataclass(frozen=True)
class Comparison:
    """Differences of two campaigns on their common problems.

    Attributes:
        verified: Verified motions of the common problems, in the first and in the second.
        chance: Probability of such an uneven change by chance, by McNemar's exact test.
        cpu_ratio: CPU time of the second over the first, the median over the common problems.
        faster: Common problems that took the second less CPU time, and more.
        speed_chance: Probability of such an uneven count by chance, by the exact sign test.
        duration_ratio: As `cpu_ratio`, for the motions' durations.
    """

    first: str
    second: str
    common: int
    only_first: int
    only_second: int
    verified: tuple[int, int]
    gained: tuple[RowChange, ...]
    lost: tuple[RowChange, ...]
    chance: float
    cpu_ratio: Estimate | None
    faster: tuple[int, int]
    speed_chance: float
    duration_ratio: Estimate | None

    def as_dict(self) -> dict[str, Any]:
        """Return plain JSON data."""
        return asdict(self)


@checked
def compare_campaigns(first: CampaignFolder, second: CampaignFolder) -> Comparison:
    """Compare two campaigns, problem by problem; they must have a problem in common."""
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
    one = len(folder.options) == 1
    return {(str(row["problem_id"]), 0 if one else int(row["options"])): row for row in folder.rows(COLUMNS)}


def _changes(pairs: list[tuple[Row, Row]]) -> tuple[RowChange, ...]:
    return tuple(RowChange(b["id"], b["family"], a["status"], b["status"]) for a, b in pairs)


def _ratio(pairs: list[tuple[float, float]]) -> Estimate | None:
    known = [b / a for a, b in pairs if a > 0.0]
    return quantile(np.array(known), 0.5) if known else None
