"""Robots driven in simulation while boxes appear in their way, by the rule of `random_surprise`.

python -m benchmarks.execution [--runs 100] [--seed 0] [--json FILE] [--page FILE]
python -m benchmarks.execution --scenarios [--page FILE]

Each problem is planned, and driven with as many seeds as are asked for: once by the supervisor as it is,
and once by one that plans only once the robot stands. Every run is measured by the simulation, and judged.
Contacts at fault are those that are met while the robot moves. A servo is led by random twists among twenty
boxes as well. Times of stages are CPU time of the thread, beside the median of a plan of the same problems,
in the same process, from rest and in a world that stands still.
"""

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.execution_scenarios import scenarios_page
from benchmarks.page import table, write_section
from trajopt.driving import (
    EventKind,
    IdealExecutor,
    RunReport,
    Servo,
    ServoOptions,
    SimulatedExecutor,
    Supervisor,
    SupervisorOptions,
    Twist,
    random_surprise,
    run,
    undisturbed,
)

PROBLEMS = ("cup_past_pillar", "bookshelf_panda", "bookshelf_ur5", "past_pillar_ur5", "past_pillar_xarm7")
PLANS = 15
WAYS = {"supervisor": SupervisorOptions(), "plans from rest only": SupervisorOptions(on_the_way=False)}
ANSWERED = "surprise to proven command"
SPLICED = "surprise to splice"
STAGES = ("cycle", "prove", "re-check", "stop", "retime", "plan", ANSWERED, SPLICED, "servo tick")
AFTERWARDS = ("plan", "plan ahead", "retime", "prove")
"""Stages of a cycle after the committed motion is proven again, or a stop is committed."""
FIRST = 0.035
"""Median of a plan before anything of this was built, which its aims are shares of [s]."""
LED = ("panda", "ur5")
BOXES, TICKS, PERIOD = 20, 1000, 0.01


@dataclass
class Tally:
    """What became of the runs of one way."""

    runs: list[RunReport] = field(default_factory=list[RunReport])
    plans: list[float] = field(default_factory=list[float])
    others: dict[str, list[float]] = field(default_factory=dict[str, list[float]])

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
            str(sum(each.count(EventKind.UNPROVEN_STOP) > 0 for each in self.runs)),
            f"{max(below):.2f}",
            str(sum(each.count(EventKind.REPLANNED) > 0 for each in self.runs)),
            str(sum(each.count(EventKind.STOPPING) > 0 for each in self.runs)),
            f"{np.median([each.duration for each in self.runs]):.2f}",
        ]

    def a_cycle(self, stage: str) -> float:
        """CPU time of a stage, spread over all cycles [s]."""
        spent = sum(sum(each.seconds.get(stage, ())) for each in self.runs)
        return spent / sum(len(each.seconds["cycle"]) for each in self.runs)

    def shares(self, stage: str) -> list[str]:
        """Median, 99 and 99.9 percent of a stage's CPU time, and as shares of plans."""
        driven = [second for each in self.runs for second in each.seconds.get(stage, ())]
        times = np.array(driven + self.others.get(stage, []))
        if not len(times):
            return ["-"] * 8
        found = np.percentile(times, (50.0, 99.0, 99.9))
        parts = [f"{each / still:.3f}" for still in (np.median(self.plans), FIRST) for each in found[[0, 2]]]
        return [str(len(times)), *(f"{1e3 * each:.2f}" for each in found), *parts]


class Reactions:
    """CPU time from a surprise to the next command, and of all cycles to the next motion."""

    def __init__(self, others: dict[str, list[float]]) -> None:
        """Take where to write it."""
        self._answered, self._spliced = (others.setdefault(name, []) for name in (ANSWERED, SPLICED))
        self._looked, self._spent, self._end, self._after = 0, -1.0, -np.inf, 0.0

    def look(self, supervisor: Supervisor) -> None:
        """Look at a supervisor after a cycle."""
        arm, seconds = supervisor.executor, supervisor.seconds
        assert isinstance(arm, SimulatedExecutor)
        fresh, self._looked = supervisor.events[self._looked :], len(supervisor.events)
        cycle, before = seconds["cycle"][-1], self._after
        self._after = sum(sum(seconds.get(stage, ())) for stage in AFTERWARDS)
        if any(event.kind is EventKind.WORLD_CHANGED for event in fresh) and arm.now() > 0.0:
            self._spent = 0.0
            self._answered.append(cycle - (self._after - before))
        if self._spent >= 0.0:
            self._spent += cycle
            if arm.committed.end != self._end:
                self._spliced.append(self._spent)
                self._spent = -1.0
        self._end = arm.committed.end


def crowded(robot: str, rng: np.random.Generator) -> to.Problem:
    """Return a robot among boxes of 10 cm, none of them nearer than 5 cm to it where it starts."""
    loaded = to.load(robot)
    scene, group = to.Scene(loaded), {"panda": "panda_arm", "ur5": "manipulator"}[robot]
    state = {"panda": "ready", "ur5": "up"}[robot]
    while len(scene.objects) < BOXES:
        angle, away, height = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 0.8), rng.uniform(0.0, 0.9)
        where = to.placement((away * np.cos(angle), away * np.sin(angle), height))
        wide = to.Problem(
            scene=scene.add("wide", to.Box(0.2, 0.2, 0.2), where), group=group, start=state, goal=state
        )
        if to.examine(wide.reduced, wide.reduced.start_positions).clear:
            scene = scene.add(f"box {len(scene.objects)}", to.Box(0.1, 0.1, 0.1), where)
    return to.Problem(scene=scene, group=group, start=state, goal=state)


def ticks(robot: str, seed: int) -> list[float]:
    """Lead a robot among boxes by random twists, a new one every 0.2 s; CPU time of each tick [s]."""
    rng = np.random.default_rng(seed)
    problem = crowded(robot, rng)
    arm = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    servo, command = Servo(arm, problem, ServoOptions(period=PERIOD)), Twist()
    for number in range(TICKS):
        if number % 20 == 0:
            command = Twist(rng.uniform(-0.4, 0.4, 3), rng.uniform(-1.0, 1.0, 3))
        servo.command(command)
        servo.tick()
        arm.advance(PERIOD)
    return servo.seconds


def measured(name: str, seeds: range, tallies: dict[str, Tally]) -> None:
    """Drive one problem, with each way in turn."""
    problem = to.named_problem(name)
    motion = undisturbed(problem)
    for _ in range(PLANS):
        begin = time.thread_time()
        to.plan(problem)
        took = time.thread_time() - begin
        for tally in tallies.values():
            tally.plans.append(took)
    for seed in seeds:
        surprises = random_surprise(problem, motion, seed)
        for way, options in WAYS.items():
            found = Reactions(tallies[way].others)
            tallies[way].runs.append(run(problem, surprises=surprises, options=options, watch=found.look))


def page(tallies: dict[str, Tally]) -> str:
    """Return the section of the page."""
    heads = [
        "", "runs", "reached the goal", "contacts at fault", "unproven stops",
        "measured below proven by at most [mm]", "replanned on the way", "stopped", "median duration [s]",
    ]  # fmt: skip
    first = tallies["supervisor"]
    heads_of_stages = [
        "stage", "times", "median [ms]", "p99 [ms]", "p99.9 [ms]",
        "median of a plan", "p99.9 of a plan", "median of 35 ms", "p99.9 of 35 ms",
    ]  # fmt: skip
    stages = table(heads_of_stages, [[stage, *first.shares(stage)] for stage in STAGES])
    still, proofs = 1e3 * float(np.median(first.plans)), 1e3 * first.a_cycle("prove")
    names = ", ".join(f"`{name}`" for name in PROBLEMS)
    return "\n".join(
        (
            f"Problems: {names}; equal seeds for both rows.",
            "A negative distance: the robot kept farther away than was proven; both are bounds within 1 mm.",
            "",
            table(heads, [[way, *tally.row()] for way, tally in tallies.items()]),
            "",
            "CPU time of the thread in each stage, also relative to a plan from rest:",
            f"{still:.1f} ms (this run), {1e3 * FIRST:.0f} ms (an older version).",
            f"*prove*: find, prove and commit a piece and its stop ({proofs:.2f} ms over all cycles).",
            "*re-check*: after a change of the scene, until the committed motion is proven again or a stop",
            f"is committed. *{ANSWERED}*: the cycle in which a box appears, without planning.",
            f"*{SPLICED}*: until the next motion is committed, planning included.",
            f"*servo tick*: among {BOXES} boxes, {' and '.join(LED)}.",
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
    parser.add_argument("--scenarios", action="store_true", help="one run of each scenario")
    asked = parser.parse_args(words)
    if asked.scenarios:
        text = scenarios_page()
        print(text)
        if asked.page is not None:
            write_section(asked.page, "scenarios", text)
        return
    tallies = {way: Tally() for way in WAYS}
    for name in PROBLEMS:
        measured(name, range(asked.seed, asked.seed + asked.runs), tallies)
    tallies["supervisor"].others["servo tick"] = [each for robot in LED for each in ticks(robot, asked.seed)]
    text = page(tallies)
    print(text)
    if asked.json is not None:
        told = {way: [each.as_dict() for each in tally.runs] for way, tally in tallies.items()}
        asked.json.write_text(json.dumps(told))
    if asked.page is not None:
        write_section(asked.page, "execution", text)


if __name__ == "__main__":
    main()
