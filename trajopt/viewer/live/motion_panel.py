"""The panel of the motion: plan, cancel, result, time slider."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.live.desk import Desk, Lever
from trajopt.viewer.live.planning import Planned, Planning
from trajopt.viewer.live.words import block_html, planned_html
from trajopt.viewer.live.workbench import Workbench
from trajopt.viewer.playback import Playback

if TYPE_CHECKING:
    from viser import ClientHandle, ViserServer

WELCOME = (
    "Drag the arrows and rings at the hand: the coloured robot shows how it would stand. Then press Plan."
)
READY = "Press Plan to find a motion there."
FILE = "plan.trajopt"


class MotionPanel:
    """Planning and the resulting motion.

    Attributes:
        planned: Outcome of planning to the present goal; None before.
        motion: The shown motion, or None.
        playback: The time slider.
    """

    def __init__(
        self,
        server: "ViserServer",
        desk: Desk,
        bench: Workbench,
        *,
        stand: Callable[[Floats], None],
        show_motion: Callable[[Trajectory | None], None],
        found: Callable[[], None],
    ) -> None:
        """Add the controls.

        Args:
            server: Serves the page.
            desk: Handles requests.
            bench: The state of the page.
            stand: Draws the robot at a posture of the group.
            show_motion: Draws the line of a motion, or none.
            found: Called when a motion appears or disappears.
        """
        self._server, self._desk, self._bench = server, desk, bench
        self._stand, self._show_motion, self._found = stand, show_motion, found
        self._planning: Planning | None = None
        self._greets = True
        self._ending: list[Planning] = []
        self.planned: Planned | None = None
        self.motion: Trajectory | None = None
        self._plan = Lever(server, "Plan", "Find a motion from where the robot is to its goal.", self._press)
        self._cancel = Lever(
            server,
            "Cancel planning",
            "End it, with the best motion until then.",
            self._press_cancel,
            colour="gray",
        )
        self._text = server.gui.add_html(block_html("", [WELCOME]))
        self._why = Lever(
            server,
            "What would change it?",
            "Plan again with changes: takes a while.",
            self._press_why,
            colour="gray",
        )
        self._save = Lever(
            server, "Save the plan ...", "One file with robot, scene and motion: trajopt view shows it.",
            self._press_save, colour="gray",
        )  # fmt: skip
        self._folder = server.gui.add_folder("Motion")
        with self._folder:
            self.playback = Playback(server, 0.0, lambda _: desk.do("frame", self._frame))
        self.playback.replace(0.0)
        self.show()

    def show(self) -> None:
        """Enable the controls that are usable now."""
        busy = self._planning is not None and self._planning.busy
        over = self.planned is not None and self.planned.result is not None and not busy
        self._plan.allow("planning is under way" if busy else self._bench.refusal)
        self._cancel.offer(busy)
        self._why.offer(over)
        self._save.offer(over)
        self._folder.visible = self.motion is not None and not self._bench.held
        if self.planned is None and not busy and not self._greets:
            refusal = self._plan.refusal
            self._text.content = block_html("", [f"Nothing to plan: {refusal}."] if refusal else [READY])

    def drop(self) -> None:
        """Remove the motion: the request has changed."""
        if self._planning is not None:
            self._planning.cancel()
            self._ending = [each for each in (*self._ending, self._planning) if each.alive]
            self._planning = None
        self.planned, self._greets = None, False
        if self.motion is not None:
            self._take(None)

    def say(self, title: str, lines: list[str]) -> None:
        """Show a text instead of the outcome."""
        self._greets = True
        self._text.content = block_html(title, lines)

    def close(self) -> None:
        """Cancel planning, and end the playback thread."""
        for each in (*self._ending, *([] if self._planning is None else [self._planning])):
            each.close()
        self.playback.close()

    def _press(self, _: object) -> None:
        def begin() -> None:
            if not self._bench.refusal:
                self.drop()
                self._planning = Planning(self._bench.problem, self._told)
                self._hear(self._planning)

        self._desk.do("plan", begin)

    def _press_cancel(self, _: object) -> None:
        if self._planning is not None:
            self._planning.cancel()

    def _press_why(self, _: object) -> None:
        def begin() -> None:
            if self.planned is not None and self.planned.result is not None:
                self._planning = Planning(self.planned.result, self._told)
                self._hear(self._planning)

        self._desk.do("plan", begin)

    def _press_save(self, client: "ClientHandle | None") -> None:
        def send() -> None:
            result = None if self.planned is None else self.planned.result
            if result is not None and client is not None:
                with TemporaryDirectory() as folder:
                    file = Path(folder) / FILE
                    result.save(file)
                    client.send_file_download(FILE, file.read_bytes())

        self._desk.do("save", send)

    def _told(self, planning: Planning) -> None:
        self._desk.do("planning", lambda: self._hear(planning))

    def _hear(self, planning: Planning) -> None:
        """Show the progress or outcome of planning."""
        if planning is not self._planning:
            return  # what was asked for has changed since
        planned = planning.planned
        self._text.content = block_html("", [planning.words]) if planned is None else planned_html(planned)
        if planned is not None and planned is not self.planned:
            self.planned = planned
            result = planned.result
            found = result.trajectory if result is not None and result.verified else None
            if found is not self.motion:
                self._take(found)
        self.show()

    def _take(self, motion: Trajectory | None) -> None:
        self.motion = motion
        self._show_motion(motion)
        self.playback.replace(0.0 if motion is None else motion.duration)
        self._frame()
        self._found()

    def _frame(self) -> None:
        """Draw the robot at the shown time, unless it is being driven."""
        if self._bench.held:
            return
        motion = self.motion
        self._stand(self._bench.positions if motion is None else motion(self.playback.time))
