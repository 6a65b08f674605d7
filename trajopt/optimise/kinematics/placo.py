"""Inverse kinematics by placo's quadratic programs, one start after the other."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import singledispatch

import numpy as np
import placo

from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.terms.joint_positions import joint_box
from trajopt.optimise.terms.requirement import INSET
from trajopt.problem.requirements import (
    AxisAlignment,
    FramePlacement,
    JointPositions,
    Requirement,
    RotationCoordinates,
)
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import RequirementNotSupported
from trajopt.values.placement import IDENTITY, Placement, from_quaternion

NAME = "placo"
UNBOUNDED = 1e3
"""Limit of joints that have none [rad | m]."""
STIFF = 1e-9
"""Joints with a narrower range are masked and do not move [rad | m]."""

_Task = Callable[[placo.KinematicsSolver], object]
"""States something to placo's solver."""


@dataclass(frozen=True)
class Placo:
    """Placo's `KinematicsSolver`: frame placements, axis alignments and joint positions.

    Attributes:
        converged: A start has converged when no joint moves farther in a step [rad | m].
        regularization: Weight of the squared step; keeps programs regular at singularities.
    """

    steps: int = 40
    converged: float = 1e-7
    regularization: float = 1e-6
    name = NAME

    def search(self, projection: Projection) -> Callable[[Floats], Floats]:
        description = _Description(projection.reduced, projection.goals)
        for goal in projection.goals:
            state_task(goal, description)
        search = _Search(description, self)
        return lambda begin: np.array([search(start) for start in begin])


@dataclass(eq=False)
class _Description:
    reduced: ReducedModel
    goals: Sequence[Requirement]
    tasks: list[_Task] = field(default_factory=list[_Task])
    _frames: list[str] = field(default_factory=list[str])

    def frame(self, name: str, placement: Placement = IDENTITY) -> str:
        joint, within = self.reduced.attachment(name)
        link = f"frame{len(self._frames)}"
        self._frames.append(
            f'<link name="{link}"/><joint name="fix_{link}" type="fixed"><parent link="body{joint}"/>'
            f'<child link="{link}"/>{_origin(within * placement)}</joint>'
        )
        return link

    def box(self) -> tuple[Floats, Floats]:
        limits = self.reduced.limits
        lower, upper = joint_box(self.goals, self.reduced)
        lower, upper = np.maximum(lower, -UNBOUNDED), np.minimum(upper, UNBOUNDED)
        spare = 0.5 * INSET * (upper - lower)
        middle, empty = 0.5 * (lower + upper), lower > upper
        lower = np.where(lower > limits.lower, lower + spare, lower)
        upper = np.where(upper < limits.upper, upper - spare, upper)
        return np.where(empty, middle, lower), np.where(empty, middle, upper)

    def followers(self) -> tuple[tuple[int, int, float], ...]:
        """Return each mimic joint that moves: its place among the moving joints, its leader's, its factor."""
        moving, names = self.reduced.moving_joints, self.reduced.joint_names
        return tuple(
            (place, moving.index(names[leader]), float(self.reduced.mimic_matrix[place, leader]))
            for place, joint in enumerate(moving)
            if joint not in names
            for leader in (int(np.abs(self.reduced.mimic_matrix[place]).argmax()),)
        )

    def urdf(self) -> str:
        """Return the reduced model; the zero of a mimic joint is at its leader's zero."""
        lower, upper = self.box()
        text = ['<robot name="reduced"><link name="body0"/>']
        names = self.reduced.joint_names
        for index, joint in enumerate(self.reduced.moving_joints, start=1):
            model_joint = self.reduced.model.joints[index]
            travel = np.asarray(model_joint.createData().S, dtype=np.float64).reshape(6)
            turns = bool(travel[3:].any())
            axis = travel[3:] if turns else travel[:3]
            origin = self.reduced.model.jointPlacements[index]
            at = Placement(readonly(origin.rotation.copy()), readonly(origin.translation.copy()))
            low, high = -UNBOUNDED, UNBOUNDED
            if joint in names:
                low, high = float(lower[names.index(joint)]), float(upper[names.index(joint)])
            else:
                at = at * _moved(axis, turns, float(self.reduced.mimic_offset[index - 1]))
            text.append(
                f'<link name="body{index}"/><joint name="joint{index}" '
                f'type="{"revolute" if turns else "prismatic"}"><parent link="'
                f'body{self.reduced.model.parents[index]}"/><child link="body{index}"/>{_origin(at)}'
                f'<axis xyz="{_numbers(axis)}"/>'
                f'<limit lower="{low!r}" upper="{high!r}" effort="1" velocity="1"/></joint>'
            )
        return "".join((*text, *self._frames, "</robot>"))


class _Search:
    def __init__(self, description: _Description, options: Placo) -> None:
        reduced = description.reduced
        self._options, self._range = options, description.box()
        moving = reduced.moving_joints
        self._joints = [f"joint{moving.index(name) + 1}" for name in reduced.joint_names]
        self._followers = [
            (f"joint{place + 1}", f"joint{leader + 1}", factor)
            for place, leader, factor in description.followers()
        ]
        self._robot = placo.RobotWrapper("", placo.Flags.ignore_collisions, description.urdf())
        self._solver = placo.KinematicsSolver(self._robot)
        self._solver.mask_fbase(True)
        self._solver.enable_joint_limits(True)
        self._solver.add_regularization_task(options.regularization)
        lower, upper = self._range
        for joint in np.flatnonzero(upper - lower < STIFF):
            self._solver.mask_dof(self._joints[int(joint)])
        for joint, leader, factor in self._followers:
            gear = self._solver.add_gear_task()
            gear.set_gear(joint, leader, factor)
            gear.configure(f"{joint} follows", "hard")
        for task in description.tasks:
            task(self._solver)

    def __call__(self, start: Floats) -> Floats:
        now = np.clip(start, *self._range)
        for joint, value in zip(self._joints, now.tolist(), strict=True):
            self._robot.set_joint(joint, value)
        for joint, leader, factor in self._followers:
            self._robot.set_joint(joint, factor * self._robot.get_joint(leader))
        for _ in range(self._options.steps):
            self._robot.update_kinematics()
            try:
                self._solver.solve(True)
            except RuntimeError:  # a program without a solution ends the search from this start
                return now
            reached = np.array([self._robot.get_joint(name) for name in self._joints])
            if not np.isfinite(reached).all():
                return now
            moved, now = float(np.abs(reached - now).max()), reached
            if moved < self._options.converged:
                break
        return now


@singledispatch
def state_task(required: Requirement, description: _Description) -> None:
    raise RequirementNotSupported(NAME, required, f"there is no task for {type(required).__name__}")


@state_task.register
def _(required: JointPositions, description: _Description) -> None:
    del required, description  # The URDF's joint limits say it.


@state_task.register
def _(required: FramePlacement, description: _Description) -> None:
    goal = description.frame(required.reference, required.placement)
    frame = description.frame(required.frame, Placement(IDENTITY.rotation, required.offset))
    position, rotation = _axes(required.position_tolerance, np.inf), _axes(required.rotation_tolerance, np.pi)
    if required.coordinates is RotationCoordinates.XYZ_EULER and len(rotation) == 1:
        raise RequirementNotSupported(NAME, required, "two of three Euler angles are free")

    def tasks(solver: placo.KinematicsSolver) -> None:
        if position:
            solver.add_relative_position_task(goal, frame, np.zeros(3)).mask.set_axises(position, "task")
        if rotation:
            solver.add_relative_orientation_task(goal, frame, np.eye(3)).mask.set_axises(rotation, "task")

    description.tasks.append(tasks)


@state_task.register
def _(required: AxisAlignment, description: _Description) -> None:
    joint, reference = description.reduced.attachment(required.reference)
    if joint != 0:
        raise RequirementNotSupported(NAME, required, f"{required.reference!r} moves with the group")
    frame = description.frame(required.frame)
    direction = reference.rotation @ required.direction
    description.tasks.append(lambda solver: solver.add_axisalign_task(frame, required.axis, direction))


def _moved(axis: Floats, turns: bool, amount: float) -> Placement:
    if not turns:
        return Placement(IDENTITY.rotation, readonly(amount * axis))
    x, y, z = (np.sin(0.5 * amount) * axis).tolist()
    return Placement(readonly(from_quaternion(x, y, z, float(np.cos(0.5 * amount)))), IDENTITY.translation)


def _axes(tolerance: Floats, free: float) -> str:
    return "".join(axis for axis, room in zip("xyz", tolerance.tolist(), strict=True) if room < free)


def _numbers(values: Sequence[float] | Floats) -> str:
    return " ".join(repr(float(value)) for value in values)


def _origin(placement: Placement) -> str:
    return f'<origin xyz="{_numbers(placement.translation)}" rpy="{_numbers(placement.rpy)}"/>'
