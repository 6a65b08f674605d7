"""One problem: asked, judged anew, and what is called proven attacked."""

import time
import traceback

import numpy as np

import trajopt as to
from tests.fuzz.random_problems.attack import counterexample
from tests.fuzz.random_problems.case import Case
from tests.fuzz.random_problems.check import fault_of_trajectory
from tests.fuzz.random_problems.registry import case as drawn
from trajopt.why.explanation import Certainty

FALSE = ("false success", "false proof", "hang", "crash")
"""Outcomes that must not be."""


def trial(family: str, seed: int) -> dict[str, object]:
    """Return how a problem ended, as plain data."""
    row: dict[str, object] = {"key": f"{family}-{seed}", "family": family, "seed": seed}
    wall = time.perf_counter()
    case = drawn(family, seed)
    known = "impossible" if case.impossible else ("open" if case.motion is None else "feasible")
    row |= {"known": known, "drawn": round(time.perf_counter() - wall, 3)}
    cpu = time.process_time()
    try:
        row |= judged(case, seed)
    except to.TrajoptError as error:
        row |= {"outcome": "refused", "detail": f"{type(error).__name__}: {error}"}
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{last.filename.rpartition('/')[2]}:{last.lineno}"
        row |= {"outcome": "crash", "detail": f"{type(error).__name__}: {error} ({where})"}
    row |= {
        "cpu": round(time.process_time() - cpu, 3),
        "wall": round(time.perf_counter() - wall, 3),
    }
    return row


def judged(case: Case, seed: int) -> dict[str, object]:
    """Plan a problem and check what comes out."""
    before = time.process_time()
    result = to.plan(case.problem())
    row: dict[str, object] = {
        "status": result.status.name,
        "planning": round(time.process_time() - before, 3),
    }
    if result.verified:
        fault = fault_of_trajectory(case, result.require().trajectory)
        if not fault and case.impossible:
            fault = f"this was known to be impossible: {case.impossible}"
        return row | {"outcome": "false success" if fault else "verified", "detail": fault}
    assert result.reason.strip(), "a failure without a reason"
    explained = result.explain()
    proven = explained.certainty is Certainty.PROVEN and result.status is not to.Status.METHOD_CANNOT
    row |= {"proven": proven, "detail": result.reason[:300]}
    wrong = counterexample(case, result, np.random.default_rng(seed)) if proven else ""
    if wrong:
        return row | {"outcome": "false proof", "detail": f"{wrong}; claimed: {explained.grounds[:300]}"}
    return row | {"outcome": "failed"}
