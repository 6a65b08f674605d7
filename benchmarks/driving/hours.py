"""Hours of random work of one simulated robot, as fast as the machine goes, and the memory that it takes.

python -m benchmarks.driving.hours [--hours 8] [--every 600] [--seed 0] [--rows FILE] [--page FILE]

One supervisor drives an arm to one goal after the other: the problem's own goal, its start, and places up to
0.3 rad around both, drawn until they are clear. On two of three ways a box appears where the tip would be
half way, whatever is there then, is seen 20 ms later, and gone after 3 s. On one of ten the robot is stopped
on the way. From a fault, as when a box appears in the robot, it recovers once the box is gone. Memory is that
of the process after garbage was collected, each so many simulated seconds.
"""

import argparse
import gc
import json
import os
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.driving import EventKind, SimulatedExecutor, Supervisor
from trajopt.problem.stated import GoalLike
from trajopt.scene.group_tools import ends_of
from trajopt.values.arrays import Floats
from trajopt.verify import Judge

PROBLEM = "bookshelf_ur5"
CYCLE = 0.02
AROUND = 0.3
"""How far a joint's goal is from the start or the goal of the problem at most [rad]."""
STAYS, SEEN = 3.0, 0.02
"""How long a box is there, and how much later it is seen [s]."""
PATIENCE = 10.0
"""A goal that is not reached by then is given up [s]."""


def memory() -> float:
    """Return the memory of this process after garbage was collected [MB]."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


class Work:
    """A robot that works on."""

    def __init__(self, seed: int) -> None:
        """Begin where the problem does."""
        self.problem, self._rng = to.named_problem(PROBLEM), np.random.default_rng(seed)
        self.arm = SimulatedExecutor(self.problem.scene, self.problem.start_positions)
        self.supervisor = Supervisor(self.arm, self.problem)
        motion = to.plan(self.problem).require().trajectory
        self._ends = (motion(0.0), motion(motion.duration))
        self.counts = dict.fromkeys(("goals", "reached", "stops", "boxes", "recoveries"), 0)

    def go_on(self) -> None:
        """Go to another goal."""
        problem, rng, scene = self.problem, self._rng, self.problem.scene
        here = self.arm.state().commanded[
            [self.arm.joint_names.index(n) for n in problem.reduced.joint_names]
        ]
        goal = self._drawn()
        asked, noted = replace(problem, goal=self._goal(goal)), len(self.supervisor.events)
        self.supervisor.go(asked)
        self.counts["goals"] += 1
        begun, box = self.arm.now(), float(rng.uniform(0.1, 0.6)) if rng.uniform() < 2.0 / 3.0 else np.inf
        stop = float(rng.uniform(0.1, 0.8)) if rng.uniform() < 0.1 else np.inf
        changes = [(begun + box, self._with_box((here + goal) / 2.0)), (begun + box + STAYS, scene)]
        changes = [change for change in changes if np.isfinite(change[0])]
        self.counts["boxes"] += bool(changes)
        told = list(changes)
        while (told or self._busy) and self.arm.now() < begun + PATIENCE:
            now = self.arm.now()
            if changes and now >= changes[0][0]:
                self.arm.change(changes.pop(0)[1], begin=now)
            if told and now >= told[0][0] + SEEN:
                self.supervisor.see(told.pop(0)[1])
            if now >= begun + stop:
                self.supervisor.stop()
                self.counts["stops"] += 1
                stop = np.inf
            self.supervisor.cycle()
            self.arm.advance(CYCLE)
        since = [event.kind for event in self.supervisor.events[noted:]]
        self.counts["reached"] += EventKind.REACHED in since
        if self.arm.fault():
            self._recover()

    def _recover(self) -> None:
        """Bring the robot back from a fault."""
        self.counts["recoveries"] += self.supervisor.recover(self._goal(self._ends[0]), scaling=0.5)
        while self.supervisor.busy:
            self.supervisor.cycle()
            self.arm.advance(CYCLE)

    def _goal(self, positions: Floats) -> GoalLike:
        return to.joint_positions(
            dict(zip(self.problem.reduced.joint_names, positions.tolist(), strict=True))
        )

    @property
    def _busy(self) -> bool:
        return self.supervisor.busy and not self.supervisor.blocked

    def _drawn(self) -> Floats:
        judge = Judge(self.problem.reduced)
        while True:
            near = self._ends[int(self._rng.integers(2))]
            goal = near + self._rng.uniform(-AROUND, AROUND, len(near)) * self._rng.integers(2)
            if judge.examine(goal).clear:
                return goal

    def _with_box(self, at: Floats) -> to.Scene:
        problem = self.problem
        tip = ends_of(problem.scene, problem.group)[0]
        where = problem.scene.placement_of(tip, problem.reduced.all_positions(at))
        edge = float(self._rng.uniform(0.04, 0.08))
        return problem.scene.add("box", to.Box(edge, edge, edge), to.placement(where.translation))


def main(words: Sequence[str] | None = None) -> None:
    """Work, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--hours", type=float, default=8.0, help="of simulated time")
    parser.add_argument("--every", type=float, default=600.0, help="simulated seconds from row to row")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rows", type=Path, default=Path("out/driving/hours.jsonl"))
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    asked = parser.parse_args(words)
    work, rows, due = Work(asked.seed), list[dict[str, float]](), 0.0
    asked.rows.parent.mkdir(parents=True, exist_ok=True)
    asked.rows.write_text("")
    end = 3600.0 * asked.hours
    while True:
        if work.arm.now() >= min(due, end):
            row = {
                "simulated": work.arm.now(),
                "megabytes": memory(),
                "cpu": time.process_time(),
                **work.counts,
            }
            rows.append(row)
            with asked.rows.open("a") as file:
                file.write(json.dumps(row) + "\n")
            due += asked.every
        if work.arm.now() >= end:
            break
        work.go_on()
    text = table(list(rows[0]), [[f"{value:.0f}" for value in row.values()] for row in rows])
    print(text)
    if asked.page is not None:
        write_section(asked.page, "driving-hours", text)


if __name__ == "__main__":
    main()
