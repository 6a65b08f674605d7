"""Conformance: tests of the rules for executors, for your own driver."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from trajopt.driving.committed_motion import SETTLED
from trajopt.driving.executor import Executor
from trajopt.values.arrays import Floats, Value, positive
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

SAMPLES = 20
BRAKING = 2.0
"""Longest time from a stop to rest [s]."""
BRISK = 2.0
"""Largest acceleration of the motion that measures the delay of states [rad/s^2 | m/s^2]."""
REPEATED = 4
"""Repetitions of that motion, there and back."""
PEAK = 10.0 / 3.0**0.5
"""Largest acceleration of the quintic 10 t^3 - 15 t^4 + 6 t^5, from rest to rest in unit time."""


@dataclass(frozen=True)
class Rule(Value):
    """A rule for executors, and how it is broken; empty if it holds."""

    name: str
    broken: str = ""

    @property
    def holds(self) -> bool:
        """Whether it holds."""
        return not self.broken

    def __str__(self) -> str:
        return f"ok    {self.name}" if self.holds else f"FAIL  {self.name}: {self.broken}"


@checked
def conformance(
    executor: Executor,
    wait: Callable[[float], object],
    *,
    step: float = 0.02,
    duration: float = 1.0,
    speed: float = 1.0,
) -> tuple[Rule, ...]:
    """Test whether an executor follows the rules; the robot moves.

    All joints move by a small step and back, slowly and then fast; the delay of the fast motion gives the
    tracking error at full speed. The space for it must be free, and the robot at rest without a fault.

    Args:
        step: Step of each joint [rad | m].
        speed: Highest speed at which joints will be driven [rad/s | m/s].

    Raises:
        ProblemError: If a number is not positive, or `executor` lacks members of an `Executor`.
    """
    for name, value in (("step", step), ("duration", duration), ("speed", speed)):
        positive(name, value)
    return tuple(_Trial(executor, wait, step, duration, speed).rules())


@dataclass(frozen=True, eq=False)
class _Trial:
    executor: Executor
    wait: Callable[[float], object]
    step: float
    duration: float
    speed: float

    def rules(self) -> Iterator[Rule]:
        yield from self._at_rest()
        yield from self._refusals()
        yield from self._motions()
        yield self._at_speed()
        yield from self._stops()

    def _at_rest(self) -> Iterator[Rule]:
        executor = self.executor
        begin, state = executor.now(), executor.state()
        self.wait(0.1)
        passed = executor.now() - begin
        odd = f"it advanced by {passed:.3f} s in 0.1 s"
        yield Rule("its clock runs at the rate of time", "" if 0.05 < passed < 1.0 else odd)
        count = len(executor.joint_names)
        sizes = {
            len(state.positions),
            len(state.velocities),
            len(state.accelerations),
            len(executor.tolerance),
        }
        odd = f"there are {count} joints, but arrays of length {sorted(sizes)}"
        yield Rule("its state has a value for each joint", "" if sizes == {count} else odd)
        age = begin - state.stamp
        yield Rule(
            "the stamp of a state is not in the future", "" if age >= -1e-9 else f"it is {-age:.4f} s ahead"
        )
        yield Rule("it has no fault at the start", executor.fault())

    def _refusals(self) -> Iterator[Rule]:
        executor, here = self.executor, self._here()
        away = here + self.step
        soon = executor.now() + executor.latency
        late = executor.splice(self._there(here, away), soon - 2.0 * executor.latency - 0.1)
        yield Rule("it refuses a late motion", "" if late else "it accepts it")
        jumps = executor.splice(self._there(here + 10.0 * self.step, away), soon + 0.1)
        yield Rule("it refuses a motion from another position", "" if jumps else "it accepts it")
        on = Trajectory(
            executor.joint_names,
            np.array((0.0, self.duration)),
            np.stack((here, away)),
            np.stack((0.0 * here, 0.0 * here + self.step)),
            np.zeros((2, len(here))),
        )
        goes_on = executor.splice(on, executor.now() + executor.latency + 0.1)
        yield Rule("it refuses a motion that does not end at rest", "" if goes_on else "it accepts it")
        self.wait(2.0 * self.duration)
        moved = float(np.abs(self.executor.state().positions - here).max())
        odd = f"a joint moved by {moved:.4f}" if moved > executor.tolerance.max() else ""
        yield Rule("a refused motion changes nothing", odd)

    def _motions(self) -> Iterator[Rule]:
        executor, here = self.executor, self._here()
        there = self._there(here, here + self.step)
        begin = executor.now() + 2.0 * executor.latency
        odd = executor.splice(there, begin)
        yield Rule("it accepts a motion from rest to rest", odd)
        yield Rule("it follows within its tolerance", odd or self._followed(there, begin, self.duration))
        self.wait(0.2)
        yield Rule("it is at rest after the end", self._moving())
        back, begin = self._there(here + self.step, here), executor.now() + 2.0 * executor.latency
        odd = executor.splice(back, begin)
        middle = self.duration / 2.0
        rest = _to_rest(back, middle)
        odd = odd or executor.splice(rest, begin + middle)
        yield Rule("it accepts a motion in place of the second half of another", odd)
        spliced = back.between(0.0, middle).followed_by(rest)
        yield Rule("it follows through the splice", odd or self._followed(spliced, begin, spliced.duration))
        self.wait(0.2)
        yield Rule("it is at rest after the last motion", self._moving())

    def _at_speed(self) -> Rule:
        executor = self.executor
        rule, here = "it follows at full speed within its tolerance", self._here()
        lasts = max((PEAK * self.step / BRISK) ** 0.5, SAMPLES * executor.period)
        pause, errors, rates = 2.0 * executor.latency, list[Floats](), list[Floats]()
        still = [self._error() for _ in range(SAMPLES)]
        for turn in range(2 * REPEATED):
            ends = (here, here + self.step)[:: 1 if turn % 2 == 0 else -1]
            motion, begin = self._there(*ends, duration=lasts), executor.now() + pause
            if refused := executor.splice(motion, begin):
                return Rule(rule, refused)
            while executor.now() < begin + lasts:
                self.wait(lasts / SAMPLES)
                state = executor.state()
                rates.append(motion(state.stamp - begin, 1))
                errors.append(state.positions - motion(state.stamp - begin))
            self.wait(pause)
        behind = _behind(np.array(errors), np.array(rates), np.array(still))
        off, tolerance = behind * self.speed, executor.tolerance
        worst = int(tolerance.argmin())
        if off <= tolerance[worst]:
            return Rule(rule)
        return Rule(
            rule,
            f"states are up to {1e3 * behind:.1f} ms behind their stamps: at {self.speed:g} rad/s or m/s "
            f"{executor.joint_names[worst]} is off by {off:.4f}, its tolerance is {tolerance[worst]:.4f}; "
            "stamp each state by the time of the command that it shows, or state a tolerance of at least "
            f"{off:.4f}",
        )

    def _stops(self) -> Iterator[Rule]:
        executor, here = self.executor, self._here()
        begin = executor.now() + 2.0 * executor.latency
        executor.splice(self._there(here, here - self.step / 2.0), begin)
        self.wait(begin - executor.now() + self.duration / 2.0)
        executor.stop()
        yield Rule("a stop is a fault", "" if executor.fault() else "it reports none")
        self.wait(BRAKING)
        yield Rule("it comes to rest after a stop", self._moving())
        motion = self._there(self._here(), self._here() + self.step / 4.0)
        taken = not executor.splice(motion, executor.now() + 2.0 * executor.latency)
        yield Rule("it accepts no motion during a fault", "it accepts one" if taken else "")
        executor.clear_fault()
        yield Rule("a fault can be cleared", executor.fault())
        self.wait(0.1)
        motion = self._there(self._here(), self._here() + self.step / 4.0)
        begin = executor.now() + 2.0 * executor.latency
        odd = executor.splice(motion, begin)
        yield Rule(
            "it goes on from its position after a fault", odd or self._followed(motion, begin, self.duration)
        )

    def _followed(self, motion: Trajectory, begin: float, duration: float) -> str:
        executor, end = self.executor, begin + duration
        worst, which = 0.0, 0
        while executor.now() < end:
            self.wait(max(duration / SAMPLES, executor.period))
            state = executor.state()
            off = np.abs(state.positions - motion(state.stamp - begin)) - executor.tolerance
            if off.max() > worst:
                worst, which = float(off.max()), int(off.argmax())
        return f"{executor.joint_names[which]} exceeds it by {worst:.4f}" if worst > 0.0 else ""

    def _moving(self) -> str:
        speeds = np.abs(self.executor.state().velocities)
        fastest = int(speeds.argmax())
        name = self.executor.joint_names[fastest]
        return f"{name} moves at {speeds[fastest]:.4f}" if speeds[fastest] > SETTLED else ""

    def _here(self) -> Floats:
        return self.executor.state().commanded

    def _error(self) -> Floats:
        self.wait(self.executor.period)
        state = self.executor.state()
        return state.positions - state.commanded

    def _there(self, begin: Floats, end: Floats, *, duration: float | None = None) -> Trajectory:
        still = np.zeros((2, len(begin)))
        times = np.array((0.0, self.duration if duration is None else duration))
        return Trajectory(self.executor.joint_names, times, np.stack((begin, end)), still, still)


def _behind(errors: Floats, rates: Floats, still: Floats) -> float:
    """Return the largest delay of positions [s].

    A delay causes an error of velocity times delay: constant if states are late, uniform in a period if they
    show the last command; the largest value of a uniform distribution is the mean plus sqrt(3) standard
    deviations. Noise at rest is subtracted.
    """
    offset, power = still.mean(axis=0), float((rates**2).sum())
    off = errors - offset
    mean = float((off * rates).sum()) / power
    noise = float(((still - offset) ** 2).mean()) * off.size * (1.0 + 3.0 * (2.0 / still.size) ** 0.5)
    spread = max(float(((off - mean * rates) ** 2).sum()) - noise, 0.0) / power
    return abs(mean) + (3.0 * spread) ** 0.5


def _to_rest(motion: Trajectory, time: float) -> Trajectory:
    left = motion.duration - time
    here, speed, gain = (motion(time, order) for order in range(3))
    ends = (here + speed * left / 3.0, 0.0 * here, 0.0 * here)
    rows = [np.stack(both) for both in zip((here, speed, gain), ends, strict=True)]
    return Trajectory(motion.joint_names, np.array((0.0, left)), *rows)
