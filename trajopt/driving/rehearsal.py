"""run(problem): a problem planned, driven in the simulated world among surprises, and measured."""

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
from trajopt.simulation import Contact
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

LONGEST = 60.0
"""A run ends after so much simulated time, whatever happens [s]."""
SETTLING = 0.3
"""How long the robot is watched after it has nothing to do any more [s]."""
DEFAULT = SupervisorOptions()
PERCENTILES = (("p50", 50.0), ("p99", 99.0), ("p99.9", 99.9), ("max", 100.0))


class Pilot(Protocol):
    """Tells an executor what to drive: a `Supervisor`, or something that is compared with it."""

    @property
    def events(self) -> Sequence[Event]:
        """What happened, in order."""
        ...

    @property
    def seconds(self) -> Mapping[str, Sequence[float]]:
        """CPU time that each stage took, each time [s]."""
        ...

    @property
    def busy(self) -> bool:
        """Whether there is a goal that is not reached."""
        ...

    @property
    def blocked(self) -> bool:
        """Whether the robot stands, and nothing but a change of the world lets it go on."""
        ...

    def go(self, problem: Problem) -> None:
        """Ask for a goal."""
        ...

    def see(self, scene: Scene, stamp: float | None = None) -> None:
        """Tell it what the world is like; the scene's clock shows 0 at the stamp [s]."""
        ...

    def cycle(self) -> None:
        """Do what is to be done now."""
        ...


@dataclass(frozen=True, eq=False, kw_only=True)
class RunReport(Value):
    """What happened in a run.

    Attributes:
        reached: Whether the goal was.
        duration: Simulated time until the robot had nothing to do any more [s].
        contacts: What was touched that may not be.
        contacts_at_fault: What of that was touched while the robot moved of its own: not what pushed it where
            it had come to rest.
        clearance_measured: Smallest distance that the simulated robot had to what was really there, until
            what was commanded was over [m].
        clearance_proven: The same that is proven for what was commanded [m]; None where the robot did not
            follow it.
        events: What happened, in order.
        seconds: CPU time that each stage took, each time [s].
        measured: How the robot moved, of the group's joints.
    """

    reached: bool
    duration: float
    contacts: tuple[Contact, ...]
    contacts_at_fault: tuple[Contact, ...]
    clearance_measured: float
    clearance_proven: float | None
    events: tuple[Event, ...]
    seconds: Mapping[str, tuple[float, ...]]
    measured: Trajectory

    def count(self, *kinds: EventKind) -> int:
        """Return how many events there are of some kinds."""
        return sum(event.kind in kinds for event in self.events)

    def as_dict(self) -> dict[str, object]:
        """Return it as plain data; latencies are CPU time of each stage [s]."""
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
                {"time": event.time, "kind": event.kind.value, "words": event.words} for event in self.events
            ],
        }


P = TypeVar("P", bound=Pilot)


class _Remembering(SimulatedExecutor):
    """A simulated executor that remembers everything it was given to do, from the begin."""

    given: CommittedMotion | None = None

    def splice(self, trajectory: Trajectory, at: float) -> str:
        self.given = self.given or CommittedMotion(self.joint_names, self.state().commanded)
        refused = super().splice(trajectory, at)
        if not refused:
            self.given.splice(trajectory, at, now=-np.inf)
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
    """Plan a problem and drive it in the simulated world, as fast as the machine goes.

    What happens is the same every time, but for the CPU time that it takes.

    Args:
        problem: The problem; its scene is what is known of the world before.
        surprises: What nobody said before; the supervisor sees it as late as the sensors are.
        options: Of the supervisor.
        longest: Most simulated time [s].
        tolerance: As of `SimulatedExecutor`; that of your driver, to rehearse with the room that it takes.
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
    """Let anything drive a problem in the simulated world, and measure it as `run` does.

    Args:
        pilot: Makes what drives, given the executor.
        problem: The problem; its scene is what is known of the world before.
        surprises: What nobody said before.
        cycle: Time from one cycle to the next [s].
        longest: Most simulated time [s].
        tolerance: As of `SimulatedExecutor`.
        watch: Called after each cycle.
    """
    world = surprises.world(problem.scene)
    arm = _Remembering(
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
    given = None if arm.given is None or arm.fault() else arm.given.ahead(0.0, names)
    # What moves goes on after the robot has come to rest, of which nothing was proven.
    driven = measured if given is None else measured.between(0.0, min(given.duration, measured.duration))
    return RunReport(
        reached=bool(driver.events) and driver.events[-1].kind is EventKind.REACHED,
        duration=duration,
        contacts=tuple(contact for contact in arm.contacts if contact.allowance is None),
        contacts_at_fault=tuple(contact for contact in arm.contacts_at_fault if contact.allowance is None),
        clearance_measured=_clearance(MotionGuard(problem, 0.0), world, driven),
        clearance_proven=None if given is None else _clearance(guard, world, given),
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
    """Return what JSON can say: nothing for no limit."""
    return number if isfinite(number) else None
