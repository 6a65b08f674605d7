"""Workers: the candidates of one round attempted in several threads; results come in their order.

The cores release Python's lock, so threads run side by side but for what Python does between their calls.
Nothing is sent anywhere: problem, method and the user's own terms are used as they are.
"""

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import replace
from threading import Event

from trajopt.planning.budget import BudgetTracker
from trajopt.planning.goal_search import Candidate, attempt
from trajopt.planning.result import Result
from trajopt.planning.workspace import Workspace

POLL = 0.005
"""How often the budget is checked while waiting [s]."""


def attempted_in_threads(candidates: Sequence[Candidate], tracker: BudgetTracker) -> Iterator[Result]:
    """Attempt candidates; yield their results in the order given, their work added to the tracker.

    Args:
        candidates: The candidates.
        tracker: Of the whole of planning; its budget says how many workers there may be.

    Raises:
        Stopped: If the budget ends; whoever ends the iteration ends the attempts.
    """
    from concurrent.futures import ThreadPoolExecutor, wait

    over, so_far = Event(), tracker.so_far

    def alone(candidate: Candidate) -> Result:
        """Attempt with a workspace and programs of this thread's own: their queries belong to one thread."""
        mine = BudgetTracker.elsewhere(tracker.budget, so_far, over)
        work = Workspace(candidate.workspace.problem, mine)
        branches = tuple(copy(branch) for branch in candidate.branches)
        return attempt(replace(candidate, workspace=work, branches=branches))

    pool = ThreadPoolExecutor(min(tracker.budget.workers, len(candidates)), "trajopt")
    try:
        for running in [pool.submit(alone, candidate) for candidate in candidates]:
            while not running.done():
                tracker.check()
                wait((running,), POLL)
            result = running.result()
            tracker.add(result.counts, result.cpu_seconds)
            tracker.check()
            yield result
    finally:
        over.set()
        pool.shutdown(cancel_futures=True)
