"""Several motions one after the other in one world, with an object that only friction holds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.arrays import Floats, Ints, readonly
from trajopt.errors import ModelError
from trajopt.model.groups import Group
from trajopt.model.payload import loaded_model
from trajopt.model.placement import Placement
from trajopt.model.reduced import ReducedModel, reduce_model
from trajopt.model.scene import Scene
from trajopt.model.trajectory import Trajectory
from trajopt.simulate.contacts import Contact, ContactLog
from trajopt.simulate.controller import ComputedTorque, Reference, in_group_order, reference
from trajopt.simulate.loose import Friction, add_loose
from trajopt.simulate.options import SimulationOptions
from trajopt.simulate.plant import Plant
from trajopt.simulate.spec import describe
from trajopt.simulate.stepping import BLOWN_UP
from trajopt.values import Value

WHOLE = "arm and fingers"
"""Name of the group that is simulated: the joints of all phases."""
FINGER_INERTIA = 0.1
"""Inertia of the fingers' drive, as each of their joints feels it [kg | kg m^2]; without any, the fingers
weigh so little that contact forces shake them."""
COUPLING_IMPEDANCE = (0.99, 0.999, 0.001, 0.5, 2.0)
"""How hard fingers that mimic each other are coupled (MuJoCo's `solimp`): with its default, they give way
by half a millimetre under 30 N."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Phase:
    """One motion in a sequence.

    Attributes:
        name: For reports.
        reduced: Its group, in a scene that knows whether the object is carried.
        trajectory: Of the group's joints.
        rest: How long its end is held [s].
        presses: Joint of the fingers -> force or torque that it gives in place of following [N | Nm]. Where
            it moves in this phase itself, that grows from nothing during the rest.
    """

    name: str
    reduced: ReducedModel
    trajectory: Trajectory
    rest: float
    presses: Mapping[str, float]

    @property
    def duration(self) -> float:
        """Of motion and rest [s]."""
        return self.trajectory.duration + self.rest


@dataclass(frozen=True, eq=False, kw_only=True)
class SequenceLog(Value):
    """What happened in a simulated sequence.

    Attributes:
        reduced: The joints of all phases, in the scene before.
        loose: The object.
        times: Of the stored samples, shape (k,) [s].
        phases: Index of the phase at each sample, shape (k,).
        positions: Of all joints of the robot, shape (k, joints) [rad | m].
        placements: Of the loose object in the world, one each.
        touching: What touched it, one set each.
        deepest: How deep it was in anything at most; contacts yield a little [m].
        contacts: Other contacts that the scene does not excuse.
        saturated: Joint -> time during which its motor was at its limit [s]; only those above zero.
        diverged: Time at which the simulation blew up and was stopped [s]; None if it did not.
        notes: Where MuJoCo's model differs from the robot's and the scene's.
    """

    reduced: ReducedModel
    loose: str
    times: Floats
    phases: Ints
    positions: Floats
    placements: tuple[Placement, ...]
    touching: tuple[frozenset[str], ...]
    deepest: float
    contacts: tuple[Contact, ...]
    saturated: Mapping[str, float]
    diverged: float | None
    notes: tuple[str, ...]


def simulate_phases(
    scene: Scene,
    start: Floats,
    phases: Sequence[Phase],
    *,
    loose: str,
    fingers: tuple[str, ...],
    friction: Friction,
    options: SimulationOptions,
) -> SequenceLog:
    """Execute motions one after the other in MuJoCo, in one world with a loose object.

    The controller follows each phase as `simulate` does and knows what its scene says is carried; whether
    it is, friction decides.

    Args:
        scene: The scene before, in which the object stands.
        start: Positions of all joints before [rad | m].
        phases: The motions.
        loose: The object.
        fingers: Links with rubber on them.
        friction: Of the object.
        options: Step, gains, settling time, which follows the last phase.

    Raises:
        ModelError: If the object has no mass, or the robot none.
    """
    joints = tuple(dict.fromkeys(name for phase in phases for name in phase.reduced.joint_names))
    whole = _whole(scene.remove(loose), joints, start)
    bare = describe(whole)
    bare.spec.option.timestep = options.dt
    report = add_loose(
        bare,
        scene.object(loose),
        scene.placement_of(loose, start),
        fingers=fingers,
        friction=friction,
    )
    moving = {joint for phase in phases for joint in phase.presses}
    for joint in _with_followers(whole, moving):
        report.spec.joint(joint).armature = FINGER_INERTIA
    for rule in report.spec.equalities:
        rule.solimp = np.array(COUPLING_IMPEDANCE)
    plant = Plant(whole, options.dt, report)
    run = _Run(plant, whole, loose, moving, options)
    at = start
    for index, phase in enumerate(phases):
        last = index == len(phases) - 1
        at = run.follow(index, phase, at, options.settling_time if last else 0.0)
        if run.diverged is not None:
            break
    return run.log(_whole(scene, joints, start))


class _Run:
    """A running simulation and what it has stored."""

    def __init__(
        self,
        plant: Plant,
        whole: ReducedModel,
        loose: str,
        pressing: set[str],
        options: SimulationOptions,
    ) -> None:
        self._plant, self._whole, self._loose, self._options = plant, whole, loose, options
        self._pressing = pressing
        self._contacts = ContactLog((), np.inf)
        self._samples: list[tuple[float, int, Floats]] = []
        self._placements: list[Placement] = []
        self._touching: list[frozenset[str]] = []
        self._limited = np.zeros(len(whole.joint_names))
        self._last_touching = frozenset[str]()
        self._deepest = 0.0
        model = whole.model
        self._driven = [model.getJointId(name) - 1 for name in whole.joint_names]
        self._steps = 0
        self.diverged: float | None = None
        plant.reset(whole.start_positions, np.zeros(len(whole.joint_names)))

    def follow(self, index: int, phase: Phase, at: Floats, settling: float) -> Floats:
        """Follow a phase from planned positions of all joints; return those at its end."""
        options, plant, whole = self._options, self._plant, self._whole
        trajectory = in_group_order(phase.reduced, phase.trajectory)
        followed = reference(trajectory, options.dt, phase.rest + settling)
        aimed = _aimed(whole, followed, trajectory.joint_names, at)
        controller = ComputedTorque(self._known(phase, at), aimed, options)
        press = _Press(phase, whole.joint_names, options.dt)
        for step, t in enumerate(followed.times.tolist()[:-1]):
            if not (np.abs(plant.velocities) < BLOWN_UP).all():
                self.diverged = self._steps * options.dt
                break
            self._store(index)
            asked = controller(step, plant.positions, plant.velocities)
            self._advance(press(t, asked))
        return phase.reduced.all_positions(trajectory(trajectory.duration))

    def _store(self, phase: int) -> None:
        """Store the state at the sample period."""
        options, plant = self._options, self._plant
        if self._steps % max(1, round(options.sample_period / options.dt)) == 0:
            positions = self._whole.all_positions(plant.positions[self._driven])
            self._samples.append((self._steps * options.dt, phase, positions))
            self._placements.append(plant.placement_of(self._loose))
            self._touching.append(self._last_touching)

    def _advance(self, asked: Floats) -> None:
        """Make a step, and note what touched in it."""
        touching = self._plant.step(asked)
        now, loose = self._steps * self._options.dt, self._loose
        self._limited += self._options.dt * (np.abs(asked) > self._whole.limits.effort)
        own = {pair: depth for pair, depth in touching.items() if loose in pair}
        self._last_touching = frozenset(name for pair in own for name in pair if name != loose)
        self._deepest = max(self._deepest, *own.values(), 0.0)
        self._contacts.record(now, {pair: depth for pair, depth in touching.items() if loose not in pair})
        self._steps += 1

    def log(self, reduced: ReducedModel) -> SequenceLog:
        """Return what was stored, with the joints and the scene that it is told of."""
        times, phases, positions = zip(*self._samples, strict=True)
        return SequenceLog(
            reduced=reduced,
            loose=self._loose,
            times=readonly(np.array(times)),
            phases=np.array(phases, dtype=np.int64),
            positions=readonly(np.array(positions)),
            placements=tuple(self._placements),
            touching=tuple(self._touching),
            deepest=self._deepest,
            contacts=self._contacts.contacts(),
            saturated={
                name: float(seconds)
                for name, seconds in zip(self._whole.joint_names, self._limited, strict=True)
                if seconds > 0.0
            },
            diverged=self.diverged,
            notes=self._plant.notes,
        )

    def _known(self, phase: Phase, at: Floats) -> ReducedModel:
        """Return the model that the controller knows: with what the phase's scene says is carried."""
        reduced = _whole(phase.reduced.scene, self._whole.joint_names, at)
        model = loaded_model(reduced).copy()
        armature = np.array(model.armature)
        for joint in _with_followers(reduced, self._pressing):
            armature[model.joints[model.getJointId(joint)].idx_v] = FINGER_INERTIA
        model.armature = armature
        return replace(reduced, model=model)


class _Press:
    """Forces that fingers give in place of following."""

    def __init__(self, phase: Phase, joint_names: tuple[str, ...], dt: float) -> None:
        self._forces = np.array([phase.presses.get(name, 0.0) for name in joint_names])
        self._pressing = self._forces != 0.0
        self._grows = bool(set(phase.presses) & set(phase.trajectory.joint_names))
        self._since, self._rest = phase.trajectory.duration, max(phase.rest, dt)

    def __call__(self, t: float, asked: Floats) -> Floats:
        """Return what the motors are asked for at a time of the phase, given what following asks for."""
        share = min(max((t - self._since) / self._rest, 0.0), 1.0) if self._grows else 1.0
        return np.where(self._pressing, (1.0 - share) * asked + share * self._forces, asked)


def _whole(scene: Scene, joints: tuple[str, ...], start: Floats) -> ReducedModel:
    """Return the reduced model of the joints of all phases."""
    robot = scene.robot
    if WHOLE in robot.groups:
        raise ModelError(f"group {WHOLE!r} of robot {robot.name!r} stands in the way; rename it")
    group = Group(WHOLE, joints, robot.links, None)
    wider = replace(robot, groups={**robot.groups, WHOLE: group})
    return reduce_model(replace(scene, robot=wider), WHOLE, start)


def _aimed(whole: ReducedModel, followed: Reference, moved: tuple[str, ...], at: Floats) -> Reference:
    """Return a reference of all simulated joints: those not moved stand where they are planned to be."""
    count = len(followed.times)
    standing = at[whole.scene.robot.index(whole.joint_names)]
    columns = [whole.joint_names.index(name) for name in moved]
    positions = np.tile(standing, (count, 1))
    velocities, accelerations = np.zeros_like(positions), np.zeros_like(positions)
    positions[:, columns] = followed.positions
    velocities[:, columns] = followed.velocities
    accelerations[:, columns] = followed.accelerations
    return Reference(followed.times, positions, velocities, accelerations)


def _with_followers(reduced: ReducedModel, joints: set[str]) -> tuple[str, ...]:
    """Return joints and those that mimic them, as far as the model has them."""
    mimics = reduced.scene.robot.mimics
    return tuple(
        name
        for name in tuple(reduced.model.names[1:])
        if name in joints or (name in mimics and mimics[name].source in joints)
    )
