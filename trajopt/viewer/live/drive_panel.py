"""The panel of execution: the planned motion driven in the simulated world, and stopped."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from trajopt.values.arrays import Floats
from trajopt.viewer.live.desk import Desk
from trajopt.viewer.live.driving import Driving
from trajopt.viewer.live.lever import Lever
from trajopt.viewer.live.words import block_html
from trajopt.viewer.live.workbench import Workbench
from trajopt.viewer.readout import events_html

if TYPE_CHECKING:
    from viser import ViserServer

HELD = "the robot is being driven"
UNPLANNED = "there is no motion yet"
EVENTS = 4
"""So many events are listed, the latest ones."""


class DrivePanel:
    """Buttons to execute and to stop.

    Attributes:
        driving: The run that goes on, or was last.
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
            desk: Does what is asked for.
            bench: What is driven.
            stand: Draws the robot at a posture of the group.
            changed: Has the page show that a run has begun, or is over.
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
        """Show what can be pressed, given whether there is a motion."""
        self._execute.allow(HELD if self.busy else "" if planned else UNPLANNED)
        self._stop.offer(self.busy)

    def see(self) -> None:
        """Let the robot see what is around it now."""
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
