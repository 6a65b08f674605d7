"""MotionBenchMaker, the Panda and a UR5 with gripper: success, CPU time by stage, exact counts.

python -m benchmarks.motion_bench_maker DATA [--results FOLDER] [--page FILE]

DATA holds panda/<set>/ and ur5/<set>/ (scenes and requests in MoveIt's YAML), and ur5/robot/.
"""

import argparse
import json
from pathlib import Path

import trajopt as to
from benchmarks.page import write_section
from trajopt.benchmark.folders import by_set, find_instances, run, summary
from trajopt.cli.bench import stage_table, table, winners
from trajopt.moveit.trajectory_files import write_json


def main() -> None:
    """Plan all problems of both robots and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--results", type=Path, default=Path("benchmarks/results"))
    parser.add_argument("--page", type=Path, help="Markdown file with the sections' markers")
    parser.add_argument("--limit", type=int, help="problems of each set at most")
    given = parser.parse_args()
    folder = given.data / "ur5" / "robot"
    robots = {
        "panda": to.load("panda"),
        "ur5": to.Robot.from_urdf(folder / "ur5.urdf", srdf=folder / "ur5.srdf"),
    }
    for name, robot in robots.items():
        records = list(run(robot, find_instances(given.data / name, limit=given.limit)))
        total = summary(records)
        sets = by_set(records)
        lines = [{k: v for k, v in record.as_dict().items() if k != "cpu_seconds"} for record in records]
        write_json(given.results / f"{name}.json", {"summary": total, "sets": sets, "problems": lines})
        causes = "\n".join(f"- {count} x {cause}" for cause, count in total["causes"].items())
        won = f"Won by {winners(total)}."
        text = "\n\n".join((table({**sets, "all": total}), stage_table(total), won, causes or "All solved."))
        print(f"{name}\n\n{text}\n{json.dumps(total['statuses'])}\n", flush=True)
        if given.page is not None:
            write_section(given.page, name, text)


if __name__ == "__main__":
    main()
