"""One problem in all its forms: with primitives, as a cloud as it is drawn, and as a thinned one."""

from functools import cache
from pathlib import Path
from time import process_time

import numpy as np

import trajopt as to
from benchmarks.clouds.checker import Checker
from benchmarks.clouds.parity import parity
from benchmarks.clouds.rrt import rrt_connect
from benchmarks.clouds.sampling import RAW, THIN, clouds_of, with_cloud
from benchmarks.motion_bench_maker import listed
from benchmarks.workers import Row
from trajopt.lab.suite import Instance
from trajopt.lab.suite.instance import find_instances
from trajopt.problem.requirements import JointPositions
from trajopt.values.arrays import one_of

PLAIN, PARITY = "primitives", "parity"


@cache
def problems(data: Path) -> dict[str, Instance]:
    """Return the Panda's problems by name."""
    return {item.name: item for item in find_instances(data / "panda", to.load("panda"))}


def prepare(data: Path) -> None:
    """Plan one problem in all forms, so that late imports are not measured."""
    family, number = listed(data / "panda", 1)[0]
    ask(data, family, number)


def ask(data: Path, family: str, number: int) -> Row:
    """Plan one problem in all forms and return the outcomes."""
    row: Row = {"key": f"{family}-{number}", "family": family, "seed": number, "outcome": "asked"}
    if family == PARITY:
        return row | parity(number)
    words = family.removeprefix("panda/").split()
    plain = problems(data)[f"{words[0]}/{number}"].make()
    clouds = clouds_of(plain.scene)
    row |= {PLAIN: planned(plain)}
    for name, cloud in ((RAW, clouds.raw), (THIN, clouds.thin)):
        problem = with_cloud(plain, cloud)
        checker = Checker(problem.reduced, cloud)
        goal = goal_of(problem)
        free = checker.free(problem.reduced.start_positions) and checker.free(goal)
        row |= {name: planned(problem) | {"free": free, "points": len(cloud)}}
        if free and name == THIN and words[1:]:
            row |= {"ompl": rrt_connect(problem, checker, goal, seed=number)}
    return row


def goal_of(problem: to.Problem) -> np.ndarray:
    """Return the goal's configuration of the group."""
    stated = one_of("goal", problem.goals[0], JointPositions).positions
    return np.array([stated[name] for name in problem.reduced.joint_names])


def planned(problem: to.Problem) -> Row:
    """Plan a problem in a newly built scene, trees included, and return the outcome."""
    begin = process_time()
    result = to.plan(problem)
    seconds = process_time() - begin
    return {
        "status": result.status.name,
        "cpu": round(seconds, 4),
        "parts": {name: round(value, 4) for name, value in result.cpu_seconds.items()},
        "judged": result.status is to.Status.SOLVED
        and to.judge(problem, result.require().trajectory).verified,
    }
