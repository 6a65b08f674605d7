"""A problem or a task planned, driven in simulation, and measured; and runs watched live."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import Protocol, TypeVar, overload

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
from trajopt.simulation import ContactInterval, PoseError, SimulationOptions
from trajopt.tasks.grasping.stages import PickObject, PlaceObject, SetGripper, hand_of
from trajopt.tasks.search import TaskStage, flat, held_objects
from trajopt.tasks.stages import AttachObject, DetachObject, MoveObject
from trajopt.tasks.task import Task
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.printed import in_degrees, in_length
from trajopt.values.trajectory import Trajectory

LONGEST = 60.0
"""Longest simulated time of a run [s]."""
SETTLING = 0.3
"""Time for which the robot is watched after its last motion [s]."""
TASK_TOLERANCE = 1e-3
"""Tolerance of the joints in tasks [rad | m]: the fingers push the arm a little."""
TASK_STEP = 1e-3
"""Time step of the simulation of tasks [s]: with longer ones objects creep in the hand."""
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
class Driven(Value):
    """The measurements of a run.

    Attributes:
        duration: Simulated time until the end of the last motion [s].
        contacts: Contacts that the scene does not allow.
        contacts_at_fault: Those while the robot moved by itself, not when an object ran into it at rest.
        measured: The motion of the group.
    """

    duration: float
    contacts: tuple[ContactInterval, ...]
    contacts_at_fault: tuple[ContactInterval, ...]
    events: tuple[Event, ...]
    seconds: Mapping[str, tuple[float, ...]]
    measured: Trajectory

    def count(self, *kinds: EventKind) -> int:
        return sum(event.kind in kinds for event in self.events)

    def as_dict(self) -> dict[str, object]:
        """Return plain data; latencies are percentiles of the CPU time of each stage [s]."""
        return {
            "duration": self.duration,
            "contacts": [str(contact) for contact in self.contacts],
            "contacts_at_fault": [str(contact) for contact in self.contacts_at_fault],
            "stops": self.count(EventKind.STOPPING),
            "replans": self.count(EventKind.REPLANNED),
            "latencies": {
                stage: {name: float(np.percentile(times, share)) for name, share in PERCENTILES}
                for stage, times in self.seconds.items()
            },
            "missed_deadlines": self.count(EventKind.MISSED_DEADLINE),
            "events": [event.as_dict() for event in self.events],
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class RunReport(Driven):
    """The result of a run to a goal.

    Attributes:
        clearance_measured: Smallest distance of the simulated robot from the real obstacles until the end of
            the commanded motion [m].
        clearance_proven: Smallest proven distance for the commanded motion [m]; None if the robot did not
            follow it.
    """

    reached: bool
    clearance_measured: float
    clearance_proven: float | None

    @property
    def succeeded(self) -> bool:
        """Whether the goal was reached without a contact at fault."""
        return self.reached and not self.contacts_at_fault

    def as_dict(self) -> dict[str, object]:
        return {
            "reached": self.reached,
            "clearance_measured": _finite(self.clearance_measured),
            "clearance_proven": None if self.clearance_proven is None else _finite(self.clearance_proven),
            **super().as_dict(),
        }

    def __str__(self) -> str:
        proven = self.clearance_proven
        known = "not proven" if proven is None else f"{in_length(proven)} proven"
        return (
            f"{'reached' if self.reached else 'did not reach'} the goal after {self.duration:.2f} s; "
            f"clearance {in_length(self.clearance_measured)}, {known}"
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class TaskReport(Driven):
    """The result of a driven task.

    Attributes:
        completed: Whether all stages are done, except skipped items.
        placements: Object that the gripper picks -> its real placement in the world at the end.
        errors: Object -> its deviation from the world of the supervisor at the end.
    """

    completed: bool
    placements: Mapping[str, Placement]
    errors: Mapping[str, PoseError]

    @property
    def succeeded(self) -> bool:
        """Whether the task was completed without a contact at fault."""
        return self.completed and not self.contacts_at_fault

    def as_dict(self) -> dict[str, object]:
        return {
            "completed": self.completed,
            "objects": {
                name: {
                    "position": where.translation.tolist(),
                    "quaternion": where.quaternion.tolist(),
                    "error": {"position": self.errors[name].position, "rotation": self.errors[name].rotation},
                }
                for name, where in self.placements.items()
            },
            **super().as_dict(),
        }

    def __str__(self) -> str:
        off = (
            f"; {name} is {in_length(each.position)} and {in_degrees(each.rotation)} from its planned place"
            for name, each in self.errors.items()
        )
        done = "completed" if self.completed else "did not complete"
        return f"{done} the task after {self.duration:.2f} s" + "".join(off)


P = TypeVar("P", bound=Pilot)


class _KeepingMotions(SimulatedExecutor):
    commanded: CommittedMotion | None = None

    def splice(self, trajectory: Trajectory, at: float) -> str:
        self.commanded = self.commanded or CommittedMotion(self.joint_names, self.state().commanded)
        refused = super().splice(trajectory, at)
        if not refused:
            self.commanded.splice(trajectory, at, now=-np.inf)
        return refused


@overload
def run(
    problem: Problem,
    *,
    surprises: Surprises = NONE,
    options: SupervisorOptions = DEFAULT,
    longest: float = LONGEST,
    tolerance: float | Floats | None = None,
    watch: Callable[[Supervisor], object] | None = None,
) -> RunReport: ...
@overload
def run(
    problem: Task,
    *,
    surprises: Surprises = NONE,
    options: SupervisorOptions = DEFAULT,
    longest: float = LONGEST,
    tolerance: float | Floats | None = None,
    watch: Callable[[Supervisor], object] | None = None,
) -> TaskReport: ...
@checked
def run(
    problem: Problem | Task,
    *,
    surprises: Surprises = NONE,
    options: SupervisorOptions = DEFAULT,
    longest: float = LONGEST,
    tolerance: float | Floats | None = None,
    watch: Callable[[Supervisor], object] | None = None,
) -> RunReport | TaskReport:
    """Plan a problem or a task, and drive it in simulation; deterministic but for CPU times.

    In a task only friction holds the objects that the gripper picks, and `MoveObject` moves the real object,
    too.

    Args:
        surprises: Unannounced changes, which the supervisor sees with the delay of the sensors.
        longest: Longest simulated time [s].
        tolerance: As for `SimulatedExecutor`; use the tolerance of your driver to rehearse with its margin.
            If None, 0.1 mrad or mm; 1 mrad or mm for tasks, as the fingers push the arm.
        watch: Called after each cycle: `logbook.look`, for a view or a recording.

    Raises:
        ProblemError: If a task attaches an object without a gripper, begins with one in the hand, or if a
            surprise moves an object that it handles.
        ModelError: If the robot, or an object that the gripper picks, has no mass.
    """
    if isinstance(problem, Task):
        allowed = TASK_TOLERANCE if tolerance is None else tolerance
        return _Cell(problem, surprises, options, allowed).driven(longest, watch)
    return driven_by(
        lambda arm: Supervisor(arm, problem, options),
        problem,
        surprises=surprises,
        cycle=options.cycle,
        longest=longest,
        tolerance=TOLERANCE if tolerance is None else tolerance,
        watch=watch,
    )


class _Cell:
    """The simulated cell of a task."""

    def __init__(
        self, task: Task, surprises: Surprises, options: SupervisorOptions, tolerance: float | Floats
    ) -> None:
        stages = tuple(flat(task.stages))
        hands = [each for each in stages if isinstance(each, SetGripper | PickObject | PlaceObject)]
        self._loose = tuple(dict.fromkeys(each.object for each in stages if isinstance(each, PickObject)))
        self._machine = tuple(dict.fromkeys(each.object for each in stages if isinstance(each, MoveObject)))
        _check_cell(task, stages, (*self._loose, *self._machine), surprises)
        self._task, self._surprises, self._cycle = task, surprises, options.cycle
        self._world = surprises.world(task.scene)
        self.arm = SimulatedExecutor(
            self._world,
            task.start_positions,
            tolerance=tolerance,
            sensors=surprises.sensors,
            faults=surprises.faults,
            options=SimulationOptions(dt=TASK_STEP),
            gripper=hand_of(task.scene, hands[0].gripper, task.group) if hands else None,
            loose=self._loose,
        )
        joints = task.scene.robot.index(task.scene.robot.group(task.group).joints)
        at_start = task.start_positions[joints]
        stands = Problem(scene=task.scene, group=task.group, start=task.start_positions, goal=at_start)
        self._names = stands.reduced.joint_names
        self._supervisor = Supervisor(self.arm, stands, options, self.arm.gripper)
        self._samples: list[tuple[float, Floats, Floats]] = []
        self._contacts: tuple[ContactInterval, ...] = ()
        self._at_fault: tuple[ContactInterval, ...] = ()

    def driven(self, longest: float, watch: Callable[[Supervisor], object] | None) -> TaskReport:
        arm, supervisor, surprises = self.arm, self._supervisor, self._surprises
        supervisor.see(self._task.scene, 0.0)
        supervisor.go(self._task)
        changes = list(surprises.times)
        while supervisor.busy and arm.now() < longest and (changes or not supervisor.blocked):
            while changes and changes[0] + surprises.sensors.delay <= arm.now():
                supervisor.see(self._seen(changes.pop(0)), 0.0)
            supervisor.cycle()
            self._follow_machine()
            if watch is not None:
                watch(supervisor)
            self._advance(self._cycle)
        duration = arm.now()
        self._advance(SETTLING)
        self._collect()
        places = {name: arm.placement_of(name) for name in self._loose}
        return TaskReport(
            completed=bool(supervisor.events) and supervisor.events[-1].kind is EventKind.COMPLETED,
            duration=duration,
            contacts=self._contacts,
            contacts_at_fault=self._at_fault,
            placements=places,
            errors={name: self._error(name, where) for name, where in places.items()},
            events=tuple(supervisor.events),
            seconds={stage: tuple(times) for stage, times in supervisor.seconds.items()},
            measured=_trajectory(self._names, self._samples),
        )

    def _advance(self, seconds: float) -> None:
        columns = [self.arm.joint_names.index(name) for name in self._names]
        for _ in range(max(1, round(seconds / self.arm.period))):
            truth = self.arm.truth()
            self._samples.append((truth.stamp, truth.positions[columns], truth.velocities[columns]))
            self.arm.advance(self.arm.period)

    def _seen(self, time: float) -> Scene:
        scene, model = self._task.scene, self._supervisor.scene
        for name in self._loose:
            scene = scene.move(name, self.arm.placement_of(name))
        for name in self._machine:
            scene = scene.move(name, model.holder(name).placement)
        return self._surprises.seen(scene, time)

    def _follow_machine(self) -> None:
        for name in self._machine:
            where = self._supervisor.scene.holder(name).placement
            if not np.array_equal(where.homogeneous, self._world.holder(name).placement.homogeneous):
                self._collect()
                self._world = self._world.move(name, where)
                self.arm.change(self._world, begin=0.0)

    def _collect(self) -> None:
        found = (self.arm.contacts, self.arm.contacts_at_fault)
        own, fault = (tuple(each for each in seen if each.allowance is None) for seen in found)
        self._contacts, self._at_fault = (*self._contacts, *own), (*self._at_fault, *fault)

    def _error(self, name: str, where: Placement) -> PoseError:
        scene, at = self._supervisor.scene, np.array(self._task.start_positions)
        at[scene.robot.index(self._names)] = self._samples[-1][1]
        return PoseError.between(scene.placement_of(name, scene.robot.followed(at)), where)


def _check_cell(
    task: Task, stages: Sequence[TaskStage], handled: Sequence[str], surprises: Surprises
) -> None:
    for stage in stages:
        if isinstance(stage, AttachObject | DetachObject):
            raise ProblemError(
                f"run: stage {shown(stage.name)}: the simulated robot has no suction cup; use PickObject and "
                "PlaceObject, or look at the plan with view"
            )
    for name in handled:
        if name in held_objects(task.scene):
            raise ProblemError(f"run: object {shown(name)} is in the hand at the start: begin with its pick")
        if name in {each.name for each in surprises.objects}:
            raise ProblemError(f"run: object {shown(name)} is handled by the task: no surprise can move it")


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
    return number if isfinite(number) else None


STOPPING = 5.0
"""Longest expected time of a stop [s]."""


class LiveRun:
    """A simulated robot on its way to a goal, in a world that is changed meanwhile."""

    def __init__(self, problem: Problem) -> None:
        self.arm = SimulatedExecutor(problem.scene, problem.start_positions)
        self.supervisor = Supervisor(self.arm, problem)
        self.supervisor.see(problem.scene, 0.0)
        self.supervisor.go(problem)
        self._touched: list[str] = []

    @property
    def touched(self) -> list[str]:
        """The contacts that the scene does not allow."""
        return [*self._touched, *(str(each) for each in self.arm.contacts if each.allowance is None)]

    def drive(
        self,
        stopped: Callable[[], bool],
        changed: Callable[[], Scene | None],
        look: Callable[[], object],
        *,
        patient: bool = False,
        longest: float = inf,
        speed: float = 1.0,
    ) -> bool:
        """Drive to the goal, or until a fault, a stop or a simulated time [s]; return whether it was stopped.

        Args:
            changed: Returns the world if it has changed since the last call, which is before each cycle.
            look: Called after each cycle.
            patient: Whether to wait for another world while the way is blocked.
            speed: Rate of simulated time: 1 for real time, 0 for as fast as possible, as a stop always is.
        """
        arm, supervisor, begin = self.arm, self.supervisor, time.monotonic()

        def cycle() -> None:
            scene = changed()
            if scene is not None:
                self._touched = self.touched
                arm.change(scene, begin=arm.now())
                supervisor.see(scene)
            supervisor.cycle()
            arm.advance(supervisor.options.cycle)
            look()
            if speed:
                time.sleep(max(begin + arm.now() / speed - time.monotonic(), 0.0))

        while supervisor.busy and not stopped() and not arm.fault() and arm.now() < longest:
            if supervisor.blocked and not patient:
                break
            cycle()
        if not stopped() and (arm.fault() or not supervisor.moving):
            return False
        supervisor.stop()
        until = arm.now() + STOPPING
        speed = 0.0  # who cancels a slowed run does not wait for a slowed stop
        while supervisor.moving and arm.now() < until:
            cycle()
        return True
