"""A small interpreter of URScript: what a controller of Universal Robots does with the exported programs."""

import re
from dataclasses import dataclass, field

import numpy as np

from trajopt.values.arrays import Floats

ASSIGNED = re.compile(r"(\w+) = (.+)")
CALL = re.compile(r"(\w+)\((.*)\)")


class Halted(Exception):
    """The program ended itself; the message is what its popup says."""


@dataclass
class Controller:
    """An arm that goes at once where it is told.

    Attributes:
        joints: Where its joints are [rad].
        time: How long it has moved [s].
        visited: Time and position after each move.
        radii: Radius of each blend.
    """

    joints: Floats
    time: float = 0.0
    visited: list[tuple[float, Floats]] = field(default_factory=list)
    radii: list[float] = field(default_factory=list)
    speeds: list[tuple[Floats, float, float]] = field(default_factory=list)
    stopped: bool = False

    def run(self, text: str) -> None:
        """Execute one program, `def NAME(): ... end`."""
        first, *lines = [line.partition("#")[0].strip() for line in text.splitlines()]
        assert re.fullmatch(r"def \w+\(\):", first), first
        lines = [line for line in lines if line]
        assert self._block(lines, 0, {}) == len(lines) - 1 and lines[-1] == "end"

    def _block(self, lines: list[str], place: int, names: dict[str, object]) -> int:
        """Execute lines to the end of a block; return where that is."""
        while lines[place] != "end":
            line = lines[place]
            if line.startswith(("while ", "if ")):
                after = self._skip(lines, place + 1)
                while self._value(line.split(" ", 1)[1].removesuffix(":"), names):
                    self._block(lines, place + 1, names)
                    if line.startswith("if "):
                        break
                place = after + 1
                continue
            if line == "halt":
                raise Halted(names["popup"])
            assigned, call = ASSIGNED.fullmatch(line), CALL.fullmatch(line)
            if call is not None:
                self._call(call[1], call[2], names)
            else:
                assert assigned is not None, line
                names[assigned[1]] = self._value(assigned[2], names)
            place += 1
        return place

    def _skip(self, lines: list[str], place: int) -> int:
        depth = 1
        while True:
            depth += lines[place].startswith(("while ", "if ")) - (lines[place] == "end")
            if depth == 0:
                return place
            place += 1

    def _value(self, text: str, names: dict[str, object]) -> object:
        known = {"norm": abs, "get_actual_joint_positions": lambda: list(self.joints)}
        return eval(text, {"__builtins__": {}}, {**known, **names})

    def _call(self, function: str, words: str, names: dict[str, object]) -> None:
        calls = {
            "popup": lambda text, **_: names.update(popup=text),
            "servoj": self._servoj,
            "movej": self._movej,
            "stopj": self._stopj,
        }
        eval(f"f({words})", {"__builtins__": {}}, {"f": calls[function]})

    def _servoj(self, q: list[float], *, t: float, lookahead_time: float, gain: float) -> None:
        assert t >= 0.002 - 1e-12 and 0.03 <= lookahead_time <= 0.2 and 100 <= gain <= 2000
        self._arrive(q, t)

    def _movej(self, q: list[float], *, a: float, v: float, r: float) -> None:
        assert a > 0.0 and v > 0.0 and r >= 0.0
        moved = np.array(q) - self.joints
        self.radii.append(r)
        self.speeds.append((moved, v, a))
        self._arrive(q, float(np.abs(moved).max()) / v)

    def _arrive(self, q: list[float], seconds: float) -> None:
        assert len(q) == 6 and not self.stopped
        self.time += seconds
        self.joints = np.array(q)
        self.visited.append((self.time, self.joints))

    def _stopj(self, deceleration: float) -> None:
        assert deceleration > 0.0
        self.stopped = True
