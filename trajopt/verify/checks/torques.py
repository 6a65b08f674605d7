"""Joint torques by inverse dynamics, judged at samples."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.robot.joints import JointLimits, effort_unit
from trajopt.scene.reduced import Payload, payloads
from trajopt.values.arrays import Floats, Ints
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_unit_apart
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.motion import JudgedMotion, counting, steps_in_pieces
from trajopt.verify.specification import Criterion


def payload_torques(
    kinematics: Kinematics, positions: Floats, velocities: Floats, accelerations: Floats
) -> Floats:
    """Return the joint torques for attached objects with a mass, by d'Alembert's principle.

    A centre of mass m that must accelerate by a needs the force m (a - g), and joint k bears l_k . m (a - g),
    where l_k is the velocity of the point at unit speed of the joint. From joint to joint outwards, the
    acceleration of the point, taken as fixed to the next link, grows by 2 w x (l v) + v^2 z x l + a l for a
    revolute joint of axis z, speed v and acceleration a behind a link of angular velocity w; a prismatic
    joint has no second term.

    To turn with angular velocity w and acceleration u the load of moments I needs the moment I u + w x I w
    (Euler), and a revolute joint bears its part along z. From joint to joint u grows by w x (v z) + a z.

    Args:
        positions: Of the group's joints, shape (s, n) [rad | m].
        velocities: Of the model's joints, shape (s, joints) [rad/s | m/s].
        accelerations: Shape (s, joints) [rad/s^2 | m/s^2].

    Returns:
        Torques of the model's joints, shape (s, joints) [Nm | N].
    """
    total = np.zeros(velocities.shape)
    carried = payloads(kinematics.reduced)
    if carried:
        poses = kinematics.poses(positions)
        for item in carried:
            total += _torques(kinematics, item, poses, velocities, accelerations)
    return total


def _torques(
    kinematics: Kinematics, item: Payload, poses: Poses, velocities: Floats, accelerations: Floats
) -> Floats:
    point = poses.rotation[:, item.joint] @ item.point + poses.translation[:, item.joint]
    spin: Floats = np.zeros(point.shape)
    acceleration: Floats = np.zeros(point.shape)
    turning: Floats = np.zeros(point.shape)
    levers: dict[int, Floats] = {}
    axes: dict[int, Floats] = {}
    for joint in reversed(kinematics.chain(item.joint)):
        axis: Floats = poses.rotation[:, joint] @ kinematics.axes[joint]
        speed: Floats = velocities[:, joint - 1, None]
        increase: Floats = accelerations[:, joint - 1, None]
        if kinematics.revolute[joint]:
            lever = _cross(axis, point - poses.translation[:, joint])
            acceleration = acceleration + speed**2 * _cross(axis, lever)
        else:
            lever = axis
        acceleration = acceleration + 2.0 * _cross(spin, speed * lever) + increase * lever
        if kinematics.revolute[joint]:
            turning = turning + _cross(spin, speed * axis) + increase * axis
            spin = spin + speed * axis
            axes[joint] = axis
        levers[joint] = lever
    gravity = np.array(kinematics.reduced.model.gravity.linear)
    force = item.mass * (acceleration - gravity)
    rotation = poses.rotation[:, item.joint]
    inertia = rotation @ item.inertia @ rotation.transpose(0, 2, 1)
    moment = np.einsum("sij,sj->si", inertia, turning)
    moment += _cross(spin, np.einsum("sij,sj->si", inertia, spin))
    torques = np.zeros(velocities.shape)
    for joint, lever in levers.items():
        torques[:, joint - 1] = np.einsum("si,si->s", lever, force)
    for joint, axis in axes.items():
        torques[:, joint - 1] += np.einsum("si,si->s", axis, moment)
    return torques


def _cross(first: Floats, second: Floats) -> Floats:
    return np.asarray(np.cross(first, second), dtype=np.float64)


SAMPLES_PER_SEGMENT = 4
"""Fewest samples of a segment, ends included, as accelerations may jump between segments."""

ROUNDING = 1e-9
"""Relative difference of accelerations that counts as rounding."""

LEFT = 2e-6
"""A joint with less than this share of its effort limit left cannot start or stop in that posture."""


@dataclass(frozen=True, kw_only=True)
class Overload:
    """A joint whose gravity torque reaches its effort limit.

    Attributes:
        torque: Magnitude of the gravity torque [Nm | N].
        limit: Effort limit [Nm | N].
        unit: "Nm", or "N" for a prismatic joint.
    """

    joint: str
    torque: float
    limit: float
    unit: str

    @property
    def excess(self) -> float:
        """Missing torque [Nm | N]; nearly zero if the joint can just be held, but not moved."""
        return self.torque - self.limit

    @checked
    def words(self, where: str = "") -> str:
        """Describe the torque and the limit, with the posture: "at the goal"."""
        need = f"{self.torque:.4g}"
        if need == f"{self.limit:.4g}":
            need = f"{self.torque:.8g}"
        place = f" {where}" if where else ""
        return (
            f"{self.joint} needs {need} {self.unit} only to hold still{place}, its effort limit is "
            f"{self.limit:.4g} {self.unit}"
        )


def overloads(kinematics: Kinematics, positions: Floats, limits: JointLimits) -> tuple[Overload, ...]:
    """Return the joints that cannot hold a configuration (n,) [rad | m], largest missing torque first."""
    torque, effort = np.abs(torques_at_rest(kinematics, positions[None])[0]), limits.effort
    broken = np.flatnonzero(torque >= effort * (1.0 - LEFT))
    order: Sequence[int] = broken[np.argsort(effort[broken] - torque[broken], kind="stable")].tolist()
    names, model = kinematics.reduced.joint_names, kinematics.reduced.scene.robot.model
    return tuple(
        Overload(
            joint=names[joint],
            torque=float(torque[joint]),
            limit=float(effort[joint]),
            unit=effort_unit(model, names[joint]),
        )
        for joint in order
    )


@dataclass(frozen=True, eq=False)
class TorqueCriterion(Criterion):
    """Torques of joints with an effort limit, if the trajectory has accelerations.

    At an end at rest, the arm must also hold the posture.
    """

    motion: JudgedMotion
    limits: JointLimits

    def holds(self) -> bool:
        """Decide the criterion by the largest share of a limit, computed by the native core."""
        motion, limits = self.motion, self.limits
        if not _judged(motion, limits):
            return True
        if payloads(motion.reduced):
            largest = _shares(motion, limits)[2].max()
        else:
            kinematics, position, reduced = motion.kinematics, motion.position, motion.reduced
            largest = kinematics.dynamics.share(
                position.times,
                np.ascontiguousarray(position.coefficients),
                _steps(motion),
                ROUNDING,
                _ends(motion)[1],
                reduced.mimic_matrix,
                reduced.mimic_offset,
                limits.effort,
            )
        return bool(largest <= 1.0 + motion.options.excess)

    def measure(self) -> Iterator[Check]:
        motion, limits = self.motion, self.limits
        if not _judged(motion, limits):
            return
        times, torques, share = _shares(motion, limits)
        worst = share.max(axis=0)
        for place, joint in enumerate(int(joint) for joint in np.argsort(-worst)):
            holds = bool(worst[joint] <= 1.0 + motion.options.excess)
            if place and holds:
                break
            name = motion.reduced.joint_names[joint]
            row = int(share[:, joint].argmax())
            value, bound = float(torques[row, joint]), float(limits.effort[joint])
            unit = effort_unit(motion.reduced.scene.robot.model, name)
            needed, most = in_unit_apart(abs(value), bound, unit)
            yield Check(
                kind=CheckKind.TORQUE,
                name="torque",
                subject=name,
                value=value,
                bound=bound,
                unit=unit,
                time=float(times[row]),
                slack=bound - abs(value),
                evidence=Evidence.SAMPLED,
                holds=holds,
                detail=f"{name} needs {needed}, its limit is {most}",
            )


def _judged(motion: JudgedMotion, limits: JointLimits) -> bool:
    return motion.differentiable and bool(np.isfinite(limits.effort).any())


def _shares(motion: JudgedMotion, limits: JointLimits) -> tuple[Floats, Floats, Floats]:
    (times, states), (rests, at) = _samples(motion), _ends(motion)
    still = np.zeros_like(at)
    states = [np.concatenate(parts) for parts in zip(states, (at, still, still), strict=True)]
    times, torques = np.concatenate((times, rests)), _needed(motion.kinematics, *states)
    limited = np.isfinite(limits.effort)
    return times, torques, np.where(limited, np.abs(torques) / limits.effort, -np.inf)


def torques_at_rest(kinematics: Kinematics, positions: Floats) -> Floats:
    """Return the torques that hold the arm at configurations, shape (s, n) [Nm | N]."""
    still = np.zeros_like(positions)
    return _needed(kinematics, positions, still, still)


def _needed(kinematics: Kinematics, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
    matrix = kinematics.reduced.mimic_matrix
    moving = velocities @ matrix.T, accelerations @ matrix.T
    carried = payload_torques(kinematics, positions, *moving) @ matrix
    torques = kinematics.torques(positions, *moving) @ matrix + carried
    # The torque is linear in the masses: the largest is at the least or the largest of them.
    return torques + np.copysign(kinematics.reduced.scene.model_error.payload * np.abs(carried), torques)


def _ends(motion: JudgedMotion) -> tuple[Floats, Floats]:
    velocities = motion.trajectory.velocities
    assert velocities is not None  # The motion is differentiable.
    ends = [end for end in (0, -1) if np.abs(velocities[end]).max(initial=0.0) <= motion.options.rest_speed]
    return motion.trajectory.times[ends], motion.trajectory.positions[ends]


def inverse_dynamics(motion: JudgedMotion) -> tuple[Floats, Floats]:
    """Sample the joint torques of a motion: times (s,) [s], torques (s, n) [Nm | N] with mimic joints'."""
    times, states = _samples(motion)
    return times, _needed(motion.kinematics, *states)


def _steps(motion: JudgedMotion) -> Ints:
    return np.maximum(steps_in_pieces(motion), SAMPLES_PER_SEGMENT - 1)


def _samples(motion: JudgedMotion) -> tuple[Floats, list[Floats]]:
    """Sample each segment from its own polynomial: times (s,), and orders 0 to 2, each (s, n).

    Unless the acceleration jumps, the end of a segment is the start of the next.
    """
    knots = motion.trajectory.times
    counts = _steps(motion) + 1
    segment, number = np.repeat(np.arange(len(counts)), counts), counting(counts)
    jumps = np.abs(motion.acceleration_jumps)
    again = jumps.max(axis=1) <= ROUNDING * np.abs(motion.group[2].coefficients[-1]).max(initial=0.0)
    again[0] = False
    kept = (number > 0) | ~again[segment]
    segment, number = segment[kept], number[kept]
    local = np.diff(knots)[segment] * number / (counts[segment] - 1)
    return knots[segment] + local, [motion.group[order].at(segment, local) for order in (0, 1, 2)]
