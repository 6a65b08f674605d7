"""Executor of a robot in MuJoCo, its gripper, noisy sensors and faults."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from math import inf

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.executor import STOPPED, GripperState, RobotState
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import driven_joints, whole_robot
from trajopt.scene.scene import Scene
from trajopt.simulation import ContactInterval, Friction, SimulationOptions
from trajopt.simulation.execution import BLOWN_UP, ComputedTorque, plant_with_gripper, with_finger_drives
from trajopt.simulation.rollout import ContactLog
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.values.arrays import Floats, Value, floats, number
from trajopt.values.errors import JointNotFound, NameNotFound, ProblemError, shown
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory


class FaultKind(Enum):
    """Kinds of faults."""

    DRIFT = "drift"
    """A joint is driven to an offset position."""
    STUCK = "stuck"
    """A joint does not move."""
    LOST_COMMANDS = "lost commands"
    """Motions are accepted, but not driven."""


@checked
@dataclass(frozen=True, kw_only=True)
class Fault(Value):
    """A fault of a simulated robot during an interval.

    Attributes:
        begin: Of the interval [s].
        joint: The joint; empty for lost commands.
        size: Offset of a drift [rad | m].
    """

    kind: FaultKind
    begin: float
    end: float
    joint: str = ""
    size: float = 0.0

    def __post_init__(self) -> None:
        if not number("begin", self.begin) < number("end", self.end):
            raise ProblemError(
                f"a fault must end after it begins; begin {self.begin:g} s, end {self.end:g} s"
            )
        if bool(self.joint) == (self.kind is FaultKind.LOST_COMMANDS):
            raise ProblemError(
                "lost commands concern all joints; leave out joint="
                if self.joint
                else f"a fault of kind {self.kind.value!r} needs a joint; pass joint="
            )

    @checked
    def at(self, time: float) -> bool:
        """Return whether it is present at a time [s]."""
        return self.begin <= time < self.end


BRAKE = 0.9
"""Factor on the commanded velocity in each time step of `stop`, within the torque limits of the motors."""
MOVING = 1e-3
"""Joint speed below which a robot is at rest [rad/s | m/s]; an object that then runs into it is at fault,
also while it pushes the robot."""

TOLERANCE = 1e-4
"""Stated tracking tolerance of a simulated joint [rad | m]; it follows to within a millionth."""
DEVIATIONS = 6.0
"""Bound of normal noise in standard deviations, which one sample in 500 million exceeds."""


@checked
@dataclass(frozen=True, kw_only=True)
class Sensors(Value):
    """Delay and noise of the measured states of a robot.

    Attributes:
        delay: Of states [s].
        noise: Standard deviation of each measured position [rad | m].
        stated: Bound of the measurement error, included in the tolerance of the driver [rad | m];
            `DEVIATIONS` times the noise if None.
    """

    delay: float = 0.0
    noise: float = 0.0
    stated: float | None = None
    seed: int = 0

    @property
    def error(self) -> float:
        """Stated bound of the measurement error [rad | m]."""
        return DEVIATIONS * self.noise if self.stated is None else self.stated


EXACT = Sensors()
RUBBER = Friction()


CLOSING_SPEED = 0.1
"""Speed at which the opening of a simulated gripper changes [m/s]."""
BLOCKED = 2e-3
"""Fingers farther than this behind their motion press on something [m]."""
PRESSING_TIME = 0.3
"""Time in which the force of the fingers builds up [s]."""
ABOUT = 5e-3
"""Largest difference of the opening from the width of a held object [m]."""


class SimulatedGripper:
    """The gripper of a `SimulatedExecutor`, which holds objects by friction only."""

    def __init__(self, description: Gripper, opening: float, dt: float) -> None:
        self.description = description
        self._opening = self._reference = self._target = opening
        self._dt, self._width, self._force, self._pressed = dt, 0.0, 0.0, 0.0

    @checked
    def move(self, opening: float) -> None:
        self.description.joints_at(opening)
        self._force, self._pressed, self._target, self._reference = 0.0, 0.0, opening, self._opening

    @checked
    def grasp(self, width: float, force: float) -> None:
        self.move(self.description.narrowest)
        self._width, self._force = width, force

    def state(self) -> GripperState:
        if self._force == 0.0:
            return GripperState(self._opening, self._reference != self._target, holding=False)
        pressed = self._pressed >= PRESSING_TIME
        return GripperState(self._opening, not pressed, pressed and abs(self._opening - self._width) <= ABOUT)

    def advance(self, opening: float) -> None:
        """Move the reference by one time step; `opening` is the measured one [m]."""
        self._opening = opening
        stopped = opening - self._reference > BLOCKED or self._reference == self._target
        if self._pressed > 0.0 or (self._force > 0.0 and stopped):
            self._pressed += self._dt
        else:
            step = CLOSING_SPEED * self._dt
            self._reference += float(np.clip(self._target - self._reference, -step, step))

    @property
    def positions(self) -> Mapping[str, float]:
        """Joint -> reference position [rad | m]."""
        return self.description.joints_at(self._reference)

    def torques(self, tracking: Mapping[str, float]) -> Mapping[str, float]:
        """Return joint -> effort, from those that track the reference to those that press [Nm | N]."""
        if self._pressed == 0.0:
            return tracking
        share = min(self._pressed / PRESSING_TIME, 1.0)
        presses = self.description.pressing(self._opening, self._force)
        return {name: (1.0 - share) * tracking[name] + share * effort for name, effort in presses.items()}


@checked_class
class SimulatedExecutor:
    """Drives a robot in MuJoCo, in a world that may differ from the one that a planner knows.

    Without a clock, `advance` simulates as fast as the machine allows. With one, every call simulates up to
    its time. A robot with a joint that moves no mass is placed on its motion at each time, without dynamics.

    Attributes:
        joint_names: Driven joints: all that do not mimic another, without a gripper's.
        dynamic: Whether motors move the robot.
        gripper: Driver of the gripper; None without one.
    """

    def __init__(
        self,
        world: Scene,
        positions: Floats,
        *,
        latency: float = 5e-3,
        tolerance: float | Floats = TOLERANCE,
        sensors: Sensors = EXACT,
        faults: Sequence[Fault] = (),
        options: SimulationOptions | None = None,
        clock: Callable[[], float] | None = None,
        gripper: Gripper | None = None,
        loose: Sequence[str] = (),
        friction: Friction = RUBBER,
    ) -> None:
        """Begin at rest.

        Args:
            world: The real world; its clock is the executor's.
            positions: Of all joints, shape (number of joints,) [rad | m]; a joint that starts outside its
                limits is held there.
            tolerance: Largest tracking error of each joint, one number for all or shape (n,) [rad | m]; the
                error of the sensors is added.
            gripper: A gripper driven by `gripper` of the executor; a step of a millisecond
                (`SimulationOptions(dt=1e-3)`) keeps objects from creeping.
            loose: Objects moved by contact and friction only.
            friction: Of these objects.

        Raises:
            ModelError: If a loose object has no mass, or a robot with a gripper or loose objects has none.
            ObjectNotFound: If a loose object does not exist.
            JointNotFound: If a fault names a joint not driven.
        """
        robot, options = world.robot, options or SimulationOptions()
        self._all = driven_joints(robot)
        fingers = () if gripper is None else gripper.joint_names
        self.joint_names = tuple(name for name in self._all if name not in fingers)
        self._arm = [self._all.index(name) for name in self.joint_names]
        self.gripper: SimulatedGripper | None = None
        if gripper is not None:
            self.gripper = SimulatedGripper(gripper, gripper.opening_at(robot, positions), options.dt)
        self._loose, self._friction, self._payload = frozenset(loose), friction, ""
        self.period, self.latency = options.dt, latency
        count = len(self.joint_names)
        allowed = np.full(count, tolerance) if isinstance(tolerance, float | int) else tolerance
        self.tolerance: Floats = floats("tolerance", allowed, (count,)) + sensors.error
        for fault in faults:
            if fault.joint and fault.joint not in self.joint_names:
                raise JointNotFound("joint that is driven", fault.joint, self.joint_names)
        begin = positions[robot.index(self.joint_names)]
        self.committed = CommittedMotion(self.joint_names, begin)
        self._others, self._options = robot.followed(positions), options
        at = positions[robot.index(self._all)]
        places = {world.object(name).name: world.placement_of(name, positions) for name in loose}
        self._build(world, at, np.zeros(len(at)), places)
        self._sensors, self._rng = sensors, np.random.default_rng(sensors.seed)
        self._faults = tuple(faults)
        self._clock, self._origin = clock, 0.0 if clock is None else clock()
        self._steps, self._fault, self._pushed = 0, "", False
        self._reference = (-1, np.zeros((3, len(begin))))
        self._braked: Floats | None = None
        self._before = begin
        self._count(0.0, np.inf)
        self._measured: deque[RobotState] = deque(maxlen=round(sensors.delay / options.dt) + 1)
        self._measure()

    def now(self) -> float:
        self._catch_up()
        return self._steps * self.period if self._clock is None else self._clock() - self._origin

    def advance(self, seconds: float) -> None:
        """Simulate for a time [s]."""
        for _ in range(round(seconds / self.period)):
            self._step()

    def state(self) -> RobotState:
        self._catch_up()
        return self._measured[0]

    def truth(self) -> RobotState:
        """Return the real state, without delay and noise."""
        now, plant = self._steps * self.period, self._plant
        commanded, _, accelerations = self._commanded()
        positions, rates = (
            self._controller.group(each)[self._arm] for each in (plant.positions, plant.velocities)
        )
        return RobotState(now, positions, rates, accelerations, commanded)

    def placement_of(self, name: str) -> Placement:
        """Return the real placement of a loose object in the world.

        Raises:
            NameNotFound: If it is not loose.
        """
        self._catch_up()
        if name not in self._loose:
            raise NameNotFound("loose object", name, sorted(self._loose))
        return self._plant.placement_of(name)

    def splice(self, trajectory: Trajectory, at: float) -> str:
        now = self.now()
        if self._fault:
            return self._fault
        refused = self.committed.refusal(trajectory, at, earliest=now + self.latency)
        lost = any(fault.at(now) for fault in self._faults if fault.kind is FaultKind.LOST_COMMANDS)
        if not refused and not lost:
            self.committed.splice(trajectory, at, now=now)
        return refused

    def stop(self) -> None:
        self._catch_up()
        if self._braked is None:  # otherwise it brakes already, or is at rest
            self._braked = self.committed(self._steps * self.period)[:2]
        self._fault = self._fault or STOPPED

    def fault(self) -> str:
        self._catch_up()
        return self._fault

    def clear_fault(self) -> None:
        self._catch_up()
        self._braked, self._fault = None, ""
        self._reference = (-1, self._reference[1])
        self._before = self._controller.group(self._plant.positions)[self._arm]
        self.committed = CommittedMotion(self.joint_names, self._before)
        self._measured.clear()
        self._measure()

    def change(self, world: Scene, *, begin: float, duration: float = inf) -> None:
        """Replace the real world, whose clock shows 0 at `begin` [s]; contacts are counted from then on.

        Loose objects stay. Contact allowances refer to the ends of a motion of this duration [s].
        """
        self._catch_up()
        if world.robot.joint_names != self._world.robot.joint_names:
            raise ProblemError(f"the robot is {shown(self._world.robot.name)}, not {shown(world.robot.name)}")
        plant, group = self._plant, self._controller.group
        if world is not self._world:
            places = {name: plant.placement_of(name) for name in self._loose}
            self._build(world, group(plant.positions), group(plant.velocities), places)
            self._payload = ""  # the new controller does not know it yet
        self._count(begin, duration)

    @property
    def contacts(self) -> tuple[ContactInterval, ...]:
        """Contacts in this world, on its clock."""
        return self._log.contacts()

    @property
    def contacts_at_fault(self) -> tuple[ContactInterval, ...]:
        """Contacts while the robot moved by itself, except with objects that ran into it at rest."""
        return self._at_fault.contacts()

    @property
    def saturated(self) -> tuple[str, ...]:
        """Joints whose motor reached its limit in this world."""
        return tuple(name for name, cut in zip(self._all, self._saturated.tolist(), strict=True) if cut)

    def _build(
        self, world: Scene, positions: Floats, velocities: Floats, places: Mapping[str, Placement]
    ) -> None:
        hand = None if self.gripper is None else self.gripper.description
        loose = {world.object(name): where for name, where in places.items()}
        self._world, bare = world, world
        for name in places:
            bare = bare.remove(name)
        at = self._whole_positions(positions)
        whole = whole_robot(bare, self._all, at)
        self._plant = plant_with_gripper(
            whole,
            loose,
            fingers=() if hand is None else hand.fingers,
            pressing=() if hand is None else hand.joint_names,
            driven_together={} if hand is None else hand.driven_together(world.robot, at),
            friction=self._friction,
            dt=self._options.dt,
        )
        self.dynamic = not self._plant.massless
        if hand is not None or loose:
            self._plant.require_masses()
        self._control(whole)
        self._plant.reset(positions, velocities)
        self._effort = whole.limits.effort

    def _control(self, known: ReducedModel) -> None:
        fingers = () if self.gripper is None else self.gripper.description.joint_names
        self._controller = ComputedTorque(with_finger_drives(known, fingers), self._options)

    def _measured_positions(self) -> Floats:
        return self._whole_positions(self._controller.group(self._plant.positions))

    def _whole_positions(self, positions: Floats) -> Floats:
        robot, at = self._world.robot, np.array(self._others)
        at[robot.index(self._all)] = positions
        return robot.followed(at)

    def _count(self, begin: float, duration: float) -> None:
        allowances = self._world.allowances
        self._begin = begin
        self._plant.data.time = self._steps * self.period - begin
        self._log, self._at_fault = ContactLog(allowances, duration), ContactLog(allowances, duration)
        self._saturated = np.zeros(len(self._all), dtype=np.bool_)

    def _catch_up(self) -> None:
        if self._clock is not None:
            behind = self._clock() - self._origin - self._steps * self.period
            self.advance(max(behind, 0.0))

    def _step(self) -> None:
        now, plant = self._steps * self.period, self._plant
        if not (np.abs(plant.velocities) < BLOWN_UP).all():
            self._fault = "the simulation has diverged"
            self._steps += 1
            return
        followed = self._followed(now)
        for fault in self._faults:
            if fault.kind is FaultKind.STUCK:
                plant.hold(fault.joint, held=fault.at(now))
        rates = self._controller.group(plant.velocities)[self._arm]
        contacts = self._driven(followed) if self.dynamic else self._placed(followed, now)
        self._weigh(contacts)
        touching = {pair: depth for pair, depth in contacts.items() if self._loose.isdisjoint(pair)}
        self._log.record(now - self._begin, touching)
        if self._moves_itself(followed, rates, touching):
            self._at_fault.record(now - self._begin, touching)
        self._steps += 1
        self._measure()

    def _driven(self, followed: Floats) -> Mapping[tuple[str, str], float]:
        torques = self._torques(followed)
        self._saturated |= np.abs(torques) > self._effort
        return self._plant.step(torques)

    def _placed(self, followed: Floats, now: float) -> Mapping[tuple[str, str], float]:
        rates = followed[1] + self.period * followed[2]
        positions = followed[0] + self.period * rates
        for fault in self._faults:
            if fault.kind is FaultKind.STUCK and fault.at(now):
                joint = self.joint_names.index(fault.joint)
                positions[joint], rates[joint] = self._controller.group(self._plant.positions)[joint], 0.0
        return self._plant.show(now + self.period - self._begin, positions, rates)

    def _torques(self, followed: Floats) -> Floats:
        plant, gripper = self._plant, self.gripper
        if gripper is None:
            return self._controller(followed, plant.positions, plant.velocities)
        robot, fingers = self._world.robot, gripper.description.joint_names
        before = gripper.positions
        gripper.advance(gripper.description.opening_at(robot, self._measured_positions()))
        aimed = np.zeros((3, len(self._all)))
        aimed[:, self._arm] = followed
        columns = [self._all.index(name) for name in fingers]
        aimed[0, columns] = [before[name] for name in fingers]
        aimed[1, columns] = [(gripper.positions[name] - before[name]) / self.period for name in fingers]
        torques = self._controller(aimed, plant.positions, plant.velocities)
        tracking = dict(zip(fingers, torques[columns].tolist(), strict=True))
        torques[columns] = list(gripper.torques(tracking).values())
        return torques

    def _weigh(self, contacts: Mapping[tuple[str, str], float]) -> None:
        """Give the controller the mass of the object in the gripper, as a payload."""
        gripper = self.gripper
        if gripper is None or gripper.state().holding == bool(self._payload):
            return
        fingers = set(gripper.description.fingers)
        touched = [other for pair in contacts for other in pair if other in self._loose and fingers & {*pair}]
        held = touched[0] if gripper.state().holding and touched else ""
        at, scene, tool = self._measured_positions(), self._world, gripper.description.tool
        for name in self._loose - {held}:
            scene = scene.remove(name)
        if held:
            moved = scene.move(held, self._plant.placement_of(held))
            scene = moved.attach(held, tool, at=at, touch_links=gripper.description.links)
        self._payload = held
        self._control(whole_robot(scene, self._all, at))

    def _moves_itself(
        self, followed: Floats, rates: Floats, touching: Mapping[tuple[str, str], float]
    ) -> bool:
        if np.abs(followed[1]).max() > MOVING:
            self._pushed = False
            return True
        if np.abs(rates).max() > MOVING:
            return not self._pushed
        # Objects with allowed contact hold the robot or are held; they do not push it.
        allowed = [allowance.pair for allowance in self._world.allowances]
        self._pushed = any(frozenset(pair) not in allowed for pair in touching)
        return False

    def _commanded(self) -> Floats:
        if self._reference[0] != self._steps:
            self._reference = (self._steps, self.committed(self._steps * self.period))
        return self._reference[1]

    def _followed(self, now: float) -> Floats:
        if self._braked is not None:
            positions, rates = self._braked
            rates = BRAKE * rates
            self._braked = np.stack((positions + self.period * rates, rates))
            return np.stack((*self._braked, np.zeros(len(rates))))
        # MuJoCo moves joints by their velocity at the end of a step, so the reference consists of differences
        # of positions from step to step, not of instantaneous velocities.
        here, after = self._commanded()[0], self.committed(now + self.period)[0]
        rates = (here - self._before) / self.period
        self._before = here
        followed = np.stack((here, rates, ((after - here) / self.period - rates) / self.period))
        for fault in self._faults:
            if fault.kind is FaultKind.DRIFT and fault.at(now):
                followed[0, self.joint_names.index(fault.joint)] += fault.size
        return followed

    def _measure(self) -> None:
        true = self.truth()
        noise = self._sensors.noise * self._rng.standard_normal(len(true.positions))
        self._measured.append(replace(true, positions=true.positions + noise))
