"""Planning in a thread of its own, with progress and cancellation, so that the page stays responsive.

Solver and judge release the interpreter lock while they compute, so no process is needed: robots and scenes
are not copied, and a cancelled plan ends at its next step.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass

from trajopt.optimise.solvers import Iteration
from trajopt.planning.budget import DOING
from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Value
from trajopt.values.errors import TrajoptError
from trajopt.why import Explanation, explain

ATTEMPT = "optimise"
"""The first long stage of each attempt."""


@dataclass(frozen=True, eq=False)
class Planned(Value):
    """Outcome of planning.

    Attributes:
        result: The result; None if planning could not start.
        explanation: Cause of a failure, or prices of a motion's limits; None if cancelled.
        refusal: The reason why planning could not start.
    """

    result: Result | None
    explanation: Explanation | None
    refusal: str = ""


class Planning:
    """A problem being planned, started on construction.

    Attributes:
        planned: Its outcome; None until then.
    """

    def __init__(self, subject: Problem | Result, listener: Callable[["Planning"], None]) -> None:
        """Start.

        Args:
            subject: The problem; or a result of it, to search remedies.
            listener: Called in the planning thread on each progress.
        """
        self._subject, self._listener = subject, listener
        self._cancel, self._attempt = threading.Event(), 0
        self._stage = "beginning" if isinstance(subject, Problem) else "trying what a change would do"
        self._best: float | None = None
        self.planned: Planned | None = None
        self._thread = threading.Thread(target=self._work, name="trajopt live planning", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether it still plans."""
        return self.planned is None

    @property
    def alive(self) -> bool:
        """Whether its thread has not ended yet."""
        return self._thread.is_alive()

    @property
    def words(self) -> str:
        """Its progress in words."""
        if self._cancel.is_set():
            return "Cancelling ..."
        attempt = f" (attempt {self._attempt})" if self._attempt > 1 else ""
        have = "" if self._best is None else f" A motion of {self._best:.2f} s was found."
        return f"Planning: {self._stage}{attempt} ...{have}"

    def cancel(self) -> None:
        """End it soon, with the results until then."""
        self._cancel.set()
        self._listener(self)

    def close(self) -> None:
        """Cancel it, and wait until its thread has ended."""
        self._cancel.set()
        self._thread.join()

    def _work(self) -> None:
        """Plan, and report the outcome (body of the thread)."""
        subject = self._subject
        self.planned = self._plan(subject) if isinstance(subject, Problem) else self._explain(subject)
        self._listener(self)

    def _plan(self, problem: Problem) -> Planned:
        try:
            result = plan(problem, cancel=self._cancel, progress=self._hear, on_incumbent=self._have)
        except TrajoptError as error:
            return Planned(None, None, str(error))
        if self._cancel.is_set():
            return Planned(result, None)
        self._say("asking what it costs" if result.verified else "asking what stands in the way")
        return Planned(result, explain(result))

    def _explain(self, result: Result) -> Planned:
        def again(problem: Problem) -> Result:
            if self._cancel.is_set():
                raise _CancelledError
            return plan(problem, cancel=self._cancel)

        try:
            return Planned(result, explain(result, plan_again=True, plan=again))
        except _CancelledError:
            return Planned(result, explain(result))

    def _hear(self, stage: str, step: Iteration | None) -> None:
        if step is None:
            self._attempt += stage == ATTEMPT
            self._say(DOING.get(stage, stage))

    def _have(self, result: Result) -> None:
        self._best = result.cost
        self._listener(self)

    def _say(self, stage: str) -> None:
        self._stage = stage
        self._listener(self)


class _CancelledError(Exception):
    """The search of remedies was cancelled."""
