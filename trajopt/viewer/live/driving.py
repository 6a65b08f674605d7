"""Driving: the simulated robot on its way to a goal, in real time and in a thread of its own.

A supervisor drives it, as on a real arm: each piece is proven with a stop after it before it is driven, and
what is put up or moved on the way is seen, slowed down for, or gone around.
"""

import threading
import time
from collections.abc import Callable, Sequence

from trajopt.driving import Event, SimulatedExecutor, Supervisor
from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import TrajoptError

CYCLE = 0.02
"""Time from one look of the supervisor to the next, as its options have it [s]."""
STOPPING = 5.0
"""A robot that was told to stop stands after so long, or it never will [s]."""


class Driving:
    """A run to a goal, from when it is made on.

    Attributes:
        positions: Where the group's joints are, shape (n,) [rad | m].
        events: What happened, in order.
        outcome: How it ended, in words; empty until then.
    """

    def __init__(self, problem: Problem, listener: Callable[["Driving"], None]) -> None:
        """Begin.

        Args:
            problem: Where the robot is, and where it goes.
            listener: Called after each cycle, in the thread that drives.
        """
        self._problem, self._listener = problem, listener
        self._stop, self._scene = threading.Event(), threading.Lock()
        self._changed: Scene | None = None
        self.positions: Floats = problem.reduced.start_positions
        self.events: Sequence[Event] = ()
        self.outcome = ""
        self._thread = threading.Thread(target=self._work, name="trajopt live driving", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether the robot is being driven."""
        return not self.outcome

    def see(self, scene: Scene) -> None:
        """Let the world be another one from now on: the robot is in it, and the supervisor told of it."""
        with self._scene:
            self._changed = scene

    def stop(self) -> None:
        """Bring the robot to rest where that is proven."""
        self._stop.set()

    def close(self) -> None:
        """Stop, and wait until the thread has ended."""
        self._stop.set()
        self._thread.join()

    def _work(self) -> None:
        """Drive until there is nothing more to do (body of the thread)."""
        try:
            outcome = self._drive()
        except TrajoptError as error:
            outcome = f"It cannot be driven: {error}."
        self.outcome = outcome
        self._listener(self)

    def _drive(self) -> str:
        problem = self._problem
        arm = SimulatedExecutor(problem.scene, problem.start_positions)
        supervisor = Supervisor(arm, problem)
        supervisor.see(problem.scene, 0.0)
        supervisor.go(problem)
        begin = time.monotonic()
        while supervisor.busy and not supervisor.blocked and not arm.fault() and not self._stop.is_set():
            self._cycle(arm, supervisor, begin)
        stopped = self._stop.is_set()
        if stopped:
            supervisor.stop()
            until = arm.now() + STOPPING
            while supervisor.moving and arm.now() < until:
                self._cycle(arm, supervisor, begin)
        if arm.fault():
            return f"The robot does not follow: {arm.fault()}."
        self._note(arm, supervisor, arm.state().commanded)
        touched = [str(each) for each in arm.contacts if each.allowance is None]
        if touched:
            return f"Something was touched: {'; '.join(touched)}."
        if stopped:
            return f"Stopped after {arm.now():.1f} s; the robot stands."
        if supervisor.busy:
            return "The way is blocked, and no way around was found: the robot stands."
        return f"The goal was reached after {arm.now():.1f} s, and nothing was touched."

    def _cycle(self, arm: SimulatedExecutor, supervisor: Supervisor, begin: float) -> None:
        with self._scene:
            scene, self._changed = self._changed, None
        if scene is not None:
            arm.change(scene, begin=arm.now())
            supervisor.see(scene)
        supervisor.cycle()
        arm.advance(CYCLE)
        self._note(arm, supervisor, arm.truth().positions)
        self._listener(self)
        time.sleep(max(begin + arm.now() - time.monotonic(), 0.0))

    def _note(self, arm: SimulatedExecutor, supervisor: Supervisor, positions: Floats) -> None:
        columns = [arm.joint_names.index(name) for name in self._problem.reduced.joint_names]
        self.positions, self.events = positions[columns].copy(), tuple(supervisor.events)
