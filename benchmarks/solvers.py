"""Every method on the suite and on the first Panda problems of each MotionBenchMaker set.

Runs of a method are kept in a file of its own below --runs, so that what was interrupted goes on where it
was; delete the files to measure anew.
"""

import argparse
import json
from pathlib import Path

import trajopt as to
from benchmarks.page import write_section
from trajopt.cli.suite import read_runs
from trajopt.lab.suite import Allowance, Instance, RunOutcome, compared, installed_instances
from trajopt.lab.suite.instance import find_instances
from trajopt.lab.suite.pages import comparison_page, markdown
from trajopt.optimise.methods import METHODS, method_named
from trajopt.values.documents.document import write_json, write_text
from trajopt.viewer.plots import comparison_figures

ALLOWANCE = Allowance(attempts=20, cpu_seconds=10.0)
"""What every method may use on every problem."""
LEFT_OUT = ("history", "tip", "message", "constraints", "counts", "stages")
"""What the committed results do not hold, for their size."""


def main() -> None:
    """Measure the methods that have no runs yet, and write tables, results and page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path, help="folder with panda/<set>/")
    parser.add_argument("--solver", action="append", help="method (repeatable); all that come with trajopt")
    parser.add_argument("--limit", type=int, default=5, help="problems of each set")
    parser.add_argument("--runs", type=Path, default=Path("out/solvers"))
    parser.add_argument("--json", type=Path, default=Path("benchmarks/results/solvers.json"))
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    instances: list[Instance] = []
    found: list[RunOutcome] = []
    for name in given.solver or METHODS:
        kept = given.runs / f"{name}.json"
        if not kept.is_file():
            if not instances:
                files = find_instances(given.data / "panda", to.load("panda"), limit=given.limit)
                instances = [*installed_instances(), *files]
            mine = list(compared(instances, [method_named(name)], ALLOWANCE))
            given.runs.mkdir(parents=True, exist_ok=True)
            write_json(kept, {"results": [run.as_dict() for run in mine]})
        found.extend(read_runs(kept))
        print(name, sum(run.good for run in found if run.solver == name), flush=True)
    plain = [{key: value for key, value in run.as_dict().items() if key not in LEFT_OUT} for run in found]
    given.json.write_text("[\n" + ",\n".join(json.dumps(run) for run in plain) + "\n]\n")
    write_text(given.runs / "solvers.html", comparison_page(found, comparison_figures(found)))
    if given.page is not None:
        write_section(given.page, "solvers", markdown(found))


if __name__ == "__main__":
    main()
