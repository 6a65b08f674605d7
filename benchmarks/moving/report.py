"""Tables of the problems with dynamic obstacles."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.moving.asking import BEST, CRASHED, CROSSING, CUBES, KNOWN
from benchmarks.moving.crossings import ROBOTS
from benchmarks.page import table
from benchmarks.workers import Key

TITLES = {"panda": "Panda", "ur5": "UR5"}
WITHIN = 1.10
"""Target ratio to the best duration."""
MOST_LISTED = 12

Rows = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True)
class Report:
    """A problem and its outcome.

    Attributes:
        done: Key -> row, of all parts.
        chosen: The problems that cross.
        rooms: The tests with cubes.
    """

    done: Rows
    chosen: Sequence[Key]
    rooms: Sequence[Key]

    @property
    def rows(self) -> list[Mapping[str, Any]]:
        """The rows of all that was chosen, in order."""
        parts = [(CROSSING, self.chosen), (KNOWN, self.chosen), (BEST, self.chosen), (CUBES, self.rooms)]
        found = [self._row(part, key) for part, keys in parts for key in keys]
        return [row for row in found if row is not None]

    def text(self) -> str:
        """Return the tables that there are rows for."""
        parts = (self._crossing(), self._best(), self._cubes())
        return "\n\n".join(part for part in parts if part)

    def _row(self, part: str, key: Key) -> Mapping[str, Any] | None:
        family = key[0].replace(CROSSING, part, 1)
        return self.done.get(f"{family}-{key[1]}")

    def _crossing(self) -> str:
        head = (
            "crossing boxes", "problems", "with a known motion", "proven of these", "share", "crashed",
            "known only without acceleration limits", "others proven impossible",
            "CPU ms static median / p90", "with the box", "median / median", "median of ratios",
            "CPU ms of proven motions", "duration / static, mean",
        )  # fmt: skip
        lines: list[list[str]] = []
        missed: list[str] = []
        for title, robots in (*((TITLES[name], (name,)) for name in ROBOTS), ("both", ROBOTS)):
            keys = [key for key in self.chosen if key[0].split("/")[1] in robots]
            rows = [(key, row) for key in keys if (row := self._row(CROSSING, key)) is not None]
            if not rows:
                continue
            whole = [(key, row) for key, row in rows if row["outcome"] == "done"]
            known = [(key, row) for key, row in whole if self._known(key, row)]
            proven = [(key, row) for key, row in known if row["ours"]["verified"]]
            others = [(key, row) for key, row in whole if not self._known(key, row)]
            jumping = [key for key, _ in others if self._found(key, "rrt")]
            hopeless = [key for key, row in others if _hopeless(row)]
            if len(robots) == 1:
                missed += [_problem(key) for key, row in known if not row["ours"]["verified"]]
            still, moving = (_cpu([row for _, row in known], name) for name in ("still", "ours"))
            ours = _cpu([row for _, row in proven], "ours")
            longer = [row["ours"]["duration"] / row["still"]["duration"] for _, row in proven]
            lines.append([
                title, str(len(rows)), str(len(known)), str(len(proven)), _share(len(proven), len(known)),
                str(_crashed(rows)), str(len(jumping)), str(len(hopeless)), _two(still), _two(moving),
                f"{np.median(moving) / np.median(still):.1f}" if known else "",
                f"{np.median(moving / still):.1f}" if known else "", _two(ours),
                f"{np.mean(longer):.2f}" if longer else "",
            ])  # fmt: skip
        if not lines:
            return ""
        text = table(head, lines)
        return text + (f"\n\nKnown but not proven: {_listed(missed)}." if missed else "")

    def _known(self, key: Key, row: Mapping[str, Any]) -> bool:
        """Say whether ours, waiting or the baseline has a motion within all limits."""
        if row["ours"]["verified"] or row["wait"] is not None:
            return True
        return self._found(key, "resting")

    def _found(self, key: Key, kind: str) -> bool:
        """Say whether a kind of the baseline has a motion where ours and waiting have none."""
        row = self._row(KNOWN, key)
        return row is not None and bool(row.get(kind, {}).get("duration"))

    def _best(self) -> str:
        head = (
            "durations", "CPU s of the baseline", "problems", "baseline has one", "ours has one",
            "ours / best, mean / median / most", f"within {WITHIN:.2f}", "of these, waiting is possible",
            "ours / waiting, mean", "baseline / waiting, mean",
        )  # fmt: skip
        lines: list[list[str]] = []
        for title, robots in (*((TITLES[name], (name,)) for name in ROBOTS), ("both", ROBOTS)):
            pairs = [
                (one, other)
                for key in self.chosen
                if key[0].split("/")[1] in robots
                and (one := self._row(CROSSING, key)) is not None
                and (other := self._row(BEST, key)) is not None
                and one["outcome"] == other["outcome"] == "done"
            ]
            for seconds in sorted({float(other["seconds"]) for _, other in pairs}):
                alike = [pair for pair in pairs if float(pair[1]["seconds"]) == seconds]
                lines.append([title, f"{seconds:g}", *_durations(alike)])
        return table(head, lines) if lines else ""

    def _cubes(self) -> str:
        head = (
            "cubes", "tests", "ours proven", "share", "CPU ms median / p90",
            "baseline with ten times the CPU", "share", "by either",
            "missed by ours, known within all limits", "proven impossible",
            "ours / baseline, duration, median",
        )  # fmt: skip
        lines: list[list[str]] = []
        for family in dict.fromkeys(family for family, _ in self.rooms):
            rows = [
                row for key in self.rooms if key[0] == family and (row := self._row(CUBES, key)) is not None
            ]
            whole = [row for row in rows if row["outcome"] == "done"]
            if not whole:
                continue
            ours = [row["ours"]["duration"] for row in whole]
            other = [row["rrt"]["duration"] for row in whole]
            both = [one / two for one, two in zip(ours, other, strict=True) if one and two]
            solved, theirs = (sum(value is not None for value in each) for each in (ours, other))
            either = sum(bool(one or two) for one, two in zip(ours, other, strict=True))
            lines.append([
                family.split("/")[1], str(len(rows)), str(solved), _share(solved, len(rows)),
                _two(_cpu(whole, "ours")), str(theirs), _share(theirs, len(rows)), str(either),
                str(sum(bool(row.get("resting", {}).get("duration")) for row in whole)),
                str(sum(_hopeless(row) for row in whole)),
                f"{np.median(both):.2f}" if both else "",
            ])  # fmt: skip
        return table(head, lines) if lines else ""


def _durations(pairs: Sequence[tuple[Mapping[str, Any], Mapping[str, Any]]]) -> list[str]:
    over_best: list[float] = []
    over_waiting: list[float] = []
    baseline: list[float] = []
    for one, other in pairs:
        ours, rrt = one["ours"]["duration"], other["rrt"]["duration"]
        waits = None if one["wait"] is None else one["wait"] + one["still"]["duration"]
        if waits and rrt:
            baseline.append(rrt / waits)
        if ours:
            over_best.append(ours / min(each for each in (ours, rrt, waits) if each))
        if ours and waits:
            over_waiting.append(ours / waits)
    return [
        str(len(pairs)),
        str(sum(bool(other["rrt"]["duration"]) for _, other in pairs)),
        str(len(over_best)),
        f"{np.mean(over_best):.2f} / {np.median(over_best):.2f} / {max(over_best):.2f}" if over_best else "",
        _share(sum(ratio <= WITHIN for ratio in over_best), len(over_best)),
        str(len(over_waiting)),
        f"{np.mean(over_waiting):.2f}" if over_waiting else "",
        f"{np.mean(baseline):.2f}" if baseline else "",
    ]


def _crashed(rows: Sequence[tuple[Key, Mapping[str, Any]]]) -> int:
    """Count exceptions and time-outs."""
    return sum(row["outcome"] != "done" or row["ours"]["status"] == CRASHED for _, row in rows)


def _hopeless(row: Mapping[str, Any]) -> bool:
    """Return whether it is proven that there is no motion."""
    return not row["ours"]["verified"] and row["ours"].get("certainty") == "PROVEN"


def _problem(key: Key) -> str:
    return f"{key[0].partition('/')[2]}/{key[1]}"


def _listed(names: Sequence[str]) -> str:
    more = len(names) - MOST_LISTED
    return ", ".join(names[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")


def _cpu(rows: Sequence[Mapping[str, Any]], name: str) -> np.ndarray:
    return np.array([1e3 * row[name]["cpu"] for row in rows])


def _two(values: np.ndarray) -> str:
    return " / ".join(f"{value:.0f}" for value in np.percentile(values, (50, 90))) if len(values) else ""


def _share(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.1f} %" if whole else ""
