"""Panels of the live page, and the thread that handles their requests."""

import logging
import re
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Literal

import numpy as np

from trajopt.driving import Event
from trajopt.driving.rehearsal import LiveRun
from trajopt.problem.problem import Problem
from trajopt.robot.joints import joint_unit
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import TrajoptError
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.live.background import Planning, PlanningOutcome
from trajopt.viewer.live.workbench import Workbench
from trajopt.viewer.playback import Playback
from trajopt.viewer.readout import block_html, events_html, planned_html

if TYPE_CHECKING:
    from viser import (
        ClientHandle,
        GuiButtonHandle,
        GuiCheckboxHandle,
        GuiDropdownHandle,
        GuiEvent,
        GuiSliderHandle,
        ViserServer,
    )

LOG = logging.getLogger(__name__)


class Desk:
    """Does things in a thread of its own."""

    def __init__(self, complain: Callable[[str], None]) -> None:
        """Start the thread; `complain` receives the reason why a request failed."""
        self._complain = complain
        self._waiting: dict[str, Callable[[], None]] = {}
        self._working, self._closed = False, False
        self._news = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="trajopt live page", daemon=True)
        self._thread.start()

    def do(self, name: str, work: Callable[[], None]) -> None:
        with self._news:
            self._waiting[name] = work
            self._news.notify_all()

    def settle(self, seconds: float) -> bool:
        with self._news:
            return self._news.wait_for(lambda: not self._waiting and not self._working, seconds)

    def close(self) -> None:
        with self._news:
            self._closed = True
            self._news.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _work(self) -> None:
        while True:
            with self._news:
                self._working = False
                self._news.notify_all()
                self._news.wait_for(lambda: bool(self._waiting) or self._closed)
                if self._closed:
                    return
                name = next(iter(self._waiting))
                work, self._working = self._waiting.pop(name), True
            try:
                work()
            except TrajoptError as error:
                self._complain(str(error))
            except Exception as error:  # a fault of the page must not leave it dead
                LOG.exception("the live page failed at %s", name)
                self._complain(f"a fault of this page ({type(error).__name__}: {error})")


Colour = Literal["blue", "green", "red", "gray"]


class Lever:
    """A button; the reason why it is disabled is empty if it is enabled."""

    def __init__(
        self,
        server: "ViserServer",
        name: str,
        hint: str,
        pressed: Callable[["ClientHandle | None"], None],
        *,
        colour: Colour = "blue",
    ) -> None:
        self.name, self.refusal, self._hint = name, "", hint
        self._button: GuiButtonHandle = server.gui.add_button(name, hint=hint, color=colour)

        @self._button.on_click
        def _(event: "GuiEvent[GuiButtonHandle]") -> None:
            if not self.refusal:
                pressed(event.client)

    def allow(self, refusal: str = "") -> None:
        self.refusal = refusal
        self._button.disabled = bool(refusal)
        self._button.hint = f"{self._hint} Not now: {refusal}." if refusal else self._hint

    def offer(self, there: bool) -> None:
        self._button.visible = there
        self.refusal = "" if there else "it is not offered"


TURN = 360.0
"""Range of the slider of an unlimited joint, to either side [deg | mm]."""
WORD_ENDS = re.compile(r"(?<=[_/])")
CHOOSE = "choose ..."
DEGREES, MILLIMETRES = "°", "mm"


class GoalPanel:
    """Controls of the goal, beyond the gizmo."""

    def __init__(
        self,
        server: "ViserServer",
        bench: Workbench,
        ask: Callable[[str, Callable[[], None]], None],
    ) -> None:
        self._server, self._bench, self._ask = server, bench, ask
        gui = server.gui
        self._states: GuiDropdownHandle[str] | None = None
        if bench.states:
            self._states = gui.add_dropdown(
                "named posture",
                (CHOOSE, *bench.states),
                hint="Ask for a posture that the robot's files name.",
            )
            self._states.on_update(self._choose_state)
        self._turned = gui.add_checkbox(
            "keep the hand's orientation",
            bench.turned,
            hint="Off: only the position of the hand counts, it may be turned as it likes.",
        )
        self._turned.on_update(self._turn)
        self.reset = Lever(server, "Goal at the robot", "Take the goal back.", self._reset, colour="gray")
        self._scales = tuple(_scale(bench, joint) for joint in bench.reduced.joint_names)
        with gui.add_folder("Joints of the goal"):
            self._joints = [self._slider(place) for place in range(len(self._scales))]

    def show(self) -> None:
        positions = self._bench.goal.positions.tolist()
        with self._server.atomic():
            for slider, (scale, _), position in zip(self._joints, self._scales, positions, strict=True):
                slider.value = float(np.clip(round(scale * position, 1), slider.min, slider.max))

    def _slider(self, place: int) -> "GuiSliderHandle[float]":
        reduced, (scale, unit) = self._bench.reduced, self._scales[place]
        name, lower, upper = (
            reduced.joint_names[place],
            *(scale * float(each[place]) for each in (reduced.limits.lower, reduced.limits.upper)),
        )
        lower, upper = (lower if np.isfinite(lower) else -TURN), (upper if np.isfinite(upper) else TURN)
        # Rounded inward: the ends of a slider are within the limits.
        low, high = np.ceil(10.0 * lower) / 10.0, np.floor(10.0 * upper) / 10.0
        now = float(np.clip(round(scale * float(self._bench.goal.positions[place]), 1), low, high))
        label = f"{short(name, reduced.joint_names)} [{unit}]"
        slider = self._server.gui.add_slider(label, float(low), float(high), 0.1, now)

        @slider.on_update
        def _(event: "GuiEvent[GuiSliderHandle[float]]") -> None:
            if event.client is not None:
                value = slider.value / scale
                self._ask(f"joint {name}", lambda: self._bench.move_joint(name, value))

        return slider

    def _choose_state(self, event: "GuiEvent[GuiDropdownHandle[str]]") -> None:
        assert self._states is not None
        name = self._states.value
        if event.client is not None and name != CHOOSE:
            positions = self._bench.states[name]
            self._ask("goal", lambda: self._bench.move_joints(positions))
            self._states.value = CHOOSE

    def _turn(self, event: "GuiEvent[GuiCheckboxHandle]") -> None:
        if event.client is not None:
            turned = self._turned.value
            self._ask("goal", lambda: self._bench.count_orientation(turned))

    def _reset(self, _: object) -> None:
        self._ask("goal", self._bench.reset_goal)


def short(name: str, names: Sequence[str]) -> str:
    words = [WORD_ENDS.split(each) for each in names]
    common = 0
    while all(len(each) > common + 1 for each in words) and len({each[common] for each in words}) == 1:
        common += 1
    return "".join(WORD_ENDS.split(name)[common:]) if len(names) > 1 else name


def _scale(bench: Workbench, joint: str) -> tuple[float, str]:
    turns = joint_unit(bench.scene.robot.model, joint) == "rad"
    return (180.0 / np.pi, DEGREES) if turns else (1000.0, MILLIMETRES)


WELCOME = "Drag the arrows and rings at the hand: the coloured robot shows the goal. Then press Plan."
READY = "Press Plan to find a motion there."
FILE = "plan.trajopt"


class MotionPanel:
    """Planning and the resulting motion."""

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
        self._server, self._desk, self._bench = server, desk, bench
        self._stand, self._show_motion, self._found = stand, show_motion, found
        self._planning: Planning | None = None
        self._greets = True
        self._ending: list[Planning] = []
        self.planned: PlanningOutcome | None = None
        self.motion: Trajectory | None = None
        self._plan = Lever(
            server, "Plan", "Find a motion from the robot's configuration to its goal.", self._press
        )
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
        if self._planning is not None:
            self._planning.cancel()
            self._ending = [each for each in (*self._ending, self._planning) if each.alive]
            self._planning = None
        self.planned, self._greets = None, False
        if self.motion is not None:
            self._take(None)

    def say(self, title: str, lines: list[str]) -> None:
        self._greets = True
        self._text.content = block_html(title, lines)

    def close(self) -> None:
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
        if self._bench.held:
            return
        motion = self.motion
        self._stand(self._bench.positions if motion is None else motion(self.playback.time))


class Driving:
    """A run to a goal, started on construction; `outcome` is empty until its end."""

    def __init__(self, problem: Problem, listener: Callable[["Driving"], None]) -> None:
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
        return not self.outcome

    def see(self, scene: Scene) -> None:
        with self._scene:
            self._changed = scene

    def stop(self) -> None:
        self._stop.set()

    def close(self) -> None:
        self._stop.set()
        self._thread.join()

    def _work(self) -> None:
        try:
            outcome = self._drive()
        except TrajoptError as error:
            outcome = f"It cannot be driven: {error}."
        self.outcome = outcome
        self._listener(self)

    def _drive(self) -> str:
        run = LiveRun(self._problem)
        arm = run.arm

        def look() -> None:
            self._note(run, arm.truth().positions)
            self._listener(self)

        stopped = run.drive(self._stop.is_set, self._taken, look)
        if arm.fault():
            return f"The robot does not follow: {arm.fault()}."
        self._note(run, arm.state().commanded)
        if run.touched:
            return f"Something was touched: {'; '.join(run.touched)}."
        if stopped:
            return f"Stopped after {arm.now():.1f} s; the robot is at rest."
        if run.supervisor.busy:
            return "The way is blocked, and no way around was found: the robot is at rest."
        return f"The goal was reached after {arm.now():.1f} s, and nothing was touched."

    def _taken(self) -> Scene | None:
        with self._scene:
            scene, self._changed = self._changed, None
        return scene

    def _note(self, run: LiveRun, positions: Floats) -> None:
        columns = [run.arm.joint_names.index(name) for name in self._problem.reduced.joint_names]
        self.positions, self.events = positions[columns].copy(), tuple(run.supervisor.events)


HELD = "the robot is being driven"
UNPLANNED = "there is no motion yet"
EVENTS = 4
"""Number of listed events, the latest ones."""


class DrivePanel:
    """Buttons to execute and to stop."""

    def __init__(
        self,
        server: "ViserServer",
        desk: Desk,
        bench: Workbench,
        *,
        stand: Callable[[Floats], None],
        changed: Callable[[], None],
    ) -> None:
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
        return self.driving is not None and self.driving.busy

    def show(self, *, planned: bool) -> None:
        self._execute.allow(HELD if self.busy else "" if planned else UNPLANNED)
        self._stop.offer(self.busy)

    def see(self) -> None:
        if self.driving is not None and self.driving.busy:
            self.driving.see(self._bench.scene)

    def close(self) -> None:
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
