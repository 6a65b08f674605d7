"""The panel of the goal: joint sliders, named states, and whether the orientation counts."""

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from trajopt.robot.joints import joint_unit
from trajopt.viewer.live.desk import Lever
from trajopt.viewer.live.workbench import Workbench

if TYPE_CHECKING:
    from viser import GuiCheckboxHandle, GuiDropdownHandle, GuiEvent, GuiSliderHandle, ViserServer

TURN = 360.0
"""Range of the slider of an unlimited joint, to either side [deg | mm]."""
WORD_ENDS = re.compile(r"(?<=[_/])")
CHOOSE = "choose ..."
DEGREES, MILLIMETRES = "°", "mm"


class GoalPanel:
    """Controls of the goal, in addition to the gizmo."""

    def __init__(
        self,
        server: "ViserServer",
        bench: Workbench,
        ask: Callable[[str, Callable[[], None]], None],
    ) -> None:
        """Add the controls.

        Args:
            server: Serves the page.
            bench: The state of the page.
            ask: Requests a change of the state: its name, and the change.
        """
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
        self.reset = Lever(
            server, "Goal to where the robot is", "Take the goal back.", self._reset, colour="gray"
        )
        self._scales = tuple(_scale(bench, joint) for joint in bench.reduced.joint_names)
        with gui.add_folder("Joints of the goal"):
            self._joints = [self._slider(place) for place in range(len(self._scales))]

    def show(self) -> None:
        """Show the goal as it is."""
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
    """Remove from a name the words that all names begin with: a panel is narrow."""
    words = [WORD_ENDS.split(each) for each in names]
    common = 0
    while all(len(each) > common + 1 for each in words) and len({each[common] for each in words}) == 1:
        common += 1
    return "".join(WORD_ENDS.split(name)[common:]) if len(names) > 1 else name


def _scale(bench: Workbench, joint: str) -> tuple[float, str]:
    """Return factor and unit of a joint's displayed position."""
    turns = joint_unit(bench.scene.robot.model, joint) == "rad"
    return (180.0 / np.pi, DEGREES) if turns else (1000.0, MILLIMETRES)
