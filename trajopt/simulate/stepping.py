"""Run a trajectory through MuJoCo: controller, motors with limits, contacts."""

import numpy as np

from trajopt.arrays import Floats, readonly
from trajopt.model.reduced import ReducedModel
from trajopt.model.trajectory import Trajectory
from trajopt.simulate.contacts import ContactLog
from trajopt.simulate.controller import ComputedTorque, in_group_order, reference
from trajopt.simulate.options import SimulationOptions
from trajopt.simulate.plant import Plant
from trajopt.simulate.rollout import Rollout, TrackingError

BLOWN_UP = 1e4
"""Joint speed [rad/s | m/s] beyond which a simulation has left physics."""


def simulate(
    reduced: ReducedModel, trajectory: Trajectory, *, options: SimulationOptions | None = None
) -> Rollout:
    """Execute a trajectory in MuJoCo.

    The robot starts in the trajectory's first position and velocity, follows it under a
    computed-torque controller whose motors give at most the group's effort limits (infinite ones
    are never reached), and holds the end for the settling time. It knows its own masses exactly,
    so what goes wrong is torque limits, contacts, or jumps in the trajectory.

    Args:
        reduced: Robot and scene; joints outside the group stand still.
        trajectory: Of the group's joints, in any order.
        options: Step, gains, settling time.

    Raises:
        ProblemError: If it takes more than a million steps.
        ModelError: If the trajectory's joints are not the group's, or the robot has no masses.
    """
    options = options or SimulationOptions()
    trajectory = in_group_order(reduced, trajectory)
    plant = Plant(reduced, options.dt)
    followed = reference(trajectory, options.dt, options.settling_time)
    controller = ComputedTorque(reduced, followed, options)
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
        asked = controller(step, positions, velocities)
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
