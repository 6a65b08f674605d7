"""Programs over knots, evaluated in the core and in Python."""

import numpy as np

import trajopt as to
from trajopt.optimise.solvers import Sqp
from trajopt.optimise.solvers.descent import DescentLimits
from trajopt.optimise.solvers.sqp import NativeDescent, native_descent
from trajopt.optimise.transcription import KnotsNlp, fixed_goal, transcribe
from trajopt.planning.seeds import straight_line
from trajopt.values.arrays import Floats, Ints, Rows

START = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
GOAL = {"pan": 1.0, "reach": 0.2, "elbow": 0.3, "wrist": 0.0}
SAME = {"rtol": 1e-9, "atol": 1e-12}
"""The core adds numbers up in another order."""


def program(problem: to.Problem) -> tuple[Floats, KnotsNlp]:
    goal = fixed_goal(problem)
    assert goal is not None
    seed = straight_line(problem.reduced.start_positions, goal, problem.knots)
    return seed, transcribe(problem, seed)


def descent_of(nlp: KnotsNlp, sampling: Ints) -> NativeDescent | None:
    region = Sqp().trust_region
    return native_descent("auto", nlp, sampling, DescentLimits(5, 0.0, 0.0), None, region, 5.0)


def same(mine: dict[str, object], theirs: dict[str, object]) -> None:
    for name in theirs.keys() & mine.keys():
        one, other = mine[name], theirs[name]
        if isinstance(one, Rows):
            assert isinstance(other, Rows)
            same(vars(one), vars(other))
        elif isinstance(one, np.ndarray | float):
            np.testing.assert_allclose(one, other, **SAME, err_msg=name)
        elif name not in {"cost", "each", "violation", "worst"}:
            assert one == other, name
