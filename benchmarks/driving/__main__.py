"""Thousands of simulated runs with surprises, by the supervisor and by other rules.

python -m benchmarks.driving [--runs 10000] [--beside 500] [--beyond 500] [--page FILE] [--json FILE]

--runs     of the supervisor, within the errors that were stated (`drawing.py`)
--beside   of these, so many also by a supervisor that plans from rest only, and by MoveIt's rule
           (`waypoints.py`)
--beyond   runs beyond the stated errors, reported apart

The runs go around the problems, one seed after the other. Rows are kept in --out; what has one is not driven
again, unless it is named in --anew, as failures are that were mended: "cup_past_pillar 17 late supervisor".
Several processes share the seeds, each with its own --out: --share 1/2 and --share 2/2. The table of all is
written with the folders of the others in --also.
"""

import argparse
import json
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from math import inf
from pathlib import Path

import trajopt as to
from benchmarks.driving.drawing import TOLERANCE, Part, drawn, part_of
from benchmarks.driving.report import failed, page
from benchmarks.driving.waypoints import PERIOD, WaypointPilot
from benchmarks.page import write_section
from benchmarks.rows import Rows
from trajopt.driving import EventKind, RunReport, Supervisor, SupervisorOptions, undisturbed
from trajopt.driving.rehearsal import driven_by
from trajopt.values.errors import TrajoptError

PROBLEMS = (
    "cup_past_pillar", "bookshelf_ur5", "past_pillar_xarm7", "two_arms_meet", "past_column_pr2",
    "narrow_mouth_panda", "cage_ur5", "cup_through_gap_xarm7", "planar_fold", "past_column_tiago",
    "cage_panda", "turn_over_ur5", "bookshelf_xarm7", "bar_panda", "hand_on_plane_panda",
    "level_tray_ur5", "bar_xarm7", "keep_in_view_panda", "past_pillar_ur5", "under_table_xarm7",
)  # fmt: skip
"""What is driven: arms of six to twelve joints, two arms, and bases that move."""
SUPERVISOR, FROM_REST, WAYPOINTS = "supervisor", "plans from rest only", "MoveIt's rule"


@dataclass(frozen=True)
class Way:
    """A way to drive.

    Attributes:
        options: Of the supervisor.
        pilot: What drives.
    """

    options: SupervisorOptions
    pilot: type[Supervisor] | type[WaypointPilot]


WAYS = {
    SUPERVISOR: Way(SupervisorOptions(), Supervisor),
    FROM_REST: Way(SupervisorOptions(on_the_way=False), Supervisor),
    WAYPOINTS: Way(SupervisorOptions(cycle=PERIOD), WaypointPilot),
}


@cache
def problem_of(name: str) -> to.Problem:
    """Return a problem."""
    return to.named_problem(name)


@cache
def motion_of(name: str, tolerance: float) -> to.Trajectory:
    """Return its motion where nothing happens; joints may be so far from where they have to be [rad | m]."""
    return undisturbed(problem_of(name), tolerance=tolerance)


def keys(
    names: Sequence[str], runs: int, beside: int, beyond: int, *, share: tuple[int, int] = (1, 1)
) -> Iterator[tuple[str, int, Part, str]]:
    """Yield what is to be driven: problem, seed, part and way; the comparisons spread among the runs.

    Args:
        names: Of the problems.
        runs: How many of the supervisor, within the errors that were stated.
        beside: Of these, so many by other rules too.
        beyond: How many beyond the errors.
        share: Only the seeds of one share of so many.
    """
    for number in range(max(runs, beside, beyond)):
        name, seed = names[number % len(names)], number // len(names)
        if seed % share[1] != share[0] - 1:
            continue
        if number < runs:
            yield name, seed, part_of(seed), SUPERVISOR
        if number < beyond:
            yield name, seed, Part.BEYOND, SUPERVISOR
        if number < beside:
            yield name, seed, part_of(seed), FROM_REST
            yield name, seed, part_of(seed), WAYPOINTS


def row_of(key: str, part: Part, done: RunReport, seconds: float) -> dict[str, object]:
    """Return what is kept of a run: its events, where it failed.

    A robot at rest that is run into is pushed off where it has to be: that it says so then is no failure.
    """
    touched = min((contact.start for contact in done.contacts), default=inf)
    lost = [
        each
        for each in done.events
        if each.kind in (EventKind.OFF_TRACK, EventKind.FAULT) and each.time < touched
    ]
    row: dict[str, object] = {
        "key": key,
        "part": part.value,
        "reached": done.reached,
        "duration": done.duration,
        "contacts": [str(each) for each in done.contacts],
        "contacts_at_fault": [str(each) for each in done.contacts_at_fault],
        "measured": done.clearance_measured,
        "proven": done.clearance_proven,
        "unproven_stops": done.count(EventKind.UNPROVEN_STOP),
        "stops": done.count(EventKind.STOPPING),
        "replans": done.count(EventKind.REPLANNED),
        "plans": done.count(EventKind.REPLANNED, EventKind.STARTED),
        "off_track": len(lost),
        "cpu": seconds,
    }
    if failed(row) or not done.reached:
        row["events"] = [str(event) for event in done.events][:40]
    return row


def driven(name: str, seed: int, part: Part, way: Way, key: str) -> dict[str, object]:
    """Drive once; an exception becomes a row with its message and place."""
    try:
        return _driven(name, seed, part, way, key)
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        words = f"{type(error).__name__}: {error} ({Path(where.filename).name}, line {where.lineno})"
        return {"key": key, "part": part.value, "error": words}


def _driven(name: str, seed: int, part: Part, way: Way, key: str) -> dict[str, object]:
    begun = time.process_time()
    try:
        found = drawn(problem_of(name), partial(motion_of, name), part, seed)
    except TrajoptError as error:
        return {"key": key, "part": part.value, "not_drawn": str(error)}
    done = driven_by(
        lambda arm: way.pilot(arm, found.problem, way.options),
        found.problem,
        surprises=found.surprises,
        cycle=way.options.cycle,
        tolerance=TOLERANCE,
    )
    return row_of(key, part, done, time.process_time() - begun)


def share_of(words: str) -> tuple[int, int]:
    """Read which share of how many is meant: 1/2.

    Raises:
        ValueError: If there is no such share.
    """
    own, count = map(int, words.split("/"))
    if not 1 <= own <= count:
        raise ValueError(words)
    return own, count


def main(words: Sequence[str] | None = None) -> None:
    """Drive the runs without a row, and write the table of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--beside", type=int, default=500)
    parser.add_argument("--beyond", type=int, default=500)
    parser.add_argument("--problems", default=",".join(PROBLEMS), help="names, separated by commas")
    parser.add_argument("--out", type=Path, default=Path("out/driving"), help="folder of the rows")
    parser.add_argument("--anew", default="", help="keys whose rows are dropped first, separated by commas")
    parser.add_argument("--share", type=share_of, default=(1, 1), help="of the seeds: 1/2 is the first half")
    parser.add_argument("--also", default="", help="other folders of rows for the table, separated by commas")
    parser.add_argument("--json", type=Path, help="file for the numbers")
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    asked = parser.parse_args(words)
    rows = Rows(asked.out / "rows.jsonl")
    others = {
        key: row
        for folder in filter(None, asked.also.split(","))
        for key, row in Rows(Path(folder) / "rows.jsonl").done.items()
    }
    names, dropped = asked.problems.split(","), {key.strip() for key in asked.anew.split(",")}
    for name, seed, part, way in keys(names, asked.runs, asked.beside, asked.beyond, share=asked.share):
        key = f"{name} {seed} {part.value} {way}"
        if key not in dropped and (key in rows.done or key in others):
            continue
        row = driven(name, seed, part, WAYS[way], key)
        rows.append(row)
        if failed(row):
            print(json.dumps(row), flush=True)
    driven_all = [*(others | rows.done).values()]
    text = page(driven_all, names)
    print(text)
    if asked.json is not None:
        asked.json.write_text(json.dumps(driven_all, indent=1))
    if asked.page is not None:
        write_section(asked.page, "driving", text)


if __name__ == "__main__":
    main()
