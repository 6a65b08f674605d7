"""Plan one problem with dynamic obstacles, of any part of the benchmark, and return its row."""

import os
import time
import traceback
from functools import cache
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

import trajopt as to
from benchmarks.moving.crossings import Crossing, crossings, instances
from benchmarks.moving.cubes import DENSITIES, LASTS, room
from benchmarks.moving.waiting import waited
from benchmarks.workers import Row
from trajopt.lab.suite import Instance

CROSSING, KNOWN, CUBES, BEST = PARTS = ("crossing", "known", "cubes", "best")
TIMES_OURS = 10.0
"""CPU time of the baseline among cubes, in multiples of ours."""
CRASHED = "CRASHED"
LATEST = 60.0
"""No motion of the baseline past a box that crosses takes longer [s]."""

_CONTEXT = get_context("fork")
_of_robot = cache(instances)
_boxes = cache(crossings)


def prepare(data: Path, robots: tuple[str, ...]) -> None:
    """Load the robots and plan a problem of each, so that late imports are not measured.

    Among all cubes shape and time are planned together, which not every problem needs.
    """
    to.plan(room(0).problem(max(DENSITIES)))
    for robot in robots:
        if robot == "xarm7":
            continue
        key = next(key for key in _boxes() if key.startswith(f"{robot}/"))
        problem, box = _asked(data, key)
        to.plan(problem)
        to.plan(box.add_to(problem))


def ask(data: Path, seconds: float, family: str, number: int) -> Row:
    """Ask a problem.

    Args:
        data: MotionBenchMaker's folder.
        seconds: CPU time of the baseline, where it does not depend on ours [s].
        family: The part, and the robot and the set or the number of cubes: "best/panda/box", "cubes/20".
        number: Of the problem.
    """
    row: Row = {"key": f"{family}-{number}", "family": family, "seed": number}
    part, _, rest = family.partition("/")
    try:
        match part:
            case "crossing":
                return row | {"outcome": "done"} | _crossing(data, f"{rest}/{number}")
            case "cubes":
                return row | {"outcome": "done"} | _cubes(int(rest), number)
            case _:
                problem, box = _asked(data, f"{rest}/{number}")
                return row | {"outcome": "done"} | _others(box.add_to(problem), part, seconds)
    except Exception as error:  # whatever it is, it costs this problem only, and its row counts as a crash
        return row | {"outcome": "crash", "detail": _words(error)}


def _words(error: Exception) -> str:
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({Path(last.filename).name}:{last.lineno})"


def _crossing(data: Path, key: str) -> Row:
    problem, box = _asked(data, key)
    still = _planned(problem)
    motion = still.pop("motion")
    ours = _planned(box.add_to(_asked(data, key)[0]))
    ours.pop("motion")
    wait = waited(box.add_to(problem), box, motion) if isinstance(motion, to.Trajectory) else None
    return {"still": still, "ours": ours, "wait": wait}


def _others(among: to.Problem, part: str, seconds: float) -> Row:
    """Ask the baseline: for ever shorter motions, or for any, first one that keeps all limits."""
    if part == BEST:
        return {"seconds": seconds, "rrt": _baseline(among, LATEST, seconds, improve=True)}
    resting = _baseline(among, LATEST, seconds, resting=True)
    plain = resting if resting["duration"] else _baseline(among, LATEST, seconds)
    return {"resting": resting, "rrt": plain}


def _cubes(density: int, number: int) -> Row:
    problem = room(number).problem(density)
    ours = _planned(problem)
    ours.pop("motion")
    seconds = TIMES_OURS * float(str(ours["cpu"]))
    plain = _baseline(problem, LASTS, seconds)
    if ours["verified"] or not plain["duration"]:
        return {"ours": ours, "rrt": plain}
    return {"ours": ours, "rrt": plain, "resting": _baseline(problem, LASTS, seconds, resting=True)}


def _asked(data: Path, key: str) -> tuple[to.Problem, Crossing]:
    """Return a static problem, read again, and its box."""
    found: dict[str, Instance] = _of_robot(data, key.partition("/")[0])
    return found[key].make(), _boxes()[key]


def _planned(problem: to.Problem) -> Row:
    """Plan a problem; CPU time is that of `plan()` alone, and the verdict that of a judge of its own."""
    begin = time.process_time()
    try:
        result = to.plan(problem)
    except Exception as error:  # a planner that raises, whatever it is, has no motion: counted as a crash
        used = time.process_time() - begin
        row: Row = {"cpu": used, "status": CRASHED, "verified": False, "motion": None, "duration": None}
        return row | {"said": _words(error)[:300], "stages": {}}
    used = time.process_time() - begin
    row = {"cpu": used, "status": result.status.name, "verified": result.verified, "motion": None}
    row["certainty"] = result.certainty.name
    row["stages"] = {name: round(seconds, 4) for name, seconds in result.cpu_seconds.items()}
    if not result.verified:
        return row | {"said": result.message[:300], "duration": None}
    motion = result.require().trajectory
    if not to.judge(result.problem, motion).verified:
        raise RuntimeError("the judge refuses what it proved")
    return row | {"said": "; ".join(result.remarks)[:300], "duration": motion.duration, "motion": motion}


def _baseline(
    problem: to.Problem, latest: float, seconds: float, *, improve: bool = False, resting: bool = False
) -> Row:
    """Run the baseline in its own process, since ompl does not free its memory."""
    mine, theirs = _CONTEXT.Pipe(duplex=False)
    process = _CONTEXT.Process(target=_search, args=(theirs, problem, latest, seconds, improve, resting))
    process.start()
    theirs.close()
    try:
        return mine.recv()
    except EOFError:
        process.join()
        raise RuntimeError(f"the baseline's process died, exit code {process.exitcode}") from None
    finally:
        process.join()
        mine.close()


def _search(
    pipe: Connection, problem: to.Problem, latest: float, seconds: float, improve: bool, resting: bool
) -> None:
    # Imported where it is needed: ompl is no dependency.
    from benchmarks.moving.space_time_rrt import SpaceTimeRrt

    found = SpaceTimeRrt(problem, latest, resting=resting).solve(seconds, improve=improve)
    duration = None if found.trajectory is None else found.trajectory.duration
    row: Row = {"duration": duration, "cpu": found.cpu, "first": found.first, "refused": found.refused}
    pipe.send(row | {"reasons": [reason[:120] for reason in found.reasons[:3]]})
    os._exit(0)  # nothing of ompl's is taken down
