"""Execution of a sequence of motions in MuJoCo, with an object that is held by friction only."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from trajopt.scene.payload import loaded_model
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.scene.whole_robot import whole_robot
from trajopt.simulation.execution import BLOWN_UP, ComputedTorque, Reference, in_group_order, reference
from trajopt.simulation.options import Friction, SimulationOptions
from trajopt.simulation.rollout import ContactLog, Phase, SequenceLog
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement

if TYPE_CHECKING:
    from trajopt.simulation.plant import Plant

FINGER_INERTIA = 0.1
"""Inertia of the drive at each finger joint [kg | kg m^2]; without it contacts shake the fingers."""
COUPLING_IMPEDANCE = (0.99, 0.999, 0.001, 0.5, 2.0)
"""Stiffness of the coupling of fingers that mimic each other (`solimp` of MuJoCo); with the default they
yield by half a millimetre under 30 N."""


@checked
def simulate_phases(
    scene: Scene,
    start: Floats,
    phases: Sequence[Phase],
    *,
    loose: str,
    fingers: tuple[str, ...],
    driven_together: Mapping[str, tuple[str, float, float]],
    friction: Friction,
    options: SimulationOptions,
) -> SequenceLog:
    """Execute a sequence of motions in MuJoCo, with a loose object.

    The controller follows each phase as `simulate` does, with the payload of the scene of the phase; whether
    the object is really held depends on friction only.

    Args:
        scene: The initial scene, with the object.
        start: Initial positions of all joints [rad | m].
        phases: The motions.
        loose: Name of the object.
        fingers: Links with rubber pads.
        driven_together: Joint of the fingers -> the joint that it follows, with factor and offset, for joints
            of one drive that the description does not couple by a mimic.
        friction: Of the object.
        options: Step, gains, and settling time after the last phase.

    Raises:
        ModelError: If the object or the robot has no mass.
    """
    from trajopt.simulation.plant import Plant
    from trajopt.simulation.spec import add_loose, couple, describe

    joints = tuple(dict.fromkeys(name for phase in phases for name in phase.reduced.joint_names))
    whole = whole_robot(scene.remove(loose), joints, start)
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
    for follower, (leader, factor, offset) in driven_together.items():
        couple(report.spec, follower, leader, factor, offset)
    for rule in report.spec.equalities:
        rule.solimp = np.array(COUPLING_IMPEDANCE)
    plant = Plant(whole, options.dt, report)
    plant.require_masses()
    run = _Run(plant, whole, loose, moving, options)
    at = start
    for index, phase in enumerate(phases):
        last = index == len(phases) - 1
        at = run.follow(index, phase, at, options.settling_time if last else 0.0)
        if run.diverged is not None:
            break
    return run.log(whole_robot(scene, joints, start))


class _Run:
    """A running simulation and its stored samples."""

    def __init__(
        self,
        plant: "Plant",
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
        """Follow a phase from planned positions of all joints; return the planned positions at its end."""
        options, plant, whole = self._options, self._plant, self._whole
        trajectory = in_group_order(phase.reduced, phase.trajectory)
        followed = reference(trajectory, options.dt, phase.rest + settling)
        aimed = _aimed(whole, followed, trajectory.joint_names, at)
        controller = ComputedTorque(self._known(phase, at), options)
        press = _Press(phase, whole.joint_names, options.dt)
        for step, t in enumerate(followed.times.tolist()[:-1]):
            if not (np.abs(plant.velocities) < BLOWN_UP).all():
                self.diverged = self._steps * options.dt
                break
            self._store(index)
            torques = controller(aimed.at(step), plant.positions, plant.velocities)
            self._advance(press(t, torques))
        return phase.reduced.all_positions(trajectory(trajectory.duration))

    def _store(self, phase: int) -> None:
        options, plant = self._options, self._plant
        if self._steps % max(1, round(options.sample_period / options.dt)) == 0:
            positions = self._whole.all_positions(plant.positions[self._driven])
            self._samples.append((self._steps * options.dt, phase, positions))
            self._placements.append(plant.placement_of(self._loose))
            self._touching.append(self._last_touching)

    def _advance(self, torques: Floats) -> None:
        touching = self._plant.step(torques)
        now, loose = self._steps * self._options.dt, self._loose
        self._limited += self._options.dt * (np.abs(torques) > self._whole.limits.effort)
        own = {pair: depth for pair, depth in touching.items() if loose in pair}
        self._last_touching = frozenset(name for pair in own for name in pair if name != loose)
        self._deepest = max(self._deepest, *own.values(), 0.0)
        self._contacts.record(now, {pair: depth for pair, depth in touching.items() if loose not in pair})
        self._steps += 1

    def log(self, reduced: ReducedModel) -> SequenceLog:
        """Return the stored samples, for joints and scene of a reduced model."""
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
        """Return the model of the controller, with the payload of the phase."""
        reduced = whole_robot(phase.reduced.scene, self._whole.joint_names, at)
        model = loaded_model(reduced).copy()
        armature = np.array(model.armature)
        for joint in _with_followers(reduced, self._pressing):
            armature[model.joints[model.getJointId(joint)].idx_v] = FINGER_INERTIA
        model.armature = armature
        return replace(reduced, model=model)


class _Press:
    """Forces of fingers in place of position control."""

    def __init__(self, phase: Phase, joint_names: tuple[str, ...], dt: float) -> None:
        self._forces = np.array([phase.presses.get(name, 0.0) for name in joint_names])
        self._pressing = self._forces != 0.0
        self._grows = bool(set(phase.presses) & set(phase.trajectory.joint_names))
        self._since, self._rest = phase.trajectory.duration, max(phase.rest, dt)

    def __call__(self, t: float, torques: Floats) -> Floats:
        """Return the motor commands at a time of the phase, given those of the controller."""
        share = min(max((t - self._since) / self._rest, 0.0), 1.0) if self._grows else 1.0
        return np.where(self._pressing, (1.0 - share) * torques + share * self._forces, torques)


def _aimed(whole: ReducedModel, followed: Reference, moved: tuple[str, ...], at: Floats) -> Reference:
    """Return a reference of all simulated joints; other joints stay at their planned positions."""
    count = len(followed.times)
    resting = at[whole.scene.robot.index(whole.joint_names)]
    columns = [whole.joint_names.index(name) for name in moved]
    positions = np.tile(resting, (count, 1))
    velocities, accelerations = np.zeros_like(positions), np.zeros_like(positions)
    positions[:, columns] = followed.positions
    velocities[:, columns] = followed.velocities
    accelerations[:, columns] = followed.accelerations
    return Reference(followed.times, positions, velocities, accelerations)


def _with_followers(reduced: ReducedModel, joints: set[str]) -> tuple[str, ...]:
    """Return joints of the model and those that mimic them."""
    mimics = reduced.scene.robot.mimics
    return tuple(
        name
        for name in tuple(reduced.model.names[1:])
        if name in joints or (name in mimics and mimics[name].source in joints)
    )
