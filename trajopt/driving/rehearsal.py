"""Rehearsal: `run(problem)` plans and drives a problem in simulation among surprises, and measures it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Protocol, TypeVar

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.events import Event, EventKind
from trajopt.driving.executor import Executor
from trajopt.driving.motion_guard import MotionGuard, guard_within
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.simulated import TOLERANCE, SimulatedExecutor
from trajopt.driving.supervisor import Supervisor
from trajopt.driving.surprises import NONE, Surprises
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.simulation import ContactInterval
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

LONGEST = 60.0
"""Longest simulated time of a run [s]."""
SETTLING = 0.3
"""Time for which the robot is watched after its last motion [s]."""
DEFAULT = SupervisorOptions()
PERCENTILES = (("p50", 50.0), ("p99", 99.0), ("p99.9", 99.9), ("max", 100.0))


class Pilot(Protocol):
    """A driver of an executor, such as a `Supervisor`."""

    @property
    def events(self) -> Sequence[Event]:
        """Events, in order."""
        ...

    @property
    def seconds(self) -> Mapping[str, Sequence[float]]:
        """CPU times of each stage [s]."""
        ...

    @property
    def busy(self) -> bool:
        """Whether a goal is not reached."""
        ...

    @property
    def blocked(self) -> bool:
        """Whether the robot is at rest until the world changes."""
        ...

    def go(self, problem: Problem) -> None:
        """Go to a goal."""
        ...

    def see(self, scene: Scene, stamp: float | None = None) -> None:
        """Report the world; the clock of the scene shows 0 at the stamp [s]."""
        ...

    def cycle(self) -> None:
        """Execute one cycle."""
        ...


@dataclass(frozen=True, eq=False, kw_only=True)
class RunReport(Value):
    """The result of a run.

    Attributes:
        duration: Simulated time until the end of the last motion [s].
        contacts_at_fault: Those while the robot moved by itself, not when an object ran into it at rest.
        clearance_measured: Smallest distance of the simulated robot from the real obstacles until the end of
            the commanded motion [m].
        clearance_proven: Smallest proven distance for the commanded motion [m]; None if the robot did not
            follow it.
    """

    reached: bool
    duration: float
    contacts: tuple[ContactInterval, ...]
    contacts_at_fault: tuple[ContactInterval, ...]
    clearance_measured: float
    clearance_proven: float | None
    events: tuple[Event, ...]
    seconds: Mapping[str, tuple[float, ...]]
    measured: Trajectory

    def count(self, *kinds: EventKind) -> int:
        """Return the number of events of some kinds."""
        return sum(event.kind in kinds for event in self.events)

    def as_dict(self) -> dict[str, object]:
        """Return plain data; latencies are percentiles of the CPU time of each stage [s]."""
        return {
            "reached": self.reached,
            "duration": self.duration,
            "contacts": [str(contact) for contact in self.contacts],
            "contacts_at_fault": [str(contact) for contact in self.contacts_at_fault],
            "clearance_measured": _finite(self.clearance_measured),
            "clearance_proven": None if self.clearance_proven is None else _finite(self.clearance_proven),
            "stops": self.count(EventKind.STOPPING),
            "replans": self.count(EventKind.REPLANNED),
            "latencies": {
                stage: {name: float(np.percentile(times, share)) for name, share in PERCENTILES}
                for stage, times in self.seconds.items()
            },
            "missed_deadlines": self.count(EventKind.MISSED_DEADLINE),
            "events": [
                {"time": event.time, "kind": event.kind.value, "words": event.message}
                for event in self.events
            ],
        }


P = TypeVar("P", bound=Pilot)


class _KeepingMotions(SimulatedExecutor):
    """A simulated executor that keeps all commanded motions from the beginning."""

    commanded: CommittedMotion | None = None

    def splice(self, trajectory: Trajectory, at: float) -> str:
        self.commanded = self.commanded or CommittedMotion(self.joint_names, self.state().commanded)
        refused = super().splice(trajectory, at)
        if not refused:
            self.commanded.splice(trajectory, at, now=-np.inf)
        return refused


@checked
def run(
    problem: Problem,
    *,
    surprises: Surprises = NONE,
    options: SupervisorOptions = DEFAULT,
    longest: float = LONGEST,
    tolerance: float | Floats = TOLERANCE,
    watch: Callable[[Supervisor], object] | None = None,
) -> RunReport:
    """Plan a problem and drive it in simulation, as fast as possible; deterministic but for CPU times.

    Args:
        surprises: Unannounced changes, which the supervisor sees with the delay of the sensors.
        tolerance: As for `SimulatedExecutor`; use the tolerance of your driver to rehearse with its margin.
        watch: Called after each cycle: `logbook.look`, for a view or a recording.
    """
    return driven_by(
        lambda arm: Supervisor(arm, problem, options),
        problem,
        surprises=surprises,
        cycle=options.cycle,
        longest=longest,
        tolerance=tolerance,
        watch=watch,
    )


def driven_by(
    pilot: Callable[[Executor], P],
    problem: Problem,
    *,
    surprises: Surprises,
    cycle: float,
    longest: float = LONGEST,
    tolerance: float | Floats = TOLERANCE,
    watch: Callable[[P], object] | None = None,
) -> RunReport:
    """Drive a problem in simulation with any pilot, and measure the run; arguments as for `run`."""
    world = surprises.world(problem.scene)
    arm = _KeepingMotions(
        world,
        problem.start_positions,
        tolerance=tolerance,
        sensors=surprises.sensors,
        faults=surprises.faults,
    )
    driver = pilot(arm)
    driver.see(problem.scene, 0.0)
    driver.go(problem)
    names, samples = problem.reduced.joint_names, list[tuple[float, Floats, Floats]]()
    columns = [arm.joint_names.index(name) for name in names]
    changes, delay = list(surprises.times), surprises.sensors.delay
    steps = max(1, round(cycle / arm.period))

    def advance(count: int) -> None:
        for _ in range(count):
            truth = arm.truth()
            samples.append((truth.stamp, truth.positions[columns], truth.velocities[columns]))
            arm.advance(arm.period)

    while driver.busy and arm.now() < longest and (changes or not driver.blocked):
        while changes and changes[0] + delay <= arm.now():
            driver.see(surprises.seen(problem.scene, changes.pop(0)), 0.0)
        driver.cycle()
        if watch is not None:
            watch(driver)
        advance(steps)
    duration = arm.now()
    advance(round(SETTLING / arm.period))
    measured, guard = _trajectory(names, samples), guard_within(problem, arm.joint_names, arm.tolerance)
    commanded = None if arm.commanded is None or arm.fault() else arm.commanded.ahead(0.0, names)
    # After the robot has come to rest, moving obstacles may approach it; that is not proven.
    driven = measured
    if commanded is not None:
        driven = measured.between(0.0, min(commanded.duration, measured.duration))
    return RunReport(
        reached=bool(driver.events) and driver.events[-1].kind is EventKind.REACHED,
        duration=duration,
        contacts=tuple(contact for contact in arm.contacts if contact.allowance is None),
        contacts_at_fault=tuple(contact for contact in arm.contacts_at_fault if contact.allowance is None),
        clearance_measured=_clearance(MotionGuard(problem, {}), world, driven),
        clearance_proven=None if commanded is None else _clearance(guard, world, commanded),
        events=tuple(driver.events),
        seconds={stage: tuple(times) for stage, times in driver.seconds.items()},
        measured=measured,
    )


def _clearance(guard: MotionGuard, world: Scene, motion: Trajectory) -> float:
    return guard.certificate(motion, WorldSnapshot(world, 0.0), 0.0).clearance


def _trajectory(names: tuple[str, ...], samples: list[tuple[float, Floats, Floats]]) -> Trajectory:
    times, positions, velocities = zip(*samples, strict=True)
    return Trajectory(names, np.array(times), np.array(positions), np.array(velocities))


def _finite(number: float) -> float | None:
    """Return a number for JSON; None for infinity."""
    return number if isfinite(number) else None
