"""Stand-ins of controllers that take positions, on a clock that the test sets."""

from collections.abc import Callable

import numpy as np

from trajopt.driving import StreamingExecutor
from trajopt.values.arrays import Floats


class Clock:
    """A clock, and a loop of a driver that runs on it."""

    def __init__(self) -> None:
        self.time, self.tick, self.period = 100.0, (lambda: None), 1.0

    def __call__(self) -> float:
        return self.time

    def drive(self, executor: StreamingExecutor) -> None:
        self.tick, self.period = executor.tick, executor.period
        self.due = self.time + self.period

    def wait(self, seconds: float) -> None:
        """Let time pass in steps of a millisecond."""
        for _ in range(round(seconds / 1e-3)):
            self.time = round(self.time + 1e-3, 9)
            if self.time >= self.due - 1e-9:
                self.tick()
                self.due += self.period


class Servos:
    """Motors that go to the commanded positions within a period."""

    def __init__(self, positions: Floats, clock: Callable[[], float], period: float) -> None:
        self.goal, self.begin = positions.copy(), positions.copy()
        self.sent, self.clock, self.period = clock(), clock, period

    def positions(self) -> Floats:
        share = min((self.clock() - self.sent) / self.period, 1.0)
        return self.begin + share * (self.goal - self.begin)

    def velocities(self) -> Floats:
        moves = self.clock() - self.sent < self.period + 1e-9
        return (self.goal - self.begin) / self.period if moves else np.zeros(len(self.goal))

    def go(self, goal: Floats) -> None:
        self.begin, self.goal, self.sent = self.positions(), np.array(goal), self.clock()
