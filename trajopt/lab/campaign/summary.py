"""What came of a campaign: success and times by robot and set, causes, and the places of a base."""

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
"""Confidence of every interval."""
NORMAL = 1.959963984540054
"""Quantile of the normal distribution for it."""


@dataclass(frozen=True)
class Estimate:
    """A number, and where it may be as far as the sample tells.

    Attributes:
        value: The number.
        low: Lower end of its interval at 95 %.
        high: Upper end.
    """

    value: float
    low: float
    high: float


def share(count: int, total: int) -> Estimate:
    """Return a share with its interval.

    Source: Wilson, Probable inference, the law of succession, and statistical inference, 1927.

    Args:
        count: How many did.
        total: Of how many, at least 1.
    """
    part, square = count / total, NORMAL**2
    middle = (part + square / (2.0 * total)) / (1.0 + square / total)
    half = NORMAL / (1.0 + square / total) * sqrt(part * (1.0 - part) / total + square / (4.0 * total**2))
    return Estimate(part, max(0.0, min(part, middle - half)), min(1.0, max(part, middle + half)))


def quantile(values: Sequence[float] | Floats, level: float) -> Estimate:
    """Return a quantile with its interval, whatever the distribution: two of the values themselves.

    How many of n values lie below the quantile is binomial. Of fewer values than it takes for an interval
    at 95 % the ends are the least and the largest.

    Source: David and Nagaraja, Order Statistics, 2003, section 7.1.

    Args:
        values: The values, at least one.
        level: Which quantile, in (0, 1).
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
    """Return how likely it is that at least so uneven a change of the same problems is chance.

    The exact test of McNemar: were there no difference, each of the changes would be a fair coin's.

    Args:
        gained: Problems solved in the second run only.
        lost: Problems solved in the first run only.
    """
    from scipy.stats import binomtest

    changes = gained + lost
    return float(binomtest(gained, changes, 0.5).pvalue) if changes else 1.0


COLUMNS = (
    *("problem_id", "robot", "family", "options", "status", "verified", "cause", "clearance", "duration"),
    *("cpu_seconds", "parameters"),
)
"""What a summary reads of the results: not the motions."""
AXES = ("x", "y", "yaw")
"""Parameters that say where a base stands."""


@dataclass(frozen=True)
class Group:
    """Some rows of a campaign.

    Attributes:
        name: What they have in common.
        rows: How many there are.
        verified: Those with a verified motion.
        success: Their share.
        cpu_median: Process time of one problem, all included [s]; None where none was measured.
        cpu_p90: The same that nine of ten do not exceed [s].
        duration: Median duration of the verified motions [s]; None without any.
        clearance: The smallest proven clearance [m]; None without any.
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
    """How well each place of a base does, over all turns and tasks.

    Attributes:
        x: Places along x, shape (a,) [m].
        y: Places along y, shape (b,) [m].
        verified: Rows with a verified motion by place, shape (b, a).
        rows: Rows by place, shape (b, a).
        best: Where most is verified: x, y [m], yaw [rad], and the share of the tasks there.
    """

    x: Floats
    y: Floats
    verified: Floats
    rows: Floats
    best: tuple[float, float, float, float]


@dataclass(frozen=True)
class Summary(Value):
    """What came of a campaign.

    Attributes:
        name: The campaign's.
        total: Rows that there are to be.
        whole: All rows there are.
        by_robot: Groups by robot.
        by_family: Groups by what the problems are counted with.
        by_options: Groups by method and options.
        causes: How often each cause of failure is there, most often first.
        times: Process time of every row that has one, ascending [s].
        places: Where bases stood; None where the campaign is not about that.
    """

    name: str
    total: int
    whole: Group
    by_robot: Sequence[Group]
    by_family: Sequence[Group]
    by_options: Sequence[Group]
    causes: Mapping[str, int]
    times: Floats = field(repr=False)
    places: PlaceMap | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return plain data that JSON can hold, without the times of single rows."""
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
def summary(folder: CampaignFolder) -> Summary:
    """Sum up the results of a campaign so far.

    Args:
        folder: The campaign.

    Raises:
        CampaignError: If there is no row yet, or a file of the results is damaged.
    """
    rows = list(folder.rows(COLUMNS))
    if not rows:
        raise CampaignError(f"{folder.path} has no row yet")
    ways = [str(each) for each in folder.options]
    times = np.sort([row["cpu_seconds"]["total"] for row in rows if row["cpu_seconds"]])
    failures = Counter(str(row["cause"]) for row in rows if not row["verified"])
    return Summary(
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


def groups(rows: Iterable[Row], name: Callable[[Row], str]) -> tuple[Group, ...]:
    """Return groups of rows by name, in the order of the names.

    Args:
        rows: The rows.
        name: Says of each where it belongs.
    """
    found: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        found[name(row)].append(row)
    return tuple(group(each, found[each]) for each in sorted(found))


def group(name: str, rows: Sequence[Row]) -> Group:
    """Return what rows have come to.

    Args:
        name: What they have in common.
        rows: The rows, at least one.
    """
    solved = [row for row in rows if row["verified"]]
    times = [row["cpu_seconds"]["total"] for row in rows if row["cpu_seconds"]]
    near = [row["clearance"] for row in solved if row["clearance"] is not None]
    return Group(
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
    """Return how well each place of a base does; None where no row says where a base stood."""
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
