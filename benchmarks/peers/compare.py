"""Compare trajopt with other planners in one run on one core.

    python -m benchmarks.peers.compare --data path/to/motionbenchmaker/panda

Each planner runs in an environment of its own, made below `out/peers`, one process at a time. All of
them get the same problems, geometry and limits, and what they return is judged by trajopt's judge.
"""

import argparse
import os
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import trajopt as to
from benchmarks.page import write_section
from benchmarks.peers.environments import HERE, Peer, prepare, run, versions
from benchmarks.peers.export import Asked, read_asked, write_problems
from benchmarks.peers.judging import judge_result
from benchmarks.peers.report import REFERENCE, compact, section, summary, tables
from trajopt.lab.suite.instance import find_instances
from trajopt.values.documents.document import write_json

ROOT = HERE.parent.parent
PEERS = (
    Peer(
        REFERENCE,
        "trajopt",
        (),
        "the whole `plan`. The motion's CPU time includes the proof, which the others do not make; the path "
        "is the optimiser's, before its corners are rounded.",
    ),
    Peer(
        "roboplan RRT-Connect, step 0.02",
        "roboplan",
        ("roboplan.rrt", "roboplan.toppra"),
        "C++; largest connection 1.0 rad, edges tested every 0.02 rad, 100 rounds of shortcutting; timing by "
        "its own TOPP-RA with rounded corners (by 0.1, 0.03 and 0.01 rad; the shortest is kept), sampled "
        "every 5 ms.",
        "0.02",
    ),
    Peer(
        "roboplan RRT-Connect, step 0.05",
        "roboplan",
        ("roboplan.rrt", "roboplan.toppra"),
        "the same, tested every 0.05 rad (its default).",
        "0.05",
    ),
    Peer(
        "OMPL RRT-Connect, step 0.02",
        "ompl",
        ("ompl.geometric", "pinocchio", "toppra"),
        "`simplifySolution` to its end; a callback in Python into Pinocchio's broad phase and Coal; toppra "
        "at 600 points on a cubic spline, through denser points of the path where it would touch.",
        "0.02",
    ),
    Peer(
        "OMPL RRT-Connect, step 0.05",
        "ompl",
        ("ompl.geometric", "pinocchio", "toppra"),
        "the same, tested every 0.05 rad.",
        "0.05",
    ),
    Peer(
        "Drake KinematicTrajectoryOptimization",
        "drake",
        ("pydrake.planning",),
        "SNOPT from the straight line, cubic B-spline of 12 control points, 10 mm clearance at 100 samples, "
        "cost of duration and length; its own timing, bounded in velocity only.",
    ),
    Peer(
        "Drake, accelerations bounded",
        "drake",
        ("pydrake.planning",),
        "the same, with bounds on accelerations.",
        "acceleration",
    ),
    Peer(
        "Tesseract TrajOpt (sco)",
        "tesseract",
        ("tesseract_robotics.tesseract_motion_planners_trajopt", "toppra"),
        "21 points from the straight line, OSQP, continuous collision cost (margin 5 mm) and constraint "
        "(margin 0), as in its car seat example; toppra on a cubic spline as for OMPL.",
    ),
)


def main() -> None:
    """Read the options, run, judge, write."""
    options = _options()
    os.sched_setaffinity(0, {options.core})
    work = options.out.resolve()
    work.mkdir(parents=True, exist_ok=True)
    robot = to.load("panda")
    sets = [name for name in options.sets.split(",") if name]
    instances = find_instances(options.data, robot, sets, limit=options.limit)
    asked = read_asked(instances)
    kept = {item.instance.name for item in asked}
    problems = write_problems(work / "problems", asked, time_limit=options.time_limit)
    chosen = [peer for peer in PEERS if peer.label == REFERENCE or options.only in peer.label]
    judged: list[dict[str, Any]] = []
    records: list[list[dict[str, Any]]] = []
    for peer in chosen:
        python, unusable = prepare(peer, work / peer.worker)
        found = [] if unusable else _judged(peer, python, work, problems, asked, options.time_limit)
        records.append(found)
        judged.append(
            {
                "label": peer.label,
                "versions": versions(peer),
                "note": peer.note,
                "unusable": unusable,
                "summary": summary(found, records[0]) if found else None,
            }
        )
        print(tables(judged), flush=True)
    document = {
        "date": datetime.now(UTC).date().isoformat(),
        "problems": len(asked),
        "limit": options.limit,
        "sets": sorted({item.name.split("/")[0] for item in instances}),
        "left_out": [item.name.replace("/", " ") for item in instances if item.name not in kept],
        "time_limit": options.time_limit,
        "planners": judged,
    }
    options.results.mkdir(parents=True, exist_ok=True)
    write_json(options.results / "peers.json", document)
    lines = [compact(peer.label, line) for peer, some in zip(chosen, records, strict=True) for line in some]
    (options.results / "peers.jsonl").write_text("".join(line + "\n" for line in lines))
    if options.page is not None:
        write_section(options.page, "peers", section(document))


def _judged(
    peer: Peer, python: Path, work: Path, problems: Path, asked: Sequence[Asked], time_limit: float
) -> list[dict[str, Any]]:
    """Run one planner and judge its motions."""
    results = work / f"{peer.worker}{peer.variant}.jsonl"
    returned = run(peer, python, problems, results, time_limit=time_limit)
    return [judge_result(item, result) for item, result in zip(asked, returned, strict=True)]


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Compare trajopt with other planners.")
    parser.add_argument("--data", type=Path, required=True, help="folder with <set>/sceneNNNN.yaml")
    parser.add_argument("--sets", default="", help="names of sets, separated by commas; all if left out")
    parser.add_argument("--limit", type=int, default=10, help="problems of each set at most")
    parser.add_argument("--time-limit", type=float, default=20.0, help="for one problem [s]")
    parser.add_argument("--only", default="", help="only planners whose name contains this, and trajopt")
    parser.add_argument("--core", type=int, default=max(os.sched_getaffinity(0)), help="the core to run on")
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "peers", help="environments and raw results"
    )
    parser.add_argument("--results", type=Path, default=ROOT / "benchmarks" / "results", help="for the sums")
    parser.add_argument("--page", type=Path, help="the page whose section is made again")
    return parser.parse_args()


main()
