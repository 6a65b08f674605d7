"""Robots driven in the simulated world while boxes appear in their way, by the rule of `random_surprise`.

python -m benchmarks.execution [--runs 100] [--seed 0] [--json FILE] [--page FILE]

Each problem is planned, and driven with as many seeds as are asked for: once by the supervisor as it is,
and once by one that plans only once the robot stands. Every run is measured by the simulation, and judged.
Contacts at fault are those that are met while the robot moves. Times of stages are CPU time, beside the
median of a plan of the same problems, in the same process, from rest and in a world that stands still.
"""

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.execution import Kind, Run, SupervisorOptions, random_surprise, run, undisturbed

PROBLEMS = ("cup_past_pillar", "bookshelf_panda", "bookshelf_ur5", "past_pillar_ur5", "past_pillar_xarm7")
PLANS = 15
WAYS = {"supervisor": SupervisorOptions(), "plans from rest only": SupervisorOptions(on_the_way=False)}
STAGES = ("cycle", "prove", "look again", "stop", "plan")


@dataclass
class Tally:
    """What became of the runs of one way."""

    runs: list[Run] = field(default_factory=list[Run])
    plans: list[float] = field(default_factory=list[float])

    def row(self) -> list[str]:
        """The row of the table."""
        below = [
            1e3 * (each.clearance_proven - each.clearance_measured)
            for each in self.runs
            if each.clearance_proven
        ]
        return [
            str(len(self.runs)),
            str(sum(each.reached for each in self.runs)),
            str(sum(bool(each.contacts_at_fault) for each in self.runs)),
            str(sum(each.count(Kind.UNPROVEN_STOP) > 0 for each in self.runs)),
            f"{max(below):.2f}",
            str(sum(each.count(Kind.REPLANNED) > 0 for each in self.runs)),
            str(sum(each.count(Kind.STOPPING) > 0 for each in self.runs)),
            f"{np.median([each.duration for each in self.runs]):.2f}",
        ]

    def shares(self, stage: str) -> list[str]:
        """Median, 99 and 99.9 percent of a stage's CPU time, beside the median of a plan."""
        times = np.array([second for each in self.runs for second in each.seconds.get(stage, ())])
        if not len(times):
            return ["-"] * 5
        still = float(np.median(self.plans))
        found = np.percentile(times, (50.0, 99.0, 99.9))
        return [str(len(times)), f"{1e3 * found[0]:.2f}", *(f"{each / still:.3f}" for each in found)]


def measured(name: str, seeds: range, tallies: dict[str, Tally]) -> None:
    """Drive one problem, with each way in turn."""
    problem = to.named_problem(name)
    motion = undisturbed(problem)
    for _ in range(PLANS):
        begin = time.process_time()
        to.plan(problem)
        took = time.process_time() - begin
        for tally in tallies.values():
            tally.plans.append(took)
    for seed in seeds:
        surprises = random_surprise(problem, motion, seed)
        for way, options in WAYS.items():
            tallies[way].runs.append(run(problem, surprises=surprises, options=options))


def page(tallies: dict[str, Tally]) -> str:
    """Return the section of the page."""
    heads = [
        "", "runs", "reached the goal", "contacts at fault", "unproven stops",
        "measured below proven by at most [mm]", "replanned on the way", "stopped", "median duration [s]",
    ]  # fmt: skip
    first = tallies["supervisor"]
    stages = table(
        ["stage", "times", "median [ms]", "median", "p99", "p99.9"],
        [[stage, *first.shares(stage)] for stage in STAGES],
    )
    still = 1e3 * float(np.median(first.plans))
    names = ", ".join(f"`{name}`" for name in PROBLEMS)
    return "\n".join(
        (
            f"Problems: {names}, the same seeds for both ways. A negative number of millimetres: the",
            "simulated robot kept farther away than was proven.",
            "",
            table(heads, [[way, *tally.row()] for way, tally in tallies.items()]),
            "",
            "CPU time of the supervisor's stages; the last three columns are shares of the median of a plan,",
            f"{still:.1f} ms:",
            "",
            stages,
        )
    )


def main(words: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=100, help="of each problem and way")
    parser.add_argument("--seed", type=int, default=0, help="the first one")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args(words)
    tallies = {way: Tally() for way in WAYS}
    for name in PROBLEMS:
        measured(name, range(asked.seed, asked.seed + asked.runs), tallies)
    text = page(tallies)
    print(text)
    if asked.json is not None:
        told = {way: [each.as_dict() for each in tally.runs] for way, tally in tallies.items()}
        asked.json.write_text(json.dumps(told))
    if asked.page is not None:
        write_section(asked.page, "execution", text)


if __name__ == "__main__":
    main()
