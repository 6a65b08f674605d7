"""Thousands of runs in the simulated world, with surprises; and what drives the robot by other rules.

python -m benchmarks.driving [--runs 10000] [--beside 500] [--beyond 500] [--page FILE] [--json FILE]

--runs     of the supervisor, within the errors that were stated (`drawing.py`)
--beside   of these, so many also by a supervisor that plans from rest only, and by MoveIt's rule
           (`waypoints.py`)
--beyond   runs beyond the stated errors, reported apart

The runs go around the problems, one seed after the other. Rows are kept in --out; what has one is not driven
again, unless it is named in --anew, as failures are that were mended: "cup_past_pillar 17 late supervisor".
"""

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import trajopt as to
from benchmarks.driving.drawing import Part, drawn, part_of
from benchmarks.driving.report import failed, page
from benchmarks.driving.waypoints import PERIOD, WaypointPilot
from benchmarks.page import write_section
from benchmarks.rows import Rows
from trajopt.errors import TrajoptError
from trajopt.execution import Kind, Run, Supervisor, SupervisorOptions, undisturbed
from trajopt.execution.run import driven_by

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


def keys(names: Sequence[str], runs: int, beside: int, beyond: int) -> Iterator[tuple[str, int, Part, str]]:
    """Yield what is to be driven: problem, seed, part and way; the comparisons spread among the runs."""
    for number in range(max(runs, beside, beyond)):
        name, seed = names[number % len(names)], number // len(names)
        if number < runs:
            yield name, seed, part_of(seed), SUPERVISOR
        if number < beyond:
            yield name, seed, Part.BEYOND, SUPERVISOR
        if number < beside:
            yield name, seed, part_of(seed), FROM_REST
            yield name, seed, part_of(seed), WAYPOINTS


def row_of(key: str, part: Part, done: Run, seconds: float) -> dict[str, object]:
    """Return what is kept of a run: its events, where it failed."""
    row: dict[str, object] = {
        "key": key,
        "part": part.value,
        "reached": done.reached,
        "duration": done.duration,
        "contacts": [str(each) for each in done.contacts],
        "contacts_at_fault": [str(each) for each in done.contacts_at_fault],
        "measured": done.clearance_measured,
        "proven": done.clearance_proven,
        "unproven_stops": done.count(Kind.UNPROVEN_STOP),
        "stops": done.count(Kind.STOPPING),
        "replans": done.count(Kind.REPLANNED),
        "plans": done.count(Kind.REPLANNED, Kind.STARTED),
        "off_track": done.count(Kind.OFF_TRACK, Kind.FAULT),
        "cpu": seconds,
    }
    if failed(row) or not done.reached:
        row["events"] = [str(event) for event in done.events][:40]
    return row


def driven(name: str, seed: int, part: Part, way: Way, key: str) -> dict[str, object]:
    """Drive once."""
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
    )
    return row_of(key, part, done, time.process_time() - begun)


def main(words: Sequence[str] | None = None) -> None:
    """Drive what has no row yet, and write the table of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--beside", type=int, default=500)
    parser.add_argument("--beyond", type=int, default=500)
    parser.add_argument("--problems", default=",".join(PROBLEMS), help="names, separated by commas")
    parser.add_argument("--out", type=Path, default=Path("out/driving"), help="folder of the rows")
    parser.add_argument("--anew", default="", help="keys whose rows are dropped first, separated by commas")
    parser.add_argument("--json", type=Path, help="file for the numbers")
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    asked = parser.parse_args(words)
    rows = Rows(asked.out / "rows.jsonl")
    dropped = {key.strip() for key in asked.anew.split(",")}
    for name, seed, part, way in keys(asked.problems.split(","), asked.runs, asked.beside, asked.beyond):
        key = f"{name} {seed} {part.value} {way}"
        if key in rows.done and key not in dropped:
            continue
        row = driven(name, seed, part, WAYS[way], key)
        rows.append(row)
        if failed(row):
            print(json.dumps(row), flush=True)
    text = page(rows.done.values(), asked.problems.split(","))
    print(text)
    if asked.json is not None:
        asked.json.write_text(json.dumps(list(rows.done.values()), indent=1))
    if asked.page is not None:
        write_section(asked.page, "driving", text)


if __name__ == "__main__":
    main()
