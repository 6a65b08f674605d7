"""The judge: proves or refutes all requirements on a trajectory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from heapq import nsmallest
from itertools import chain
from math import inf
from types import MappingProxyType

import numpy as np

from trajopt.problem.requirement import During, Requirement
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.robot.joints import JointLimits, joint_unit
from trajopt.scene.reduced import ReducedModel, payloads
from trajopt.values.arrays import Floats, floats, one_of
from trajopt.values.errors import shown
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_unit
from trajopt.values.trajectory import Trajectory
from trajopt.verify.certificate import Certificate, Check, CheckKind, Counts
from trajopt.verify.checks.clearance import AtFaultCriterion, ClearanceCriterion
from trajopt.verify.checks.ends import DeadlineCriterion, EndCriterion, MeetingCriterion, PredictionCriterion
from trajopt.verify.checks.limits import LimitCriterion, group_part, moving_limits
from trajopt.verify.checks.required import RequirementCriterion
from trajopt.verify.checks.rolling import RollingCriterion
from trajopt.verify.checks.tool_speed import ToolSpeedCriterion
from trajopt.verify.checks.torques import Overload, TorqueCriterion, overloads
from trajopt.verify.examination import Examination, Moment, examine_with, requirements_with
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.kernel.pair_distances import Surroundings, required_clearances
from trajopt.verify.specification import Criterion, SampledCheck, Specification, Verdict

_DEFAULT = VerifyOptions()
NONE: Mapping[str, Sequence[Requirement]] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class _Judged:
    motion: JudgedMotion
    limits: JointLimits
    clearance: ClearanceCriterion
    criteria: tuple[Criterion, ...]


class Judge:
    """Workspace that judges motions of one reduced model; one per thread."""

    def __init__(self, reduced: ReducedModel, options: VerifyOptions = _DEFAULT) -> None:
        """Build the judge's own kinematics and geometry.

        Raises:
            ModelError: If two half-spaces have to keep apart.
        """
        self.reduced = one_of("reduced (as problem.reduced)", reduced, ReducedModel)
        self.options = one_of("options", options, VerifyOptions)
        self._kinematics = Kinematics(reduced)
        self._surroundings = Surroundings(self._kinematics, options)

    @checked
    def certify(self, trajectory: Trajectory, specification: Specification) -> Certificate:
        """Judge a trajectory of the group's joints, and measure its margins; raises as `verify`."""
        before, judged = self._calls, self._criteria(trajectory, specification)
        checks = tuple(chain.from_iterable(criterion.measure() for criterion in judged.criteria))
        found, motion = judged.clearance.finding, judged.motion
        among = judged.clearance.motion.reduced
        at_fault = [check for check in checks if check.kind is CheckKind.AT_FAULT]
        return Certificate(
            checks=checks,
            clearance=found.clearance,
            at_fault=_least(at_fault, found.clearance),
            pairs=found.pairs,
            unproven=found.unproven,
            required=_range(required_clearances(among)),
            margin=_range(among.pairs.margin),
            counts=self._counted(before),
            notes=(*notes(motion, judged.limits), *self._surroundings.given),
        )

    def decide(self, trajectory: Trajectory, specification: Specification) -> Verdict:
        """Judge a trajectory without margins, with the same verdict as `certify`.

        Raises:
            ProblemError: As `certify`, unless the verdict is known before the faulty requirement is examined.
        """
        before, judged = self._calls, self._criteria(trajectory, specification)
        failed = next((type(criterion) for criterion in judged.criteria if not criterion.holds()), None)
        return Verdict(failed=failed, contact=judged.clearance.contact, counts=self._counted(before))

    def _criteria(self, trajectory: Trajectory, specification: Specification) -> _Judged:
        moving = moving_limits(self.reduced, specification.limits)
        limits = group_part(self.reduced, moving)
        motion, followed = self._motion(trajectory, specification), self._followed(specification)
        dwell = specification.dwell
        among = self._surroundings.among(motion, 0.0 if followed else dwell, specification.clock)
        motion.among = among
        distances = self._surroundings.distances
        clearance = ClearanceCriterion(among, distances)
        return _Judged(
            motion,
            limits,
            clearance,
            (
                clearance,
                *((AtFaultCriterion(clearance),) if self._surroundings.timings else ()),
                EndCriterion(motion, specification),
                RequirementCriterion(motion, specification, followed),
                LimitCriterion(motion, moving, specification.start_accelerations),
                TorqueCriterion(motion, limits),
                DeadlineCriterion(motion, specification.finish_by, dwell if followed else 0.0),
                RollingCriterion(motion),
                *(ToolSpeedCriterion(motion, tool) for tool in specification.tool_speeds),
                PredictionCriterion(among, self._surroundings.timings),
                MeetingCriterion(among, followed, dwell),
            ),
        )

    @checked
    def examine(self, positions: Floats, *, moment: Moment = Moment.BETWEEN) -> Examination:
        """Examine a configuration; see the function `examine`."""
        return examine_with(
            self._kinematics,
            self._surroundings.still,
            positions,
            moment=moment,
            options=self.options,
        )

    @checked
    def overloads(self, positions: Floats, *, limits: JointLimits | None = None) -> tuple[Overload, ...]:
        """Return the joints that cannot hold the arm and its attached objects, the worst first.

        Args:
            positions: Of the group's joints, shape (n,) [rad | m].
            limits: Of the group's joints, or of these and of their mimic joints; the robot's by default.

        Raises:
            ShapeError: Unless there is one finite position per joint.
        """
        bounds = group_part(self.reduced, moving_limits(self.reduced, limits))
        place = floats("positions", positions, (len(self.reduced.joint_names),))
        return overloads(self._kinematics, place, bounds)

    def check(self, positions: Floats, requirements: Sequence[Requirement]) -> tuple[Check, ...]:
        """Check requirements at a configuration, as at the end of a motion.

        Args:
            positions: Of the group's joints, shape (n,) [rad | m].

        Raises:
            ShapeError: Unless there is one finite position per joint.
            NameNotFound: If a requirement names an unknown frame, joint or object.
        """
        return requirements_with(self._kinematics, positions, requirements, options=self.options)

    def _motion(self, trajectory: Trajectory, specification: Specification) -> JudgedMotion:
        one_of("trajectory", trajectory, Trajectory)
        return JudgedMotion(
            self.reduced,
            trajectory,
            kinematics=self._kinematics,
            options=self.options,
            rests_after=not self._followed(specification),
        )

    def _followed(self, specification: Specification) -> tuple[Requirement, ...]:
        timed = self.reduced.timed if specification.goals else None
        if timed is None:
            return ()
        moving = timed.reduced.anchors.keys() - self.reduced.anchors.keys()
        return tuple(goal for goal in specification.goals if moving.intersection(goal.frames))

    @property
    def _calls(self) -> tuple[int, int]:
        return self._surroundings.distances.calls, self._kinematics.calls

    def _counted(self, before: tuple[int, int]) -> Counts:
        distances, kinematics = self._calls
        return Counts(distances=distances - before[0], kinematics=kinematics - before[1])


def _least(at_fault: Sequence[Check], clearance: float) -> float:
    if not at_fault:
        return clearance
    return inf if at_fault[0].value is None else at_fault[0].value


def _range(values: Floats) -> tuple[float, float]:
    return (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)


@checked
def verify(
    reduced: ReducedModel,
    trajectory: Trajectory,
    *,
    goals: Sequence[Requirement],
    constraints: Sequence[Requirement] = (),
    waypoints: Mapping[str, Sequence[Requirement]] = NONE,
    partial: Sequence[During[Requirement] | During[SampledCheck]] = (),
    sampled: Sequence[SampledCheck] = (),
    limits: JointLimits | None = None,
    tool_speeds: Sequence[ToolSpeed] = (),
    start_velocities: Floats | None = None,
    start_accelerations: Floats | None = None,
    dwell: float = 0.0,
    finish_by: float | None = None,
    options: VerifyOptions = _DEFAULT,
) -> Certificate:
    """Judge a trajectory at all times.

    Args:
        reduced: Robot with the group's joints free, in its scene, at its start state.
        trajectory: Of the group's joints.
        goals: Requirements at the end; all must hold.
        constraints: Requirements at all times.
        waypoints: Requirements that must hold together at some moment, by name, in this order.
        partial: Requirements between waypoints.
        sampled: Constraints in user code, judged at samples.
        limits: Of the group's joints, or of these and of their mimic joints; the robot's by default.
        start_velocities: Shape (n,) [rad/s | m/s]; at rest by default.
        start_accelerations: Shape (n,) [rad/s^2 | m/s^2]; zero by default.
        dwell: Time for which the robot stays clear at rest after the end; for a moving goal, the time for
            which it has followed the goal at its end [s].
        finish_by: Deadline at the goal, from the motion's start [s]; none by default.

    Raises:
        ProblemError: If the trajectory or the limits have other joints than the group, or a requirement has
            no check.
        NameNotFound: If a requirement names an unknown frame, joint or object.
        ModelError: If two half-spaces have to keep apart.
    """
    specification = Specification(
        goals=goals,
        constraints=constraints,
        waypoints=waypoints,
        partial=partial,
        sampled=sampled,
        limits=limits,
        tool_speeds=tool_speeds,
        start_velocities=start_velocities,
        start_accelerations=start_accelerations,
        dwell=dwell,
        finish_by=finish_by,
    )
    return Judge(reduced, options).certify(trajectory, specification)


def examine(
    reduced: ReducedModel,
    positions: Floats,
    *,
    moment: Moment = Moment.BETWEEN,
    options: VerifyOptions = _DEFAULT,
) -> Examination:
    """Examine a configuration: measure every pair, and compare joints with their limits.

    Dynamic obstacles are left out; a model of `scene.still_at(time)` includes them.

    Args:
        reduced: Robot with the group's joints free, in its scene.
        positions: Of the group's joints, shape (n,) [rad | m].
        moment: Moment of a motion at which the configuration occurs; at its ends contact may be accepted.

    Raises:
        ShapeError: Unless there is one finite position per joint.
        ModelError: If two half-spaces have to keep apart.
    """
    return Judge(reduced, options).examine(positions, moment=moment)


_MOST_NAMES = 8


def notes(motion: JudgedMotion, limits: JointLimits) -> tuple[str, ...]:
    reduced = motion.reduced
    return (
        *_trajectory_notes(motion, limits),
        *(f"limit chosen: {note}" for note in limits.defaulted),
        *_jerk_notes(limits),
        *_joint_notes(reduced),
        *(f"mesh of {note}" for note in reduced.scene.robot.mesh_notes),
        *(f"mesh of {note}" for item in reduced.scene.objects.values() for note in item.notes),
        *_pair_notes(reduced),
    )


def _trajectory_notes(motion: JudgedMotion, limits: JointLimits) -> list[str]:
    found: list[str] = []
    if not motion.differentiable:
        found.append(
            "the trajectory is linear between its points: its velocity jumps there, and it states no "
            "accelerations, so speed is judged for each segment, acceleration, torque and rest are not"
        )
    elif np.isfinite(limits.effort).any():
        reduced = motion.reduced
        weighed = [item.name for item in payloads(reduced)]
        if weighed:
            names = _listed(sorted(weighed), count=len(weighed))
            found.append(f"torques count the mass of {names} as spread evenly over its shape")
        owners = {body.owner for body in reduced.bodies if body.joint != 0}
        carried = sorted((owners & set(reduced.scene.objects)) - set(weighed))
        if carried:
            found.append(f"torques are judged without the mass of {_listed(carried, count=len(carried))}")
    return found


def _jerk_notes(limits: JointLimits) -> list[str]:
    free = [
        name for name, limit in zip(limits.joint_names, limits.jerk, strict=True) if not np.isfinite(limit)
    ]
    if not free:
        return []
    named = _listed(free, count=len(free))
    return [f"jerk is not limited, as no limit is stated: {named}; Robot.with_jerk_limits chooses limits"]


def _joint_notes(reduced: ReducedModel) -> list[str]:
    robot = reduced.scene.robot
    beyond = np.maximum(reduced.start - robot.limits.upper, robot.limits.lower - reduced.start)
    moved = set(reduced.model.names)
    return [
        f"{name} stands {in_unit(beyond[joint], joint_unit(robot.model, name))} outside its limits; "
        f"it is not in group {shown(reduced.group)}"
        for joint, name in enumerate(robot.joint_names)
        if beyond[joint] > 1e-9 and name not in moved
    ]


def _pair_notes(reduced: ReducedModel) -> list[str]:
    found = [
        f"contact of {allowance.a} and {allowance.b} is accepted ({allowance.name}): at most "
        f"{1000 * allowance.depth:g} mm deep, first {allowance.first:g} s and last {allowance.last:g} s"
        for allowance in dict.fromkeys(allowance for _, allowance in reduced.pairs.allowances)
    ]
    if not any(body.joint for body in reduced.bodies):
        found.append("no moving link has a collision shape: no clearance is checked")
    immobile = reduced.pairs.immobile
    if immobile:
        first = nsmallest(_MOST_NAMES, map(sorted, immobile))
        names = _listed([" - ".join(pair) for pair in first], count=len(immobile))
        found.append(f"pairs that do not move against each other, not judged: {names}")
    return found


def _listed(names: list[str], *, count: int) -> str:
    more = count - _MOST_NAMES
    return ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")
