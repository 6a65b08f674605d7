"""Execution of a trajectory in MuJoCo by a computed-torque controller."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, overload

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import configuration
from trajopt.scene.payload import loaded_model
from trajopt.scene.planned_robot import Planned, model_and_trajectory
from trajopt.scene.reduced import ReducedModel
from trajopt.simulation.options import SimulationOptions
from trajopt.simulation.rollout import ContactLog, Rollout, TrackingError
from trajopt.values.arrays import Floats, readonly, unless_none
from trajopt.values.errors import ModelError, ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

if TYPE_CHECKING:
    from trajopt.robot.loading.mujoco_library import mujoco
    from trajopt.simulation.plant import Plant

MOST_STEPS = 1_000_000
"""Largest number of steps: about a minute and 0.5 GB."""


@dataclass(frozen=True, eq=False)
class Reference:
    """The reference of the controller at every step.

    Attributes:
        times: Shape (k,) [s].
        positions: Of the group, shape (k, n) [rad | m].
        velocities: Shape (k, n) [rad/s | m/s]; zero after the end.
        accelerations: Shape (k, n) [rad/s^2 | m/s^2]; zero after the end.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    accelerations: Floats

    def at(self, step: int) -> Floats:
        """Return positions, velocities and accelerations at one step, shape (3, n)."""
        return np.stack((self.positions[step], self.velocities[step], self.accelerations[step]))


def reference(trajectory: Trajectory, dt: float, settling_time: float) -> Reference:
    """Sample a trajectory, and the hold at its end.

    Args:
        trajectory: Of the group's joints, in their order.
        dt: Time step [s].
        settling_time: Time for which the end is held [s].

    Raises:
        ProblemError: If there are more than a million steps.
    """
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
    w^2 M(q) and 2 z w M(q). Gains in proportion to the diagonal of M alone are unstable for arms whose last
    joints move little inertia, such as the Panda.

    Source: Siciliano et al., Robotics, 2009, section 8.5.2.
    """

    def __init__(self, reduced: ReducedModel, options: SimulationOptions) -> None:
        """Prepare the controller.

        Args:
            reduced: The reduced model; the controller uses its dynamics.
            options: Natural frequency and damping ratio.
        """
        self._reduced = reduced
        self._data = reduced.model.createData()
        self._stiffness = options.natural_frequency**2
        self._damping = 2.0 * options.damping_ratio * options.natural_frequency
        self._driven = [reduced.model.getJointId(name) - 1 for name in reduced.joint_names]

    def group(self, values: Floats) -> Floats:
        """Return the values of the group's joints."""
        return values[self._driven]

    def __call__(self, followed: Floats, positions: Floats, velocities: Floats) -> Floats:
        """Return the commanded torques, shape (n,) [Nm | N].

        Args:
            followed: Reference positions, velocities and accelerations of the group, shape (3, n).
            positions: Of all joints of the model [rad | m].
            velocities: Of all joints of the model [rad/s | m/s].
        """
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
    """Return a trajectory with its joints in the order of the group.

    Raises:
        ModelError: If its joints differ from those of the group.
    """
    if trajectory.joint_names == reduced.joint_names:
        return trajectory
    if set(trajectory.joint_names) != set(reduced.joint_names):
        raise ModelError(
            f"the trajectory moves {', '.join(trajectory.joint_names)}; "
            f"group {shown(reduced.group)} has {', '.join(reduced.joint_names)}"
        )
    order = [trajectory.joint_names.index(name) for name in reduced.joint_names]
    velocities, accelerations = trajectory.velocities, trajectory.accelerations
    return Trajectory(
        reduced.joint_names,
        trajectory.times,
        trajectory.positions[:, order],
        None if velocities is None else velocities[:, order],
        None if accelerations is None else accelerations[:, order],
    )


BLOWN_UP = 1e4
"""Joint speed above which a simulation has diverged [rad/s | m/s]."""


@checked
def build_spec(reduced: ReducedModel) -> "mujoco.MjSpec":
    """Return the MuJoCo model of a reduced model.

    Joints keep their names. Each joint of the group has a motor of its name, with its effort limit; joints
    that mimic another are coupled by a stiff constraint. All pairs can collide except those that the scene
    allows. Joint friction and damping are omitted, as in the inverse dynamics of Pinocchio.

    Raises:
        ModelError: If a shape cannot be built.
    """
    from trajopt.simulation.spec import describe

    return describe(reduced).spec


@overload
def simulate(motion: Planned[ReducedModel], *, options: SimulationOptions | None = None) -> Rollout: ...
@overload
def simulate(
    motion: ReducedModel, trajectory: Trajectory, *, options: SimulationOptions | None = None
) -> Rollout: ...
def simulate(
    motion: Planned[ReducedModel] | ReducedModel,
    trajectory: Trajectory | None = None,
    *,
    options: SimulationOptions | None = None,
) -> Rollout:
    """Execute a plan in MuJoCo, or any trajectory of a reduced model.

    The robot starts in the first position and velocity of the trajectory, follows it under a computed-torque
    controller within the effort limits of the group, and holds the end for the settling time. The controller
    knows the masses of robot and attached objects exactly, so errors are due to torque limits, contacts or
    jumps of the trajectory. Dynamic obstacles are present at their times, exactly on their tracks, and do not
    yield.

    If a joint moves no mass, as the description has no inertias, the robot is placed on its plan at each time
    instead: contacts are found, torques are zero, and a note reports it.

    Args:
        motion: A plan, or a result with a plan; or the reduced model (robot and scene) of a trajectory.
            Joints outside the group are at rest.
        trajectory: Of the group's joints, in any order; the one of the plan if None.
        options: Step, gains, settling time.

    Raises:
        PlanningFailed: If the result has no plan.
        ProblemError: If there are more than a million steps.
        ModelError: If the joints of the trajectory differ from those of the group.
    """
    from trajopt.simulation.plant import Plant  # importing MuJoCo takes a second

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
    """Place the robot on a trajectory at each time, without dynamics."""
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
