"""Results on MotionBenchMaker: a table of the robots, and a section for each."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from trajopt_robots._example_robot_data import share_folder

from benchmarks import askable
from benchmarks.page import table, write_section
from benchmarks.workers import Row
from trajopt.cli.suite import set_table, stage_table, winners
from trajopt.lab.suite import RunOutcome
from trajopt.lab.suite.instance import by_set, row, summary
from trajopt.planning.status import Status
from trajopt.values.documents.document import write_json

TITLES = {"panda": "Panda", "ur5": "UR5", "fetch": "Fetch", "baxter": "Baxter, both arms"}
INSTEAD = {"hang": Status.OUT_OF_TIME, "crash": Status.METHOD_CANNOT, "refused": Status.METHOD_CANNOT}
"""Status of problems that returned none."""
HEAD = (
    "robot", "problems", "answerable", "verified of these", "share", "hangs", "attempts median / p90",
    "CPU ms median / p90", "times the Panda's",
)  # fmt: skip
LONGEST = 220
"""Longer reasons are cut in the page."""


@dataclass(frozen=True)
class Done:
    """A robot's problems.

    Attributes:
        name: The robot's.
        outcomes: What became of each.
        reasons: Problem -> why nobody could answer it, in words; empty where it can be asked.
        hangs: How many were ended by the clock.
    """

    name: str
    outcomes: Sequence[RunOutcome]
    reasons: Mapping[str, list[str]]
    hangs: int

    def askable(self, outcome: RunOutcome) -> bool:
        """Return whether a problem is answerable."""
        return not self.reasons[outcome.problem]

    @property
    def asked(self) -> list[RunOutcome]:
        return [outcome for outcome in self.outcomes if self.askable(outcome)]

    @property
    def solved(self) -> list[RunOutcome]:
        return [outcome for outcome in self.asked if outcome.verified]


def write_results(
    data: Path,
    found: Mapping[str, Sequence[Row]],
    *,
    seconds: float,
    results: Path | None,
    page: Path | None,
) -> None:
    """Print tables; write them into a page and the numbers into a folder, where there are such.

    Args:
        data: The folder of the robots' problems.
        found: Robot -> rows of its problems.
        seconds: Time that a hang stands for [s].
        results: Folder of the numbers.
        page: Markdown file with the sections' markers.
    """
    robots = [done(data, name, rows, seconds) for name, rows in found.items()]
    texts = {"robots": comparison(robots)}
    if results is not None:
        write_json(results / "robots.json", {item.name: numbers(item) for item in robots})
    for item in robots:
        total, sets = summary(item.outcomes, item.askable), by_set(item.outcomes, item.askable)
        texts[item.name] = section(item, total, sets)
        if results is not None:
            lines = [{k: v for k, v in row(told).items() if k != "cpu_seconds"} for told in item.outcomes]
            write_json(results / f"{item.name}.json", {"summary": total, "sets": sets, "problems": lines})
    for name, text in texts.items():
        print(f"{name}\n\n{text}\n", flush=True)
        if page is not None:
            write_section(page, name, text)


def done(data: Path, name: str, rows: Sequence[Row], seconds: float) -> Done:
    """Return the outcomes of a robot's problems."""
    outcomes = [outcome_of(row, seconds) for row in rows]
    machine = machine_of(data, name)
    files = askable.problems(data / name)
    reasons = {item.problem: askable.faults(machine, *files[item.problem]) for item in outcomes}
    return Done(name, outcomes, reasons, sum(row["outcome"] == "hang" for row in rows))


def machine_of(data: Path, name: str) -> askable.Machine:
    """Read a robot without the planner."""
    if name == "panda":
        share = Path(share_folder())
        urdf = share / "example-robot-data/robots/panda_description/urdf/panda.urdf"
        srdf = Path(__file__).parents[1] / "robots/trajopt_robots/panda/panda.srdf"
        return askable.read_machine(urdf, srdf, share)
    folder = data / name / "robot"
    return askable.read_machine(folder / f"{name}.urdf", folder / f"{name}.srdf", folder)


def outcome_of(row: Row, seconds: float) -> RunOutcome:
    """Return a row's outcome; one that hung took all of its time."""
    if "told" in row:
        return RunOutcome.from_dict(cast("Mapping[str, object]", row["told"]))
    ended = str(row["outcome"])
    return RunOutcome(
        problem=f"{str(row['family']).split('/')[1]}/{row['seed']}",
        solver="sqp",
        expected=Status.SOLVED,
        status=INSTEAD[ended],
        message=f"{ended}: {row['detail']}",
        cpu_seconds=seconds if ended == "hang" else 0.0,
    )


def numbers(item: Done) -> dict[str, object]:
    """Return the figures of a robot's row of the comparison."""
    cpu, attempts = [told.cpu_seconds for told in item.asked], [told.attempts for told in item.solved]

    def middle(values: Sequence[float]) -> list[float] | None:
        return [float(np.percentile(values, share)) for share in (50, 90)] if values else None

    return {
        "problems": len(item.outcomes),
        "askable": len(item.asked),
        "verified": len(item.solved),
        "hangs": item.hangs,
        "attempts": middle(attempts),
        "cpu_seconds": middle(cpu),
        "won_by": dict(Counter(told.won_by.name for told in item.solved if told.won_by).most_common()),
        "verified_though_not_askable": [
            told.problem for told in item.outcomes if told.verified and not item.askable(told)
        ],
        "not_verified": {
            told.problem: f"{told.status.name}: {told.message}" for told in item.asked if not told.verified
        },
        "not_askable": {name: reasons for name, reasons in item.reasons.items() if reasons},
    }


def comparison(robots: Sequence[Done]) -> str:
    """Return the table of the robots, each compared with the Panda of the same run."""
    by_name = {item.name: numbers(item) for item in robots}
    panda = cast("list[float] | None", by_name.get("panda", {}).get("cpu_seconds"))
    rows: list[list[str]] = []
    for name, told in by_name.items():
        asked, verified = cast("int", told["askable"]), cast("int", told["verified"])
        attempts, cpu = (cast("list[float] | None", told[key]) for key in ("attempts", "cpu_seconds"))
        rows.append(
            [
                TITLES[name],
                str(told["problems"]),
                str(asked),
                str(verified),
                f"{100 * verified / asked:.1f} %" if asked else "",
                str(told["hangs"]),
                _two(attempts, 1.0, ".0f"),
                _two(cpu, 1e3, ".0f"),
                "" if cpu is None or panda is None else f"{cpu[0] / panda[0]:.1f} / {cpu[1] / panda[1]:.1f}",
            ]
        )
    return table(HEAD, rows)


def _two(values: Sequence[float] | None, factor: float, form: str) -> str:
    return "" if values is None else " / ".join(format(value * factor, form) for value in values)


def section(item: Done, total: dict[str, object], sets: dict[str, dict[str, object]]) -> str:
    """Return a robot's section: sets, stages, winning seeds, and unverified problems with reasons."""
    failed = [told for told in item.asked if not told.verified]
    lines = [f"- {told.problem}: {told.status.name}: {told.message[:LONGEST]}" for told in failed]
    return "\n\n".join(
        (
            set_table({**sets, "all": total}),
            stage_table(total),
            f"Won by {winners(total)}.",
            "\n".join(lines) or "All answerable problems are solved.",
        )
    )
