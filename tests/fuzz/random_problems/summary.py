"""The table of all that was asked."""

from collections import Counter
from collections.abc import Sequence
from statistics import median

from tests.fuzz.random_problems.trial import FALSE


def summary(rows: Sequence[dict[str, object]]) -> str:
    """Return a table of the rows, a line for each family, and what must not be, one by one."""
    lines = [
        "| family | asked | motion known | of these verified | verified | refused as input | proven | "
        + " | ".join(FALSE)
        + " | CPU median / p90 / most [s] | failures by status |",
        "|" + "---|" * (9 + len(FALSE)),
    ]
    for family in [*dict.fromkeys(str(row["family"]) for row in rows), "all"]:
        mine = [row for row in rows if family in (row["family"], "all")]
        lines.append(_line(family, mine))
    wrong = [row for row in rows if row["outcome"] in FALSE]
    lines += ["", f"{len(wrong)} of {len(rows)} must not be."]
    lines += [f"- {row['key']}: {row['outcome']}: {row['detail']}" for row in wrong]
    return "\n".join(lines) + "\n"


def _line(family: str, rows: Sequence[dict[str, object]]) -> str:
    count = Counter(str(row["outcome"]) for row in rows)
    known = [row for row in rows if row.get("known") == "feasible"]
    cpu = sorted(float(str(row["cpu"])) for row in rows if "cpu" in row)
    by_status = Counter(str(row["status"]) for row in rows if row["outcome"] == "failed")
    cells = [
        family,
        len(rows),
        len(known),
        sum(row["outcome"] == "verified" for row in known),
        count["verified"],
        count["refused"],
        sum(bool(row.get("proven")) for row in rows),
        *(count[outcome] for outcome in FALSE),
        f"{median(cpu):.2f} / {cpu[int(0.9 * (len(cpu) - 1))]:.2f} / {cpu[-1]:.2f}" if cpu else "",
        ", ".join(f"{name} {number}" for name, number in by_status.most_common()),
    ]
    return "| " + " | ".join(str(cell) for cell in cells) + " |"
