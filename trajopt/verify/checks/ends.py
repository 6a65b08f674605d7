"""The ends of a motion: it starts as the robot is and moves, and ends at rest unless it meets what moves."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trajopt.robot.loading.pinocchio_model import joint_unit
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_unit
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.criterion import Criterion
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.specification import Specification


@dataclass(frozen=True, eq=False)
class _End:
    """A size at one end of the motion, of each joint, and the most that is accepted."""

    name: str
    sizes: Floats
    bound: float
    time: float
    order: int


@dataclass(frozen=True, eq=False)
class EndCriterion(Criterion):
    """The start and, where the trajectory states velocities, those at both ends.

    Attributes:
        motion: The motion.
        specification: Where it starts, and how fast and with which acceleration; accelerations are not judged
            where there are none, or zeros, but for the jumps that a limit of jerk forbids.
    """

    motion: Motion
    specification: Specification

    def holds(self) -> bool:
        """Decide it; without the names and units of a certificate."""
        return all(end.sizes.max() <= end.bound for end in self._ends())

    def measure(self) -> Iterator[Check]:
        """State the joint that is farthest off, for each end."""
        for end in self._ends():
            yield _check(self.motion, end)

    def _ends(self) -> Iterator[_End]:
        motion, options = self.motion, self.motion.options
        yield _End("start", self._off_start(), options.start_error, 0.0, 0)
        velocities, before = motion.trajectory.velocities, self.specification.start_velocities
        if velocities is not None:
            rests = before is None or not before.any()
            begin = velocities[0] if before is None else velocities[0] - before
            name = "start at rest" if rests else "start velocity"
            yield _End(name, np.abs(begin), options.rest_speed, 0.0, 1)
            if motion.rests_after:
                yield _End("end at rest", np.abs(velocities[-1]), options.rest_speed, motion.duration, 1)
        accelerations = self.specification.start_accelerations
        if accelerations is not None and accelerations.any() and motion.differentiable:
            # Twice the coefficient of the square of time, in the first piece.
            off = np.abs(2.0 * motion.position.coefficients[-3, 0] - accelerations)
            yield _End("start acceleration", off, options.start_acceleration_error, 0.0, 2)

    def _off_start(self) -> Floats:
        """Return how far each joint of the group is from where it has to start, shape (n,) [rad | m]."""
        start, motion = self.specification.start_positions, self.motion
        return np.abs(
            motion.trajectory.positions[0] - (motion.reduced.start_positions if start is None else start)
        )


def _check(motion: Motion, end: _End) -> Check:
    joint = int(end.sizes.argmax())
    subject = motion.reduced.joint_names[joint]
    value = float(end.sizes[joint])
    unit = joint_unit(motion.reduced.scene.robot.model, subject, order=end.order)
    words = "moves at" if end.name.endswith("rest") else "is off by"
    return Check(
        kind=CheckKind.ENDS,
        name=end.name,
        subject=subject,
        value=value,
        bound=end.bound,
        unit=unit,
        time=end.time,
        slack=end.bound - value,
        evidence=Evidence.PROVEN,
        holds=value <= end.bound,
        detail=f"{subject} {words} {in_unit(value, unit)}",
    )
