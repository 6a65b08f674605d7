"""The tracking controller: inverse dynamics along the trajectory, and feedback shaped by it."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.robot.loading.pinocchio_model import configuration
from trajopt.scene.reduced import ReducedModel
from trajopt.simulation.options import SimulationOptions
from trajopt.values.arrays import Floats
from trajopt.values.errors import ModelError, ProblemError, shown
from trajopt.values.trajectory import Trajectory

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
