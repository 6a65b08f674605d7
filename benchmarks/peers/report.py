"""Sums and the table of a comparison."""

import json
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

Record = dict[str, Any]
REFERENCE = "trajopt"
SHARES = {
    "claimed": ("claimed",),
    "path free (or 1 mm)": ("path_free", "path_nearly_free"),
    "motion free (or 1 mm)": ("motion_free", "motion_nearly_free"),
    "and limits proven": ("motion_free_within_limits",),
    "and limits within 2 %": ("motion_free_nearly_within_limits",),
}
"""Columns, with the keys of the shares of the problems in each."""
SPREADS = {
    "path_cpu": ("CPU ms to the path", ("median", "p90"), 1000, ".0f"),
    "motion_cpu": ("CPU ms to the motion", ("median", "p90"), 1000, ".0f"),
    "timing_cpu": ("of this, timing", ("median",), 1000, ".0f"),
    "setup_cpu": ("set-up ms", ("median",), 1000, ".0f"),
    "duration_ratio": ("motion time", ("median",), 1, ".2f"),
    "path_length": ("path rad", ("median",), 1, ".2f"),
    "path_clearance": ("path clearance mm", ("least", "median"), 1000, ".1f"),
    "motion_clearance": ("motion clearance mm", ("least", "median"), 1000, ".1f"),
    "mean_acceleration": ("acceleration", ("median", "most"), 1, ".2f"),
}
"""Keys of spreads, with their columns: title, quantity, factor, form."""


def summary(records: Sequence[Record], reference: Sequence[Record]) -> Record:
    """Sum up the judged records of one planner.

    Args:
        records: One for each problem.
        reference: Those of trajopt, of the same problems in the same order.
    """
    both = [
        (mine["motion"], its["motion"])
        for mine, its in zip(records, reference, strict=True)
        if _free(mine, "motion") and _free(its, "motion")
    ]
    paths = [record["path"] for record in records if _free(record, "path")]
    motions = [record["motion"] for record in records if _free(record, "motion")]
    timed = [record["motion"] for record in records if record["motion"] is not None]
    return {
        "problems": len(records),
        "claimed": _share(records, lambda record: record["claimed"]),
        "path_free": _share(records, lambda record: _free(record, "path")),
        "path_nearly_free": _share(records, lambda record: _free(record, "path", "nearly_free")),
        "motion_nearly_free": _share(records, lambda record: _free(record, "motion", "nearly_free")),
        "motion_free": _share(records, lambda record: _free(record, "motion")),
        "motion_free_within_limits": _share(
            records, lambda record: _free(record, "motion") and record["motion"]["within"]
        ),
        "motion_free_nearly_within_limits": _share(
            records, lambda record: _free(record, "motion") and record["motion"]["nearly_within"]
        ),
        "path_cpu": _spread([record["path_cpu"] for record in records]),
        "motion_cpu": _spread([_both_cpu(record) for record in records]),
        "timing_cpu": _spread([record["timing_cpu"] for record in records if record["claimed"]]),
        "setup_cpu": _spread([record["setup_cpu"] for record in records]),
        "path_length": _spread([path["length"] for path in paths]),
        "common": len(both),
        "duration_ratio": _spread([mine["duration"] / its["duration"] for mine, its in both]),
        "path_clearance": _spread([path["clearance"] for path in paths]),
        "motion_clearance": _spread([motion["clearance"] for motion in motions]),
        "acceleration": _spread([motion["acceleration"] for motion in timed]),
        "mean_acceleration": _spread([motion["mean_acceleration"] for motion in timed]),
        "velocity": _spread([motion["velocity"] for motion in timed]),
    }


def _free(record: Record, key: str, how: str = "free") -> bool:
    return record[key] is not None and record[key][how]


def _both_cpu(record: Record) -> float | None:
    return None if record["path_cpu"] is None else record["path_cpu"] + record["timing_cpu"]


def _share(records: Sequence[Record], holds: Callable[[Record], bool]) -> float:
    return sum(map(holds, records)) / len(records)


def _spread(values: Sequence[float | None]) -> dict[str, float] | None:
    known = [value for value in values if value is not None]
    if not known:
        return None
    return {
        "least": float(np.min(known)),
        "median": float(np.median(known)),
        "p90": float(np.percentile(known, 90)),
        "most": float(np.max(known)),
    }


def tables(planners: Sequence[Record]) -> str:
    """Return two Markdown tables with a row for each planner: verdicts, and costs."""
    shares = [_row(("planner", "problems", *SHARES)), "|---" * (len(SHARES) + 2) + "|"]
    titles = [title for title, *_ in SPREADS.values()]
    spreads = [_row(("planner", *titles)), "|---" * (len(titles) + 1) + "|"]
    for planner in planners:
        label, row = planner["label"], planner["summary"]
        if row is None:
            shares.append(_row((label, planner["unusable"], *[""] * len(SHARES))))
            continue
        shares.append(_row((label, str(row["problems"]), *(_percent(row, keys) for keys in SHARES.values()))))
        cells = {key: _numbers(row[key], *form) for key, (_, *form) in SPREADS.items()}
        cells["duration_ratio"] += f" ({row['common']})"
        spreads.append(_row((label, *cells.values())))
    return "\n".join((*shares, "", *spreads))


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _percent(row: Record, keys: Sequence[str]) -> str:
    first, *others = (f"{100 * row[key]:.1f} %" for key in keys)
    return first + "".join(f" ({other})" for other in others)


def _numbers(spread: dict[str, float] | None, keys: Sequence[str], factor: float, form: str) -> str:
    return "-" if spread is None else " / ".join(format(spread[key] * factor, form) for key in keys)


def section(document: Record) -> str:
    """Return the section of the benchmarks' page: the tables, and their conditions."""
    left_out = document["left_out"]
    which = f"the first {document['limit']} of each of {len(document['sets'])} sets"
    if left_out:
        which += f", without {', '.join(left_out)} (start or goal beyond a limit or in collision)"
    return "\n".join(
        (
            f"{document['problems']} problems: {which}. {document['date']}; one run, one core, one process",
            f"at a time; at most {document['time_limit']:g} s a problem.",
            "",
            tables(document["planners"]),
        )
    )


def compact(label: str, record: Record) -> str:
    """Return a judged record as one line of JSON, numbers to five digits."""
    return json.dumps({"planner": label, **_rounded(record)}, separators=(",", ":"))


def _rounded(value: Any) -> Any:
    match value:
        case dict():
            return {key: _rounded(inner) for key, inner in value.items() if inner != ""}
        case float():
            return float(f"{value:.5g}")
        case _:
            return value
