"""Unproven stops in worlds that change in each cycle: whether a search finds a proven stop.

python -m benchmarks.unproven_stops [--runs 40] [--seed 0] [--candidates 2000] [--json FILE] [--page FILE]

In each cycle a box jumps to a random place near the robot's motion of the next half second. At each stop that
the supervisor cannot prove, the configuration where a stop can begin is examined. If it is too near to
something at that time, each stop is, since all begin there: no proven stop exists. Otherwise stops are
searched: all combinations of largest accelerations of the joints, held for several times, and random ones,
each followed by the soonest stop. The second row of each problem is the same without stops that turn away:
it shows that the search finds stops if there are some.
"""

import argparse
import json
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from itertools import islice, product
from pathlib import Path
from unittest import mock

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.driving import IdealExecutor, Supervisor, commit_loop, soonest_stop
from trajopt.driving.motion_guard import MotionGuard
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.optimise.methods.timing import with_jerk
from trajopt.robot.joints import JointLimits
from trajopt.scene.reducing import reduce_model, tool_frame
from trajopt.timing.time_scaling import stop_after
from trajopt.values.arrays import Floats
from trajopt.verify import Judge

PROBLEMS = ("past_pillar_xarm7", "past_pillar_ur5", "bookshelf_panda", "cup_past_pillar")
CYCLE, LONGEST = 0.02, 2.0
"""Of a cycle and of a run [s]."""
SIZE, AHEAD, AWAY = 0.08, 0.5, 0.25
"""Edge of the box [m], how far ahead of the robot it appears [s], and how far from the tool's way [m]."""
TOLERANCE = 1e-4
"""How far each joint may be off where it has to be [rad]."""
PUSHES = (0.02, 0.04, 0.06, 0.1, 0.15, 0.2)
"""How long largest accelerations are held [s]."""


@dataclass
class Tally:
    """Stops of one problem.

    Attributes:
        runs: Runs.
        unproven: Stops that the supervisor could not prove.
        too_near: Of these, those that begin too near to something.
        searched: The others.
        found: Of those, how many have a proven stop among the candidates.
        candidates: How many candidates were examined for all of them.
    """

    runs: int = 0
    unproven: int = 0
    too_near: int = 0
    searched: int = 0
    found: int = 0
    candidates: int = 0


@dataclass
class Examined:
    """Examines each unproven stop, in place of `why_unproven`.

    Attributes:
        tally: Its counts.
        most: Candidates for each stop.
        rng: Draws candidates.
    """

    tally: Tally
    most: int
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def __call__(self, guard: MotionGuard, world: WorldSnapshot, begin: float, stop: to.Trajectory) -> str:
        """Count a stop."""
        self.tally.unproven += 1
        if not clear_when_it_begins(guard, world, begin, stop):
            self.tally.too_near += 1
            return "too near"
        self.tally.searched += 1
        state = np.stack([stop(0.0, order) for order in range(3)])
        tried = islice(candidates(state, with_jerk(guard.problem.limits), self.rng), self.most)
        for number, each in enumerate(tried, start=1):
            if guard.proven(each, world, begin, requirements=False):
                self.tally.candidates += number
                self.tally.found += 1
                return "a proven stop exists"
        self.tally.candidates += self.most
        return "none found"


def clear_when_it_begins(guard: MotionGuard, world: WorldSnapshot, begin: float, stop: to.Trajectory) -> bool:
    """Say whether the configuration where a stop begins keeps all required distances at that time."""
    problem, here = guard.problem, stop(0.0)
    scene = world.at(begin).still_at(0.0)
    reduced = reduce_model(scene, problem.group, problem.start_positions)
    return Judge(reduced, guard.options).examine(here).clear


def candidates(state: Floats, limits: JointLimits, rng: np.random.Generator) -> Iterator[to.Trajectory]:
    """Yield stops from a state (3, n): largest accelerations of all signs first, then random ones."""
    joints = state.shape[1]
    for push in PUSHES:
        for signs in product((-1.0, 1.0), repeat=min(joints, 7)):
            yield from pushed(state, np.resize(signs, joints), push, limits)
    while True:
        yield from pushed(state, rng.uniform(-1.0, 1.0, joints), float(rng.uniform(0.01, 0.3)), limits)


def pushed(state: Floats, shares: Floats, push: float, limits: JointLimits) -> Iterator[to.Trajectory]:
    """Yield a motion that goes over to accelerations within a time, then stops; none if it gets too fast."""
    position, velocity, acceleration = state
    jerk = np.clip((shares * limits.acceleration - acceleration) / push, -limits.jerk, limits.jerk)
    end = np.stack(
        (
            position + push * (velocity + push * (acceleration / 2.0 + push * jerk / 6.0)),
            velocity + push * (acceleration + push * jerk / 2.0),
            acceleration + push * jerk,
        )
    )
    if (np.abs(end[1]) <= limits.velocity).all():
        yield stop_after(state, end, push, limits)


def drive(problem: to.Problem, seed: int) -> None:
    """Drive towards the goal while a box jumps about."""
    rng, robot, tool = np.random.default_rng(seed), problem.scene.robot, tool_frame(problem.reduced)
    arm = IdealExecutor(robot.joint_names, problem.start_positions)
    arm.tolerance[:] = TOLERANCE
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    while supervisor.busy and arm.now() < LONGEST:
        supervisor.cycle()
        arm.advance(CYCLE)
        ahead = np.array(problem.start_positions)
        ahead[robot.index(arm.joint_names)] = supervisor.committed(arm.now() + rng.uniform(0.0, AHEAD))[0]
        place = problem.scene.placement_of(tool, ahead).translation + rng.uniform(-AWAY, AWAY, 3)
        supervisor.see(problem.scene.add("jumping", to.Box(SIZE, SIZE, SIZE), to.placement(tuple(place))))


def tallied(name: str, seeds: range, most: int, *, evading: bool) -> Tally:
    """Return the counts of a problem's runs, with or without stops that turn away."""
    tally = Tally()
    with ExitStack() as patched:
        patched.enter_context(mock.patch.object(commit_loop, "why_unproven", Examined(tally, most)))
        if not evading:
            patched.enter_context(mock.patch.object(soonest_stop, "evading_stops", lambda *_: iter(())))
        for seed in seeds:
            drive(to.named_problem(name), seed)
            tally.runs += 1
    return tally


def section(tallies: dict[str, Tally], most: int) -> str:
    """Return the table."""
    head = (
        "", "runs", "unproven stops", "too near where a stop can begin", "searched",
        f"with a proven stop among {most}",
    )  # fmt: skip
    rows = [
        (name, *map(str, (each.runs, each.unproven, each.too_near, each.searched, each.found)))
        for name, each in tallies.items()
    ]
    return table(head, rows)


def main() -> None:
    """Count unproven stops, and print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=40, help="of each problem")
    parser.add_argument("--seed", type=int, default=0, help="of the first run")
    parser.add_argument("--candidates", type=int, default=2000, help="stops that are tried for each")
    parser.add_argument("--problems", default=",".join(PROBLEMS), help="their names")
    parser.add_argument("--json", type=Path, help="write the counts to this file")
    parser.add_argument("--page", type=Path, help="write the table into this page")
    given = parser.parse_args()
    tallies: dict[str, Tally] = {}
    for name in given.problems.split(","):
        for evading, label in ((True, name), (False, f"{name}, without stops that turn away")):
            seeds = range(given.seed, given.seed + given.runs)
            tallies[label] = tallied(name, seeds, given.candidates, evading=evading)
            print(label, tallies[label], flush=True)
    written = section(tallies, given.candidates)
    print(written)
    if given.json is not None:
        counts = {name: asdict(each) for name, each in tallies.items()}
        given.json.write_text(json.dumps(counts, indent=1) + "\n")
    if given.page is not None:
        write_section(given.page, "unproven", written)


if __name__ == "__main__":
    main()
