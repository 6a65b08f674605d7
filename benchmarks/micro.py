"""Cost of single pieces: a linearisation, a QP, a retiming, a verification.

python -m benchmarks.micro [--json FILE] [--page FILE]
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from benchmarks.problems import past_pillar
from tests.oracles.query import PlainQuery
from trajopt.geometry import Query
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.solvers.sqp import step_solver
from trajopt.optimise.transcription import fixed_goal, transcribe
from trajopt.planning.seeds import straight_line
from trajopt.problem.motion import Motion
from trajopt.timing import retime
from trajopt.verify import Judge, Specification


def least(work: Callable[[], object], runs: int = 40) -> float:
    """Return the least CPU time of a piece of work [us], after one run that is not counted."""
    work()
    times: list[float] = []
    for _ in range(runs):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return 1e6 * min(times)


def pieces(problem: to.Problem) -> dict[str, float]:
    """Return the CPU time of each piece on one problem [us]."""
    reduced = problem.reduced
    goal = fixed_goal(problem)
    assert goal is not None
    line = straight_line(reduced.start_positions, goal, problem.knots)
    nlp = transcribe(problem, line)
    plan = to.plan(problem).require()
    coarse, fine = (nlp.sampling(plan.path.knots, fine=value) for value in (False, True))
    motion = Motion.through(plan.path.knots, fine, nlp.query)
    reach = reduced.pairs.margin + 0.03
    at = nlp.linearise(line, coarse)
    moves = nlp.lower < nlp.upper
    box = np.where(moves, 0.5, 0.0)
    torque = DynamicsQuery(reduced).torque
    asked = Specification(goals=problem.goals, limits=problem.limits)

    def near(query_class: Callable[..., object]) -> Callable[[], object]:
        return lambda: query_class(reduced).close_pairs(motion.positions, reach)  # pyright: ignore

    def qp(name: str) -> Callable[[], object]:
        return lambda: step_solver(name).program(moves, at, 5.0).solve(-box, box, 1e-3)

    return {
        f"near pairs of {len(motion.positions)} samples, empty cache": least(near(Query)),
        "the same, second call": least(lambda: nlp.query.close_pairs(motion.positions, reach)),
        "the same, plain Python": least(near(PlainQuery), runs=3),
        f"linearisation, {len(at.constraints[0].lower)} rows": least(lambda: nlp.linearise(line, coarse)),
        "QP, banded": least(qp("banded")),
        "QP, PIQP": least(qp("piqp")),
        "QP, OSQP": least(qp("osqp"), runs=5),
        "retiming": least(lambda: retime(plan.path, problem.limits, inverse_dynamics=torque)),
        "verification": least(lambda: Judge(reduced).certify(plan.trajectory, asked)),
        "plan(), all": least(lambda: to.plan(problem)),
    }


def main() -> None:
    """Measure and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", type=Path, default=Path("benchmarks/results/micro.json"))
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    problem = past_pillar(to.load("panda"), boxes=20)
    found = pieces(problem)
    text = table(["piece", "CPU us"], [[name, f"{value:,.0f}"] for name, value in found.items()])
    print(text)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    given.json.write_text(json.dumps({"microseconds": found}, indent=1) + "\n")
    if given.page is not None:
        write_section(given.page, "micro", text)


if __name__ == "__main__":
    main()
