"""Examination of a single configuration: collisions, joint limits, requirements."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import chain

import numpy as np

from trajopt.problem.requirement import Requirement
from trajopt.robot.joints import joint_unit
from trajopt.scene.clearances import how_near
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats, floats
from trajopt.values.printed import in_joint_position, in_range, in_unit
from trajopt.values.trajectory import Trajectory
from trajopt.verify.certificate import Check
from trajopt.verify.checks.limits import moving_limits
from trajopt.verify.checks.quantities import When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.kernel.pair_distances import PairDistances, required_clearances


class Moment(Enum):
    """Moment of a motion at which a configuration occurs; contact may be accepted at its ends."""

    START = "start"
    BETWEEN = "between"
    END = "end"


@dataclass(frozen=True, kw_only=True)
class PairDistance:
    """Distance of two links or objects.

    Attributes:
        distance: Signed distance, negative in penetration [m].
        required: Required clearance [m].
        proven: Whether the violation exceeds the error of the distance.
    """

    first: str
    second: str
    distance: float
    required: float = 0.0
    proven: bool = False

    @property
    def words(self) -> str:
        """Describe distance and required clearance."""
        return how_near(self.first, self.second, self.distance, self.required)


@dataclass(frozen=True, kw_only=True)
class OutOfLimit:
    """A joint beyond one of its position limits [rad | m].

    Attributes:
        unit: "rad" or "m".
        follows: Source joint of a mimic joint; otherwise empty.
    """

    joint: str
    position: float
    lower: float
    upper: float
    excess: float
    unit: str
    follows: str = ""

    @property
    def subject(self) -> str:
        """Name of the joint, and for a mimic joint its source joint."""
        return f"{self.joint}, which follows {self.follows}," if self.follows else self.joint

    @property
    def words(self) -> str:
        """Describe position, excess and limits."""
        where, beyond = in_joint_position(self.position, self.unit), in_unit(self.excess, self.unit)
        return f"{self.subject} at {where} is {beyond} outside {in_range(self.lower, self.upper, self.unit)}"


@dataclass(frozen=True, kw_only=True)
class Examination:
    """Faults of a configuration.

    Attributes:
        collisions: Pairs in contact not accepted, or below their clearance, the worst first.
        out_of_limits: Joints of the group, and their mimic joints, beyond position limits, farthest first.
    """

    collisions: tuple[PairDistance, ...]
    out_of_limits: tuple[OutOfLimit, ...]
    smallest: PairDistance | None

    @property
    def clear(self) -> bool:
        """Whether there is no fault."""
        return not self.collisions and not self.out_of_limits

    @property
    def proven(self) -> bool:
        """Whether a fault exceeds numerical error."""
        return bool(self.out_of_limits) or any(pair.proven for pair in self.collisions)


def examine_with(
    kinematics: Kinematics,
    distances: PairDistances,
    positions: Floats,
    *,
    moment: Moment,
    options: VerifyOptions,
) -> Examination:
    """Examine a configuration (n,) [rad | m] in given workspaces."""
    reduced = kinematics.reduced
    place = floats("positions", positions, (len(reduced.joint_names),))
    measured = distances.nearest(kinematics.poses(place[None]))
    judged = np.isfinite(measured) & ~_excused(reduced, measured, moment)
    required = required_clearances(reduced)
    broken = np.flatnonzero(judged & (measured <= required))
    proven = measured[broken] + distances.uncertainty(broken, measured[broken], options.distance_error)
    sure = dict(zip(broken.tolist(), (proven <= required[broken]).tolist(), strict=True))

    def seen(pair: int) -> PairDistance:
        first, second = distances.owners(pair)
        # Words are of the described robot: the model's error adds to the required clearance.
        error = float(reduced.pairs.error[pair])
        distance, least = float(measured[pair]) + error, float(required[pair]) + error
        return PairDistance(
            first=first, second=second, distance=distance, required=least, proven=sure.get(pair, False)
        )

    nearest: dict[tuple[str, str], PairDistance] = {}
    for pair in broken[np.argsort(measured[broken])].tolist():
        nearest.setdefault(distances.owners(pair), seen(pair))
    return Examination(
        collisions=tuple(sorted(nearest.values(), key=lambda pair: pair.distance - pair.required)),
        out_of_limits=_out_of_limits(reduced, place, options.excess),
        smallest=seen(int(np.where(judged, measured, np.inf).argmin())) if judged.any() else None,
    )


def requirements_with(
    kinematics: Kinematics,
    positions: Floats,
    requirements: Sequence[Requirement],
    *,
    options: VerifyOptions,
) -> tuple[Check, ...]:
    reduced = kinematics.reduced
    place = floats("positions", positions, (len(reduced.joint_names),))
    standing = Trajectory(reduced.joint_names, np.array([0.0, 1.0]), np.stack((place, place)))
    motion = JudgedMotion(reduced, standing, kinematics=kinematics, options=options)
    return tuple(chain(*(check_requirement(item, motion, When.END) for item in requirements)))


def _excused(reduced: ReducedModel, measured: Floats, moment: Moment) -> Bools:
    excused = np.zeros(len(measured), dtype=np.bool_)
    for pair, allowance in reduced.pairs.allowances:
        window = {Moment.START: allowance.first, Moment.END: allowance.last}.get(moment, 0.0)
        if window > 0.0 and measured[pair] > -allowance.depth - reduced.pairs.error[pair]:
            excused[pair] = True
    return excused


def _out_of_limits(reduced: ReducedModel, positions: Floats, excess: float) -> tuple[OutOfLimit, ...]:
    robot, limits = reduced.scene.robot, moving_limits(reduced, None)
    lower, upper, moving = limits.lower, limits.upper, limits.joint_names
    positions = reduced.mimic_matrix @ positions + reduced.mimic_offset
    beyond = np.maximum(positions - upper, lower - positions)
    outside = np.flatnonzero(beyond > 0.0)
    limit = np.where(positions > upper, upper, lower)[outside]
    outside = outside[beyond[outside] > excess * np.maximum(np.abs(limit), 1.0)]
    farthest_first: list[int] = outside[np.argsort(-beyond[outside])].tolist()
    return tuple(
        OutOfLimit(
            joint=moving[joint],
            position=float(positions[joint]),
            lower=float(lower[joint]),
            upper=float(upper[joint]),
            excess=float(beyond[joint]),
            unit=joint_unit(robot.model, moving[joint]),
            follows=robot.mimics[moving[joint]].source if moving[joint] in robot.mimics else "",
        )
        for joint in farthest_first
    )
