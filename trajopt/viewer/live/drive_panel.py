"""The panel of execution: the planned motion driven in the simulated world, and stopped."""

import threading
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from trajopt.driving import Event, SimulatedExecutor, Supervisor
from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import TrajoptError
from trajopt.viewer.live.desk import Desk, Lever
from trajopt.viewer.live.words import block_html
from trajopt.viewer.live.workbench import Workbench
from trajopt.viewer.readout import events_html

if TYPE_CHECKING:
    from viser import ViserServer

CYCLE = 0.02
"""Period of the supervisor, as in its options [s]."""
STOPPING = 5.0
"""Longest expected time of a stop [s]."""


class Driving:
    """A run to a goal, started on construction.

    Attributes:
        positions: Positions of the group's joints, shape (n,) [rad | m].
        events: Events in order.
        outcome: Its outcome, in words; empty until then.
    """

    def __init__(self, problem: Problem, listener: Callable[["Driving"], None]) -> None:
        """Start.

        Args:
            problem: Start and goal of the robot.
            listener: Called after each cycle, in the driving thread.
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
        """Replace the world, for the simulated robot and the supervisor."""
        with self._scene:
            self._changed = scene

    def stop(self) -> None:
        """Bring the robot to rest by a proven stop."""
        self._stop.set()

    def close(self) -> None:
        """Stop, and wait until the thread has ended."""
        self._stop.set()
        self._thread.join()

    def _work(self) -> None:
        """Drive until the run is over (body of the thread)."""
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


HELD = "the robot is being driven"
UNPLANNED = "there is no motion yet"
EVENTS = 4
"""Number of listed events, the latest ones."""


class DrivePanel:
    """Buttons to execute and to stop.

    Attributes:
        driving: The current or last run.
    """

    def __init__(
        self,
        server: "ViserServer",
        desk: Desk,
        bench: Workbench,
        *,
        stand: Callable[[Floats], None],
        changed: Callable[[], None],
    ) -> None:
        """Add the controls.

        Args:
            server: Serves the page.
            desk: Handles requests.
            bench: The state of the page.
            stand: Draws the robot at a posture of the group.
            changed: Called when a run starts or ends.
        """
        self._desk, self._bench, self._stand, self._changed = desk, bench, stand, changed
        self.driving: Driving | None = None
        self._execute = Lever(
            server, "Execute in simulation", "Drive the simulated robot to the goal, in real time.",
            self._press, colour="green",
        )  # fmt: skip
        self._stop = Lever(server, "Stop", "Bring the robot to rest.", self._press_stop, colour="red")
        self._text = server.gui.add_html("")

    @property
    def busy(self) -> bool:
        """Whether the robot is being driven."""
        return self.driving is not None and self.driving.busy

    def show(self, *, planned: bool) -> None:
        """Enable the buttons, depending on whether there is a motion."""
        self._execute.allow(HELD if self.busy else "" if planned else UNPLANNED)
        self._stop.offer(self.busy)

    def see(self) -> None:
        """Pass the present scene to the running robot."""
        if self.driving is not None and self.driving.busy:
            self.driving.see(self._bench.scene)

    def close(self) -> None:
        """Stop, and end the thread that drives."""
        if self.driving is not None:
            self.driving.close()

    def _press(self, _: object) -> None:
        def begin() -> None:
            if not self.busy and not self._bench.refusal:
                problem = self._bench.problem
                self._bench.held = HELD
                self.driving = Driving(problem, self._told)
                self._changed()

        self._desk.do("execute", begin)

    def _press_stop(self, _: object) -> None:
        if self.driving is not None:
            self.driving.stop()

    def _told(self, driving: Driving) -> None:
        # What ends a run must not be replaced by what was said before.
        self._desk.do("driving" if driving.busy else "driven", lambda: self._hear(driving))

    def _hear(self, driving: Driving) -> None:
        if driving.busy:
            self._stand(driving.positions)
            self._text.content = events_html(driving.events, EVENTS)
        elif self._bench.held:
            self._bench.held = ""
            self._bench.stand(driving.positions)
            self._text.content = block_html("", [driving.outcome])
            self._changed()
