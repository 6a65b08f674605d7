"""Executor of a robot that MuJoCo simulates step by step, with delayed and noisy sensors and with faults."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from math import inf

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.executor import STOPPED, RobotState
from trajopt.scene.payload import loaded_model
from trajopt.scene.scene import Scene
from trajopt.scene.whole_robot import driven_joints, whole_robot
from trajopt.simulation import Contact, SimulationOptions
from trajopt.simulation.execution import BLOWN_UP, ComputedTorque
from trajopt.simulation.rollout import ContactLog
from trajopt.values.arrays import Floats, Value, floats, number
from trajopt.values.errors import JointNotFound, ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory


class FaultKind(Enum):
    """Kinds of faults."""

    DRIFT = "drift"
    """A joint is driven to a place that is off by so much [rad | m]."""
    STUCK = "stuck"
    """A joint does not move any more."""
    LOST_COMMANDS = "lost commands"
    """What is spliced in is acknowledged, but never driven."""


@checked
@dataclass(frozen=True, kw_only=True)
class Fault(Value):
    """Something that goes wrong for a while.

    Attributes:
        kind: What.
        begin: From when on [s].
        end: Until when [s].
        joint: Which joint; of lost commands, none.
        size: By how much it drifts [rad | m].
    """

    kind: FaultKind
    begin: float
    end: float
    joint: str = ""
    size: float = 0.0

    def __post_init__(self) -> None:
        """Check that it lasts, and whether it names a joint.

        Raises:
            ProblemError: If it does not last, or names no joint, or one that it has no use for.
        """
        if not number("begin", self.begin) < number("end", self.end):
            raise ProblemError(f"a fault ends after it begins: {self.begin:g} s, {self.end:g} s")
        if bool(self.joint) == (self.kind is FaultKind.LOST_COMMANDS):
            raise ProblemError(
                "lost commands are of all joints"
                if self.joint
                else f"{self.kind.value} is of a joint: name it"
            )

    @checked
    def at(self, time: float) -> bool:
        """Say whether it is there at a time [s]."""
        return self.begin <= time < self.end


BRAKE = 0.9
"""What a stop at once takes off the velocity to follow, each time step: the motors do what they can."""
MOVING = 1e-3
"""A robot no joint of which is faster is at rest: who touches it then is at fault himself, also while he
pushes it away [rad/s | m/s]."""

TOLERANCE = 1e-4
"""How far a simulated joint may be from where it has to be [rad | m]; it follows to within a millionth."""
DEVIATIONS = 6.0
"""Of normal noise one sample in 500 million is farther off than so many standard deviations: months of one
joint that is measured 50 times a second."""


@checked
@dataclass(frozen=True, kw_only=True)
class Sensors(Value):
    """What is measured of a robot.

    Attributes:
        delay: A state is known so long after it was so [s].
        noise: Standard deviation of each measured position [rad | m].
        stated: What is measured is said to be off by at most so much [rad | m]: a driver tells it in its
            tolerance. `DEVIATIONS` of them unless it is given.
        seed: Draws the noise: the same every time.
    """

    delay: float = 0.0
    noise: float = 0.0
    stated: float | None = None
    seed: int = 0

    @property
    def error(self) -> float:
        """How far what is measured is said to be off at most [rad | m]."""
        return DEVIATIONS * self.noise if self.stated is None else self.stated


EXACT = Sensors()


class SimulatedExecutor:
    """Drives a robot in MuJoCo, in a world that may differ from what a planner is told of it.

    Without a clock time passes when it is told to (`advance`), as fast as the machine goes. With one, the
    physics catches up with it whenever the robot is asked for something.

    Attributes:
        joint_names: Joints that it drives: all that do not follow another.
        period: Time step of the physics and of the controller [s].
        latency: A motion given now can begin so much later [s].
        tolerance: How far each joint may be measured from where it has to be, shape (n,) [rad | m].
        committed: What it has to do.
    """

    @checked
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
    ) -> None:
        """Put the robot somewhere.

        Args:
            world: What is really there; its clock is the executor's.
            positions: Of all joints, shape (number of joints,) [rad | m]; a joint that starts outside its
                limits is held there.
            latency: A motion given now can begin so much later [s].
            tolerance: How far each joint may be from where it has to be, one number for all or shape (n,)
                [rad | m]; what is measured may be farther, by the error of the sensors.
            sensors: What is measured.
            faults: What goes wrong, and when.
            options: Time step and gains.
            clock: Tells the time [s].

        Raises:
            ModelError: If the robot has no masses.
            JointNotFound: If a fault names a joint that is not driven.
        """
        robot, options = world.robot, options or SimulationOptions()
        self.joint_names = driven_joints(robot)
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
        self._build(world, begin, np.zeros(len(begin)))
        self._sensors, self._rng = sensors, np.random.default_rng(sensors.seed)
        self._faults = tuple(faults)
        self._clock, self._origin = clock, 0.0 if clock is None else clock()
        self._steps, self._fault, self._pushed = 0, "", False
        self._asked = (-1, np.zeros((3, len(begin))))
        self._braked: Floats | None = None
        self._before = begin
        self._count(0.0, np.inf)
        self._measured: deque[RobotState] = deque(maxlen=round(sensors.delay / options.dt) + 1)
        self._measure()

    def now(self) -> float:
        """Return the time on its clock [s]."""
        self._catch_up()
        return self._steps * self.period if self._clock is None else self._clock() - self._origin

    @checked
    def advance(self, seconds: float) -> None:
        """Let time pass: simulate so long [s]."""
        for _ in range(round(seconds / self.period)):
            self._step()

    def state(self) -> RobotState:
        """Return the state that is measured last."""
        self._catch_up()
        return self._measured[0]

    def truth(self) -> RobotState:
        """Return the state as it really is, now and without noise."""
        now, plant = self._steps * self.period, self._plant
        commanded, _, accelerations = self._commanded()
        places, rates = (self._controller.group(each) for each in (plant.positions, plant.velocities))
        return RobotState(now, places.copy(), rates.copy(), accelerations, commanded)

    @checked
    def splice(self, trajectory: Trajectory, at: float) -> str:
        """Drive a motion from a time on; say why not."""
        now = self.now()
        if self._fault:
            return self._fault
        refused = self.committed.refusal(trajectory, at, earliest=now + self.latency)
        lost = any(fault.at(now) for fault in self._faults if fault.kind is FaultKind.LOST_COMMANDS)
        if not refused and not lost:
            self.committed.splice(trajectory, at, now=now)
        return refused

    def stop(self) -> None:
        """Brake all motors as hard as they can."""
        self._catch_up()
        if self._braked is None:  # else it brakes already, or stands
            self._braked = self.committed(self._steps * self.period)[:2]
        self._fault = self._fault or STOPPED

    def fault(self) -> str:
        """Say why the robot does not follow."""
        self._catch_up()
        return self._fault

    def clear_fault(self) -> None:
        """Go on where the robot stands now."""
        self._catch_up()
        self._braked, self._fault = None, ""
        self._asked = (-1, self._asked[1])
        self._before = self._controller.group(self._plant.positions).copy()
        self.committed = CommittedMotion(self.joint_names, self._before)
        self._measured.clear()
        self._measure()

    @checked
    def change(self, world: Scene, *, begin: float, duration: float = inf) -> None:
        """Put the robot, as it is, into another world; contacts are counted anew.

        Args:
            world: What is really there from now on, with what the robot carries.
            begin: When the world's clock shows 0, on the executor's [s].
            duration: Of the motion that begins then: allowances of contact count from both its ends [s].

        Raises:
            ProblemError: If it is a world of another robot.
        """
        self._catch_up()
        if world.robot.joint_names != self._world.robot.joint_names:
            raise ProblemError(f"the robot is {shown(self._world.robot.name)}, not {shown(world.robot.name)}")
        plant, group = self._plant, self._controller.group
        if world is not self._world:
            self._build(world, group(plant.positions), group(plant.velocities))
        self._count(begin, duration)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """All contacts in this world, by its clock."""
        return self._log.contacts()

    @property
    def contacts_at_fault(self) -> tuple[Contact, ...]:
        """Contacts in this world while the robot moved, but for what pushed it where it had come to rest."""
        return self._at_fault.contacts()

    @property
    def saturated(self) -> tuple[str, ...]:
        """Joints whose motor was at its limit in this world."""
        return tuple(
            name for name, cut in zip(self.joint_names, self._saturated.tolist(), strict=True) if cut
        )

    def _build(self, world: Scene, positions: Floats, velocities: Floats) -> None:
        """Build a world with the robot in it."""
        from trajopt.simulation.plant import Plant  # MuJoCo takes a second to import

        robot, at = world.robot, np.array(self._others)
        at[robot.index(self.joint_names)] = positions
        whole = whole_robot(world, self.joint_names, robot.followed(at))
        self._world, self._plant = world, Plant(whole, self._options.dt)
        self._plant.require_masses()
        self._controller = ComputedTorque(replace(whole, model=loaded_model(whole)), self._options)
        self._plant.reset(positions, velocities)
        self._effort = whole.limits.effort

    def _count(self, begin: float, duration: float) -> None:
        """Count contacts from now on, by a clock that shows 0 at the begin."""
        allowances = self._world.allowances
        self._begin = begin
        self._plant.data.time = self._steps * self.period - begin
        self._log, self._at_fault = ContactLog(allowances, duration), ContactLog(allowances, duration)
        self._saturated = np.zeros(len(self.joint_names), dtype=np.bool_)

    def _catch_up(self) -> None:
        if self._clock is not None:
            behind = self._clock() - self._origin - self._steps * self.period
            self.advance(max(behind, 0.0))

    def _step(self) -> None:
        """Simulate one time step."""
        now, plant = self._steps * self.period, self._plant
        if not (np.abs(plant.velocities) < BLOWN_UP).all():
            self._fault = "the simulation has diverged"
            self._steps += 1
            return
        followed = self._followed(now)
        for fault in self._faults:
            if fault.kind is FaultKind.STUCK:
                plant.hold(fault.joint, held=fault.at(now))
        torques = self._controller(followed, plant.positions, plant.velocities)
        self._saturated |= np.abs(torques) > self._effort
        rates = self._controller.group(plant.velocities).copy()
        touching = plant.step(torques)
        self._log.record(now - self._begin, touching)
        if self._moves_itself(followed, rates, touching):
            self._at_fault.record(now - self._begin, touching)
        self._steps += 1
        self._measure()

    def _moves_itself(
        self, followed: Floats, rates: Floats, touching: Mapping[tuple[str, str], float]
    ) -> bool:
        """Say whether the robot moves, and not only because it was run into where it stood."""
        if np.abs(followed[1]).max() > MOVING:
            self._pushed = False
            return True
        if np.abs(rates).max() > MOVING:
            return not self._pushed
        # What may touch the robot holds it, or is held: it does not push it away.
        allowed = [allowance.pair for allowance in self._world.allowances]
        self._pushed = any(frozenset(pair) not in allowed for pair in touching)
        return False

    def _commanded(self) -> Floats:
        """Return where the joints have to be now, shape (3, n): what is spliced in begins later."""
        if self._asked[0] != self._steps:
            self._asked = (self._steps, self.committed(self._steps * self.period))
        return self._asked[1]

    def _followed(self, now: float) -> Floats:
        """Return where the motors drive the joints to, shape (3, n)."""
        if self._braked is not None:
            places, rates = self._braked
            rates = BRAKE * rates
            self._braked = np.stack((places + self.period * rates, rates))
            return np.stack((*self._braked, np.zeros(len(rates))))
        # MuJoCo moves joints by their velocity at the end of a step, so it follows exactly the differences of
        # the places from step to step, not the rates at the instants.
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
