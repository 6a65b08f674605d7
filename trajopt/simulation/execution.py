"""Execution of trajectories in MuJoCo by a computed-torque controller."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol, TypeVar, overload, runtime_checkable

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import configuration
from trajopt.scene.planned_robot import Planned, model_and_trajectory
from trajopt.scene.reduced import ReducedModel, loaded_model
from trajopt.scene.reducing import whole_robot
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.simulation.rollout import (
    ContactLog,
    Friction,
    Phase,
    Rollout,
    SequenceLog,
    SimulationOptions,
    TrackingError,
)
from trajopt.values.arrays import Floats, readonly, unless_none
from trajopt.values.errors import ModelError, ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory

if TYPE_CHECKING:
    from trajopt.robot.loading.mujoco_library import mujoco
    from trajopt.simulation.plant import Plant

MOST_STEPS = 1_000_000
"""Most steps: about a minute and 0.5 GB."""


@dataclass(frozen=True, eq=False)
class Reference:
    """The reference of the controller at every step, shape (k,) and (k, n) each; at rest after the end."""

    times: Floats
    positions: Floats
    velocities: Floats
    accelerations: Floats

    def at(self, step: int) -> Floats:
        return np.stack((self.positions[step], self.velocities[step], self.accelerations[step]))


def reference(trajectory: Trajectory, dt: float, settling_time: float) -> Reference:
    if (trajectory.duration + settling_time) / dt > MOST_STEPS:
        raise ProblemError(
            f"{trajectory.duration + settling_time:g} s in steps of {dt:g} s are over {MOST_STEPS} steps; "
            "simulate a part (`Trajectory.between`), or use longer steps"
        )
    count = int(np.ceil((trajectory.duration + settling_time) / dt - 1e-9))
    times = dt * np.arange(count + 1, dtype=np.float64)
    moving = (times <= trajectory.duration)[:, None]
    return Reference(times, trajectory(times), moving * trajectory(times, 1), moving * trajectory(times, 2))


class ComputedTorque:
    """Computed-torque control: the tracking error e satisfies e'' + 2 z w e' + w^2 e = 0.

    The torque is rnea(q, q', q''_planned + 2 z w e' + w^2 e): a feed-forward along the trajectory, and gains
    w^2 M(q) and 2 z w M(q). Gains in proportion to the diagonal of M alone are unstable for arms such as the
    Panda.

    Source: Siciliano et al., Robotics, 2009, section 8.5.2.
    """

    def __init__(self, reduced: ReducedModel, options: SimulationOptions) -> None:
        self._reduced = reduced
        self._data = reduced.model.createData()
        self._stiffness = options.natural_frequency**2
        self._damping = 2.0 * options.damping_ratio * options.natural_frequency
        self._driven = [reduced.model.getJointId(name) - 1 for name in reduced.joint_names]

    def group(self, values: Floats) -> Floats:
        """Return the values of the group's joints."""
        return values[self._driven]

    def __call__(self, followed: Floats, positions: Floats, velocities: Floats) -> Floats:
        """Return the commanded torques, shape (n,) [Nm | N]."""
        reduced = self._reduced
        accelerations = (
            followed[2]
            + self._damping * (followed[1] - velocities[self._driven])
            + self._stiffness * (followed[0] - positions[self._driven])
        )
        q = configuration(reduced.model, positions)
        torques = pin.rnea(reduced.model, self._data, q, velocities, reduced.mimic_matrix @ accelerations)
        return reduced.mimic_matrix.T @ torques


def in_group_order(reduced: ReducedModel, trajectory: Trajectory) -> Trajectory:
    """Return a trajectory with its joints in the order of the group."""
    if set(trajectory.joint_names) != set(reduced.joint_names):
        raise ModelError(
            f"the trajectory moves {', '.join(trajectory.joint_names)}; "
            f"group {shown(reduced.group)} has {', '.join(reduced.joint_names)}"
        )
    return trajectory.ordered(reduced.joint_names)


BLOWN_UP = 1e4
"""Joint speed above which a simulation has diverged [rad/s | m/s]."""


@checked
def build_spec(reduced: ReducedModel) -> "mujoco.MjSpec":
    """Return the MuJoCo model of a reduced model.

    Joints keep their names. Each joint of the group has a motor of its name, with its effort limit; joints
    that mimic another are coupled by a stiff constraint. All pairs can collide except those that the scene
    allows. Joint friction and damping are omitted, as in the inverse dynamics of Pinocchio.
    """
    from trajopt.simulation.spec import describe

    return describe(reduced).spec


Rolled_co = TypeVar("Rolled_co", covariant=True)


@runtime_checkable
class SeveralMotions(Protocol[Rolled_co]):
    """The result of a task, or of a pick and place."""

    def simulated(self, options: SimulationOptions | None = None) -> Rolled_co:
        """Execute all motions."""
        ...


@overload
def simulate(motion: SeveralMotions[Rolled_co], *, options: SimulationOptions | None = None) -> Rolled_co: ...
@overload
def simulate(motion: Planned[ReducedModel], *, options: SimulationOptions | None = None) -> Rollout: ...
@overload
def simulate(
    motion: ReducedModel, trajectory: Trajectory, *, options: SimulationOptions | None = None
) -> Rollout: ...
def simulate(
    motion: SeveralMotions[Rolled_co] | Planned[ReducedModel] | ReducedModel,
    trajectory: Trajectory | None = None,
    *,
    options: SimulationOptions | None = None,
) -> Rollout | Rolled_co:
    """Execute a plan in MuJoCo, or any trajectory of a reduced model.

    The robot follows the trajectory under a computed-torque controller within the effort limits of the group,
    and holds the end for the settling time. The controller knows the masses exactly. Dynamic obstacles are
    exactly on their tracks and do not yield.

    If a joint moves no mass, the robot is placed on its plan at each time instead, with a note: contacts are
    found, torques are zero.

    Of a task, or of a pick and place, all motions are executed in one world, where only friction holds the
    objects that the gripper picks.

    Args:
        motion: A plan, or a result of one or several motions; or the reduced model of a trajectory. Joints
            outside the group are at rest.
        trajectory: Of the group's joints, in any order; the one of the plan if None.

    Raises:
        PlanningFailed: If the result has no plan.
        ProblemError: If there are more than a million steps.
        ModelError: If the joints of the trajectory differ from the group's.
    """
    from trajopt.simulation.plant import Plant  # importing MuJoCo takes a second

    if isinstance(motion, SeveralMotions):
        if trajectory is not None:
            raise ProblemError("simulate: the result of several motions has its own trajectory: leave it out")
        return motion.simulated(options)
    reduced, trajectory = model_and_trajectory("simulate", motion, trajectory, ReducedModel)
    options = unless_none("options", options, SimulationOptions) or SimulationOptions()
    trajectory = in_group_order(reduced, trajectory)
    plant = Plant(reduced, options.dt)
    followed = reference(trajectory, options.dt, options.settling_time)
    if plant.massless:
        return _played(plant, reduced, trajectory, followed, options)
    controller = ComputedTorque(replace(reduced, model=loaded_model(reduced)), options)
    plant.reset(followed.positions[0], followed.velocities[0])
    log = ContactLog(reduced.scene.allowances, trajectory.duration)
    last = len(followed.times) - 1
    stride = max(1, round(options.sample_period / options.dt))
    samples: list[tuple[float, Floats, Floats, Floats]] = []
    errors: list[Floats] = []
    limited = np.zeros(len(reduced.joint_names))
    diverged = None
    for step, t in enumerate(followed.times.tolist()):
        positions, velocities = plant.positions, plant.velocities
        if step > 0 and not (np.abs(velocities) < BLOWN_UP).all():
            diverged = t
            break
        commanded = controller(followed.at(step), positions, velocities)
        torques = np.clip(commanded, -reduced.limits.effort, reduced.limits.effort)
        if t <= trajectory.duration:
            errors.append(followed.positions[step] - controller.group(positions))
        if step % stride == 0 or step == last:
            samples.append((t, controller.group(positions), controller.group(velocities), torques))
        if step < last:
            limited += options.dt * (torques != commanded)
            log.record(t, plant.step(commanded))
    return Rollout(
        reduced,
        trajectory,
        *_columns(samples),
        _tracking(errors, len(limited)),
        log.contacts(),
        {name: float(s) for name, s in zip(reduced.joint_names, limited, strict=True) if s > 0.0},
        diverged,
        plant.notes,
    )


def _played(
    plant: "Plant",
    reduced: ReducedModel,
    trajectory: Trajectory,
    followed: Reference,
    options: SimulationOptions,
) -> Rollout:
    log = ContactLog(reduced.scene.allowances, trajectory.duration)
    plant.reset(followed.positions[0], followed.velocities[0])
    for t, positions, velocities in zip(
        followed.times.tolist(), followed.positions, followed.velocities, strict=True
    ):
        log.record(t, plant.show(t, positions, velocities))
    stride, last = max(1, round(options.sample_period / options.dt)), len(followed.times) - 1
    stored = sorted({*range(0, last, stride), last})
    exact = readonly(np.zeros(len(reduced.joint_names)))
    without = (
        f"the motion is played without dynamics, as joint {plant.massless} moves no mass; "
        "add <inertial> to the links beyond it to simulate torques and tracking"
    )
    return Rollout(
        reduced,
        trajectory,
        readonly(followed.times[stored]),
        readonly(followed.positions[stored]),
        readonly(followed.velocities[stored]),
        readonly(np.zeros((len(stored), len(exact)))),
        TrackingError(exact, exact),
        log.contacts(),
        {},
        None,
        (*plant.notes, without),
        dynamic=False,
    )


def _columns(
    samples: list[tuple[float, Floats, Floats, Floats]],
) -> tuple[Floats, Floats, Floats, Floats]:
    times, positions, velocities, torques = zip(*samples, strict=True)
    return (
        readonly(np.array(times)),
        readonly(np.array(positions)),
        readonly(np.array(velocities)),
        readonly(np.array(torques)),
    )


def _tracking(errors: list[Floats], joints: int) -> TrackingError:
    deviation = np.array(errors).reshape(-1, joints)
    return TrackingError(
        readonly(np.abs(deviation).max(axis=0)), readonly(np.sqrt((deviation**2).mean(axis=0)))
    )


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
    loose: Sequence[str],
    fingers: tuple[str, ...],
    driven_together: Mapping[str, tuple[str, float, float]],
    friction: Friction,
    options: SimulationOptions,
) -> SequenceLog:
    """Execute a sequence of motions in MuJoCo, with loose objects that only friction holds.

    The controller follows each phase as `simulate` does, with the payload of the scene of the phase.

    Args:
        fingers: Links with rubber pads.
        driven_together: Joint of the fingers -> the joint that it follows, with factor and offset, for joints
            of one drive that the description does not couple by a mimic.
        options: Step, gains, and settling time after the last phase.

    Raises:
        ModelError: If a loose object or the robot has no mass.
    """
    joints = tuple(dict.fromkeys(name for phase in phases for name in phase.reduced.joint_names))
    moving = {joint for phase in phases for joint in phase.presses}
    bare = scene
    for name in loose:
        bare = bare.remove(name)
    whole = whole_robot(bare, joints, start)
    plant = plant_with_gripper(
        whole,
        {scene.object(name): scene.placement_of(name, start) for name in loose},
        fingers=fingers,
        pressing=moving,
        driven_together=driven_together,
        friction=friction,
        dt=options.dt,
    )
    plant.require_masses()
    run = _Run(plant, whole, tuple(loose), moving, options)
    at = start
    for index, phase in enumerate(phases):
        last = index == len(phases) - 1
        at = run.follow(index, phase, at, options.settling_time if last else 0.0)
        if run.diverged is not None:
            break
    return run.log(whole_robot(scene, joints, start))


def plant_with_gripper(
    whole: ReducedModel,
    loose: Mapping[SceneObject, Placement],
    *,
    fingers: tuple[str, ...],
    pressing: Collection[str],
    driven_together: Mapping[str, tuple[str, float, float]],
    friction: Friction,
    dt: float,
) -> "Plant":
    """Return a plant whose robot holds loose objects by friction; arguments as for `simulate_phases`.

    Args:
        loose: Objects, which the scene of the model does not contain -> placements in the world.
        pressing: Joints of the fingers.
        dt: Time step [s].
    """
    from trajopt.simulation.plant import Plant
    from trajopt.simulation.spec import add_loose, couple, describe

    report = describe(whole)
    report.spec.option.timestep = dt
    for item, where in loose.items():
        report = add_loose(report, item, where, fingers=fingers, friction=friction)
    for joint in _with_followers(whole, pressing):
        report.spec.joint(joint).armature = FINGER_INERTIA
    for follower, (leader, factor, offset) in driven_together.items():
        couple(report.spec, follower, leader, factor, offset)
    for rule in report.spec.equalities if pressing else ():
        rule.solimp = np.array(COUPLING_IMPEDANCE)
    return Plant(whole, dt, report)


def with_finger_drives(reduced: ReducedModel, pressing: Collection[str]) -> ReducedModel:
    """Return a model with its payloads, and the inertia of the drives at the joints of the fingers."""
    model = loaded_model(reduced).copy()
    armature = np.array(model.armature)
    for joint in _with_followers(reduced, pressing):
        armature[model.joints[model.getJointId(joint)].idx_v] = FINGER_INERTIA
    model.armature = armature
    return replace(reduced, model=model)


class _Run:
    def __init__(
        self,
        plant: "Plant",
        whole: ReducedModel,
        loose: tuple[str, ...],
        pressing: set[str],
        options: SimulationOptions,
    ) -> None:
        self._plant, self._whole, self._loose, self._options = plant, whole, loose, options
        self._pressing = pressing
        self._contacts = ContactLog((), np.inf)
        self._samples: list[tuple[float, int, Floats]] = []
        self._placements: dict[str, list[Placement]] = {name: [] for name in loose}
        self._touching: dict[str, list[frozenset[str]]] = {name: [] for name in loose}
        self._limited = np.zeros(len(whole.joint_names))
        self._last_touching: Mapping[tuple[str, str], float] = {}
        self._deepest = 0.0
        model = whole.model
        self._driven = [model.getJointId(name) - 1 for name in whole.joint_names]
        self._steps = 0
        self.diverged: float | None = None
        plant.reset(whole.start_positions, np.zeros(len(whole.joint_names)))

    def follow(self, index: int, phase: Phase, at: Floats, settling: float) -> Floats:
        options, plant, whole = self._options, self._plant, self._whole
        trajectory = in_group_order(phase.reduced, phase.trajectory)
        followed = reference(trajectory, options.dt, phase.rest + settling)
        count = len(followed.times)
        resting = at[whole.scene.robot.index(whole.joint_names)]
        columns = [whole.joint_names.index(name) for name in trajectory.joint_names]
        positions = np.tile(resting, (count, 1))
        velocities, accelerations = np.zeros_like(positions), np.zeros_like(positions)
        positions[:, columns] = followed.positions
        velocities[:, columns] = followed.velocities
        accelerations[:, columns] = followed.accelerations
        aimed = Reference(followed.times, positions, velocities, accelerations)
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
            for name in self._loose:
                self._placements[name].append(plant.placement_of(name))
                touched = {each for pair in self._last_touching if name in pair for each in pair}
                self._touching[name].append(frozenset(touched - {name}))

    def _advance(self, torques: Floats) -> None:
        self._last_touching = touching = self._plant.step(torques)
        now, loose = self._steps * self._options.dt, frozenset(self._loose)
        self._limited += self._options.dt * (np.abs(torques) > self._whole.limits.effort)
        others = {pair: depth for pair, depth in touching.items() if loose.isdisjoint(pair)}
        own = (depth for pair, depth in touching.items() if pair not in others)
        self._deepest = max(self._deepest, *own, 0.0)
        self._contacts.record(now, others)
        self._steps += 1

    def log(self, reduced: ReducedModel) -> SequenceLog:
        times, phases, positions = zip(*self._samples, strict=True)
        return SequenceLog(
            reduced=reduced,
            loose=self._loose,
            times=readonly(np.array(times)),
            phases=np.array(phases, dtype=np.int64),
            positions=readonly(np.array(positions)),
            placements={name: tuple(each) for name, each in self._placements.items()},
            touching={name: tuple(each) for name, each in self._touching.items()},
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
        reduced = whole_robot(phase.reduced.scene, self._whole.joint_names, at)
        return with_finger_drives(reduced, self._pressing)


class _Press:
    def __init__(self, phase: Phase, joint_names: tuple[str, ...], dt: float) -> None:
        self._forces = np.array([phase.presses.get(name, 0.0) for name in joint_names])
        self._pressing = self._forces != 0.0
        self._grows = np.isin(joint_names, phase.trajectory.joint_names)
        self._since, self._rest = phase.trajectory.duration, max(phase.rest, dt)

    def __call__(self, t: float, torques: Floats) -> Floats:
        grown = min(max((t - self._since) / self._rest, 0.0), 1.0)
        share = np.where(self._grows, grown, 1.0)
        return np.where(self._pressing, (1.0 - share) * torques + share * self._forces, torques)


def _with_followers(reduced: ReducedModel, joints: Collection[str]) -> tuple[str, ...]:
    mimics = reduced.scene.robot.mimics
    return tuple(
        name
        for name in tuple(reduced.model.names[1:])
        if name in joints or (name in mimics and mimics[name].source in joints)
    )
