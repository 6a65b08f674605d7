"""Cost of pose goals against joint goals on the same problems.

python -m benchmarks.pose_goals DATA [--each 50] [--json FILE] [--page FILE]

Each joint goal of MotionBenchMaker's Panda sets is planned as it stands, and as the placement that the
hand's frame has there. Both start from files read anew, so that no scene has been planned in before.
"""

import argparse
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.lab.suite import Instance, RunOutcome, run
from trajopt.lab.suite.instance import find_instances
from trajopt.optimise.transcription import fixed_goal

FRAME = "panda_hand"


@dataclass(frozen=True)
class Pair:
    """One problem both ways."""

    joints: RunOutcome
    pose: RunOutcome


def with_pose_goal(problem: to.Problem) -> to.Problem:
    goal = fixed_goal(problem)
    if goal is None:
        raise SystemExit(f"{problem.name}: the goal does not fix all joints")
    where = problem.scene.placement_of(FRAME, problem.reduced.all_positions(goal))
    return replace(problem, goal=to.frame_placement(FRAME, where))


def compare(instance: Instance) -> Pair | None:
    """Plan both; None if the joint goal is unreachable."""
    joints = run(instance)
    if not joints.askable:
        return None
    # Placing the hand is reading the problem; the scene it is planned in is read again after it.
    goal = with_pose_goal(instance.make()).goal
    return Pair(joints, run(replace(instance, make=lambda: replace(instance.make(), goal=goal))))


COLUMNS = (
    ("problems", "problems", 1, "d"),
    ("verified, joints", "verified_joints", 1, "d"),
    ("verified, pose", "verified_pose", 1, "d"),
    ("CPU ms, joints", "cpu_joints", 1e3, ".1f"),
    ("CPU ms, pose", "cpu_pose", 1e3, ".1f"),
    ("ratio", "cpu_ratio", 1, ".2f"),
    ("goal search ms", "goal_search", 1e3, ".1f"),
    ("first guesses, joints", "attempts_joints", 1, ".2f"),
    ("first guesses, pose", "attempts_pose", 1, ".2f"),
    ("motion s, joints", "duration_joints", 1, ".2f"),
    ("motion s, pose", "duration_pose", 1, ".2f"),
)
"""Heading, entry of the summary, factor and format of each."""


def sums(pairs: Sequence[Pair]) -> str:
    """Return the table: a row for each set and one for all."""
    rows: list[list[str]] = []
    for name in [*dict.fromkeys(pair.joints.set_name for pair in pairs), "all"]:
        row = summary([pair for pair in pairs if name in (pair.joints.set_name, "all")])
        rows.append([name, *(format(row[entry] * factor, style) for _, entry, factor, style in COLUMNS)])
    return table(["set", *(heading for heading, *_ in COLUMNS)], rows)


def summary(pairs: Sequence[Pair]) -> dict[str, float]:
    """Counts of verified motions, medians of times [s], means of first guesses tried."""
    solved = [pair for pair in pairs if pair.joints.verified and pair.pose.verified]

    def middle(of: Callable[[Pair], float | None], some: Sequence[Pair]) -> float:
        return float(np.median([cast(float, of(pair)) for pair in some])) if some else float("nan")

    return {
        "problems": len(pairs),
        "verified_joints": sum(pair.joints.verified for pair in pairs),
        "verified_pose": sum(pair.pose.verified for pair in pairs),
        "cpu_joints": middle(lambda pair: pair.joints.cpu_seconds, pairs),
        "cpu_pose": middle(lambda pair: pair.pose.cpu_seconds, pairs),
        "cpu_ratio": middle(lambda pair: pair.pose.cpu_seconds, pairs)
        / middle(lambda pair: pair.joints.cpu_seconds, pairs),
        "goal_search": middle(lambda pair: pair.pose.stages.get("seed", 0.0), pairs),
        "attempts_joints": float(np.mean([pair.joints.attempts for pair in pairs])),
        "attempts_pose": float(np.mean([pair.pose.attempts for pair in pairs])),
        "duration_joints": middle(lambda pair: pair.joints.duration, solved),
        "duration_pose": middle(lambda pair: pair.pose.duration, solved),
    }


def as_dict(pair: Pair) -> dict[str, object]:
    """Return a problem's row of the committed results."""
    name, number = pair.joints.problem.split("/")
    return {
        "set": name,
        "index": int(number),
        **{
            way: {
                "status": told.status.name,
                "cpu_seconds": told.cpu_seconds,
                "seed_seconds": told.stages.get("seed", 0.0),
                "attempts": told.attempts,
                "duration": told.duration,
            }
            for way, told in (("joints", pair.joints), ("pose", pair.pose))
        },
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path, metavar="DATA", help="folder with panda/<set>/sceneNNNN.yaml")
    parser.add_argument("--each", type=int, default=50, help="problems of each set")
    parser.add_argument("--json", type=Path, default=Path("benchmarks/results/pose_goals.json"))
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    instances = find_instances(given.data / "panda", to.load("panda"), limit=given.each)
    compare(instances[0])  # imports what is imported late
    pairs = [pair for pair in map(compare, instances) if pair is not None]
    text = sums(pairs)
    print(text)
    for pair in pairs:
        if not pair.pose.verified:
            print(f"  {pair.joints.problem}: {pair.joints.status.name}, pose {pair.pose.status.name}")
    given.json.parent.mkdir(parents=True, exist_ok=True)
    lines = ",\n".join(json.dumps(as_dict(pair)) for pair in pairs)
    given.json.write_text(f'{{"summary": {json.dumps(summary(pairs))},\n"problems": [\n{lines}\n]}}\n')
    if given.page is not None:
        write_section(given.page, "pose_goals", text)


if __name__ == "__main__":
    main()
