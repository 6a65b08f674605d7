"""Execution of a trajectory in MuJoCo by a computed-torque controller."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, overload

import numpy as np
import pinocchio as pin

from trajopt.robot.loading.pinocchio_model import configuration
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
"""Most steps of one simulation: they take about a minute and 0.5 GB."""


@dataclass(frozen=True, eq=False)
class Reference:
    """The reference to follow, at every step.

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
    """Sample a trajectory and the rest after it.

    Args:
        trajectory: Of the group's joints, in its order.
        dt: Time step [s].
        settling_time: How long the end is held [s].

    Raises:
        ProblemError: If that takes more than a million steps.
    """
    if (trajectory.duration + settling_time) / dt > MOST_STEPS:
        raise ProblemError(
            f"to simulate {trajectory.duration + settling_time:g} s in steps of {dt:g} s takes more than "
            f"{MOST_STEPS} steps: simulate a part (`Trajectory.between`), or take longer steps"
        )
    count = int(np.ceil((trajectory.duration + settling_time) / dt - 1e-9))
    times = dt * np.arange(count + 1, dtype=np.float64)
    moving = (times <= trajectory.duration)[:, None]
    return Reference(times, trajectory(times), moving * trajectory(times, 1), moving * trajectory(times, 2))


class ComputedTorque:
    """Torques that make the tracking error e a damped oscillator: e'' + 2 z w e' + w^2 e = 0.

    The torque is rnea(q, q', q''_planned + 2 z w e' + w^2 e): the feed-forward along the trajectory
    plus proportional and derivative gains w^2 M(q) and 2 z w M(q). Gains in proportion to the
    diagonal of M alone are unstable on arms whose last joints move little inertia (the Panda's).

    Source: Siciliano et al., Robotics, 2009, section 8.5.2.
    """

    def __init__(self, reduced: ReducedModel, options: SimulationOptions) -> None:
        """Prepare the controller.

        Args:
            reduced: The reduced model; its own dynamics are what the controller knows.
            options: Natural frequency and damping ratio.
        """
        self._reduced = reduced
        self._data = reduced.model.createData()
        self._stiffness = options.natural_frequency**2
        self._damping = 2.0 * options.damping_ratio * options.natural_frequency
        self._driven = [reduced.model.getJointId(name) - 1 for name in reduced.joint_names]

    def group(self, values: Floats) -> Floats:
        """Take the group's joints from the model's."""
        return values[self._driven]

    def __call__(self, followed: Floats, positions: Floats, velocities: Floats) -> Floats:
        """Return the commanded torques, shape (n,) [Nm | N].

        Args:
            followed: Positions, velocities and accelerations of the group to follow now, shape (3, n).
            positions: Of all joints of the model [rad | m].
            velocities: Of all joints of the model [rad/s | m/s].
        """
        reduced = self._reduced
        wanted = (
            followed[2]
            + self._damping * (followed[1] - velocities[self._driven])
            + self._stiffness * (followed[0] - positions[self._driven])
        )
        q = configuration(reduced.model, positions)
        torques = pin.rnea(reduced.model, self._data, q, velocities, reduced.mimic_matrix @ wanted)
        return reduced.mimic_matrix.T @ torques


def in_group_order(reduced: ReducedModel, trajectory: Trajectory) -> Trajectory:
    """Return the trajectory with its joints in the group's order.

    Raises:
        ModelError: If its joints are not the group's.
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
"""Joint speed [rad/s | m/s] beyond which a simulation has diverged."""


@checked
def build_spec(reduced: ReducedModel) -> "mujoco.MjSpec":
    """Return the MuJoCo model of a reduced model.

    Joints keep their names; each has a motor of its name if the group drives it, limited to its
    effort; joints that mimic another are held by a stiff constraint. Exactly the pairs that the
    scene does not excuse can collide. Joint friction and damping are left out, as in pinocchio's
    inverse dynamics.

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

    The robot starts in the trajectory's first position and velocity, follows it under a
    computed-torque controller whose motors give at most the group's effort limits (infinite ones
    are never reached), and holds the end for the settling time. It knows its own masses and what it carries
    exactly, so errors come from torque limits, contacts, or jumps in the trajectory. What changes with time
    is there at its times, exactly on its track, and yields to nothing.

    A robot of which a joint moves no mass, as its description has no inertias, is put where the plan has it
    at each time instead: contacts are found, but torques are zero, and a note says so.

    Args:
        motion: A plan, or a result that has one; or the reduced model (robot and scene) of a trajectory.
            Joints outside the group stand still.
        trajectory: Of the group's joints, in any order; the plan's own when None.
        options: Step, gains, settling time.

    Raises:
        PlanningFailed: If the result has no plan.
        ProblemError: If it takes more than a million steps.
        ModelError: If the trajectory's joints are not the group's.
    """
    from trajopt.simulation.plant import Plant  # MuJoCo takes a second to import

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
        asked = controller(followed.at(step), positions, velocities)
        given = np.clip(asked, -reduced.limits.effort, reduced.limits.effort)
        if t <= trajectory.duration:
            errors.append(followed.positions[step] - controller.group(positions))
        if step % stride == 0 or step == last:
            samples.append((t, controller.group(positions), controller.group(velocities), given))
        if step < last:
            limited += options.dt * (given != asked)
            log.record(t, plant.step(asked))
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
    """Put the robot where a trajectory has it at each time, without dynamics."""
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
        f"the motion is played without dynamics: joint {plant.massless} moves no mass; "
        "with an <inertial> for the links beyond it torques and tracking are simulated too"
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
