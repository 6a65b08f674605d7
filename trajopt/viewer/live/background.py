"""Computations of the live page in threads: planning, and the reach of the hand."""

import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trajopt.lab.reach import reach_map
from trajopt.optimise.solvers import Iteration
from trajopt.planning.budget import DOING
from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors import TrajoptError
from trajopt.viewer.live.workbench import hand_at
from trajopt.why import Explanation, explain

ATTEMPT = "optimise"
"""The first long stage of each attempt."""


@dataclass(frozen=True, eq=False)
class PlanningOutcome(Value):
    """Outcome of planning."""

    result: Result | None
    explanation: Explanation | None
    refusal: str = ""


class Planning:
    """A problem being planned, started on construction; `planned` is None until the end."""

    def __init__(self, subject: Problem | Result, listener: Callable[["Planning"], None]) -> None:
        """Start; the listener is called in the planning thread on each progress."""
        self._subject, self._listener = subject, listener
        self._cancel, self._attempt = threading.Event(), 0
        self._stage = "beginning" if isinstance(subject, Problem) else "trying changes"
        self._best: float | None = None
        self.planned: PlanningOutcome | None = None
        self._thread = threading.Thread(target=self._work, name="trajopt live planning", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        return self.planned is None

    @property
    def alive(self) -> bool:
        return self._thread.is_alive()

    @property
    def words(self) -> str:
        if self._cancel.is_set():
            return "Cancelling ..."
        attempt = f" (attempt {self._attempt})" if self._attempt > 1 else ""
        have = "" if self._best is None else f" A motion of {self._best:.2f} s was found."
        return f"Planning: {self._stage}{attempt} ...{have}"

    def cancel(self) -> None:
        self._cancel.set()
        self._listener(self)

    def close(self) -> None:
        self._cancel.set()
        self._thread.join()

    def _work(self) -> None:
        subject = self._subject
        self.planned = self._plan(subject) if isinstance(subject, Problem) else self._explain(subject)
        self._listener(self)

    def _plan(self, problem: Problem) -> PlanningOutcome:
        try:
            result = plan(problem, cancel=self._cancel, progress=self._hear, on_incumbent=self._have)
        except TrajoptError as error:
            return PlanningOutcome(None, None, str(error))
        if self._cancel.is_set():
            return PlanningOutcome(result, None)
        self._say("computing prices" if result.verified else "finding the obstacle")
        return PlanningOutcome(result, explain(result))

    def _explain(self, result: Result) -> PlanningOutcome:
        def again(problem: Problem) -> Result:
            if self._cancel.is_set():
                raise _CancelledError
            return plan(problem, cancel=self._cancel)

        try:
            return PlanningOutcome(result, explain(result, plan_again=True, plan=again))
        except _CancelledError:
            return PlanningOutcome(result, explain(result))

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


COUNT = 100_000
"""Configurations drawn: a second of work for seven joints, and few holes in the planes."""
CELL = 0.05
"""Edge of a cell, and between two dots [m]."""
RAMP = np.array(((68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)), dtype=np.float64)
"""From few directions of the hand to many: five colours of viridis, legible to colour-blind readers too."""


@dataclass(frozen=True, eq=False)
class Reach(Value):
    """The drawn reach: centres of reached cells (k, 3) [m], from dark, for few directions, to bright."""

    points: Floats
    colours: NDArray[np.uint8]
    words: str


def reach_of(reduced: ReducedModel, hand: str) -> Reach:
    """Return the reach of the hand on a level plane and on an upright one through the base."""
    found = reach_map(reduced, hand, COUNT, rng=np.random.default_rng(0), cell=CELL)
    now = hand_at(reduced, hand, reduced.start_positions).translation
    base = reduced.scene.placement_of(reduced.scene.robot.links[0], reduced.start).translation
    cells = np.argwhere(found.hits > 0)
    points = found.origin + CELL * (cells + 0.5)
    ahead = (now - base)[:2]
    length = float(np.linalg.norm(ahead))
    aside = np.array((-ahead[1], ahead[0])) / length if length > CELL else np.array((0.0, 1.0))
    level = np.abs(points[:, 2] - now[2]) <= CELL / 2.0
    chosen = level | (np.abs((points - base)[:, :2] @ aside) <= CELL / 2.0)
    share = found.reachability_index[tuple(cells[chosen].T)]
    words = (
        f"The hand reaches {found.volume:.2f} m³ without a collision. Dots show two planes through it: dark "
        "for few directions of arrival, bright for many."
    )
    return Reach(points[chosen], _painted(share), words)


class Reaching:
    """Finds the reach in a thread."""

    def __init__(
        self, reduced: ReducedModel, hand: str, listener: Callable[["Reaching", Reach | str], None]
    ) -> None:
        self.reduced = reduced

        def work() -> None:
            try:
                listener(self, reach_of(reduced, hand))
            except TrajoptError as error:
                listener(self, f"Nothing is reached: {error}.")

        self._thread = threading.Thread(target=work, name="trajopt live reach", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._thread.join()


def _painted(share: Floats) -> NDArray[np.uint8]:
    place = share / max(float(share.max(initial=0.0)), 1e-9) * (len(RAMP) - 1)
    columns = [np.interp(place, np.arange(len(RAMP)), RAMP[:, colour]) for colour in range(3)]
    return np.stack(columns, axis=1).astype(np.uint8)
