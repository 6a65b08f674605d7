"""Torques of joints and two derivatives in time, at times or over cells.

All vectors are along the axes of their own joint's frame. Source: Luh, Walker and Paul, On-line computational
scheme for mechanical manipulators, 1980.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from operator import add, mul
from typing import TypeAlias

import numpy as np
from intervals import Floats, Interval, cross, dot, exactly, sine_and_cosine, turned
from kinematics import slide, turning
from statement import StatedJoint, Statement


@dataclass(frozen=True, eq=False)
class Series:
    """Functions f with their derivatives in time.

    Attributes:
        terms: f, f' and f''/2 over cells; f alone at times; a constant has one term, the others are zero.
    """

    terms: tuple[Interval, ...]

    def __add__(self, other: Series) -> Series:
        few, many = sorted((self.terms, other.terms), key=len)
        return Series((*map(add, few, many), *many[len(few) :]))

    def map(self, linear: Callable[[Interval], Interval]) -> Series:
        return Series(tuple(map(linear, self.terms)))

    def times(self, bilinear: Callable[[Interval, Interval], Interval], other: Series) -> Series:
        """Apply a bilinear operation, such as a cross product, by the product rule (Leibniz)."""
        one, two = self.terms, other.terms
        found: list[Interval] = []
        for order in range(max(len(one), len(two))):
            places = range(max(0, order - len(two) + 1), min(order + 1, len(one)))
            found.append(reduce(add, (bilinear(one[place], two[order - place]) for place in places)))
        return Series(tuple(found))


def constant(value: Floats | float) -> Series:
    return Series((exactly(value),))


def over_cells(value: Interval, first: Interval, second: Interval) -> Series:
    """Return functions with bounds of their value, first and second derivative."""
    return Series((value, first, second * exactly(0.5)))


def sine_and_cosine_of(angle: Series) -> tuple[Series, Series]:
    sine, cosine = sine_and_cosine(angle.terms[0])
    if len(angle.terms) == 1:
        return Series((sine,)), Series((cosine,))
    _, rate, bend = angle.terms
    half = rate * rate * exactly(0.5)
    return (
        Series((sine, cosine * rate, cosine * bend - sine * half)),
        Series((cosine, -(sine * rate), -(sine * bend + cosine * half))),
    )


State: TypeAlias = tuple[Series, Series, Series]
"""Positions, velocities and accelerations of all coordinates, (m, n) each."""

SYMMETRIC = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
"""Places of the numbers of a symmetric matrix."""


@dataclass(frozen=True, eq=False)
class Load:
    """A rigid body that a joint carries.

    Attributes:
        mass: Its mass [kg].
        centre: In the joint's frame, shape (3,) [m].
        moments: Of inertia about the centre, along joint axes: xx, xy, xz, yy, yz, zz, shape (6,) [kg m^2].
    """

    joint: int
    mass: float
    centre: Floats
    moments: Floats


@dataclass(frozen=True, eq=False)
class Masses:
    """Loads and motors.

    Attributes:
        gravity: Acceleration of free fall, shape (3,) [m/s^2].
        rotors: Inertia of each joint's motor, as seen from the joint, shape (joints,) [kg m^2 | kg].
    """

    gravity: Floats
    loads: list[Load]
    rotors: Floats


def torques(statement: Statement, masses: Masses, state: State) -> list[Series]:
    """Return the torques or forces of coordinates, following joints included, (m,) each."""
    total = [constant(0.0)] * state[0].terms[0].low.shape[1]
    motion = [_followed(joint, state) for joint in statement.joints]
    needed = _of_joints(statement.joints, masses, motion)
    for joint, own, rotor, state_of in zip(statement.joints, needed, masses.rotors, motion, strict=True):
        whole = own + state_of[2].times(mul, constant(rotor))
        total[joint.coordinate] = total[joint.coordinate] + whole.times(mul, constant(joint.factor))
    return total


def _followed(joint: StatedJoint, state: State) -> State:
    position, velocity, acceleration = (
        each.map(lambda term: term[:, joint.coordinate] * exactly(joint.factor)) for each in state
    )
    return position + constant(joint.offset), velocity, acceleration


def _of_joints(joints: list[StatedJoint], masses: Masses, motion: list[State]) -> list[Series]:
    still = constant(np.zeros(3))
    places = [_placed(joint, position) for joint, (position, _, _) in zip(joints, motion, strict=True)]
    spin, swing, push = [still], [still], [constant(-masses.gravity)]
    for joint, (turn, shift), (_, velocity, acceleration) in zip(joints, places, motion, strict=True):
        parent, inward = joint.place.joint, turn.map(lambda each: each.transposed)
        push.append(_turned(inward, push[parent] + _accelerated(spin[parent], swing[parent], shift)))
        spin.append(_turned(inward, spin[parent]))
        swing.append(_turned(inward, swing[parent]))
        rate, increase = _along(joint.axis, velocity), _along(joint.axis, acceleration)
        aside = _cross(spin[-1], rate)
        if joint.turns:
            spin[-1], swing[-1] = spin[-1] + rate, swing[-1] + aside + increase
        else:
            push[-1] = push[-1] + aside + aside + increase
    force, moment = [still] * len(spin), [still] * len(spin)
    for load in masses.loads:
        at, centre, inertia = load.joint, constant(load.centre), constant(load.moments[SYMMETRIC])
        inertial = (push[at] + _accelerated(spin[at], swing[at], centre)).times(mul, constant(load.mass))
        turning_moment = _turned(inertia, swing[at]) + _cross(spin[at], _turned(inertia, spin[at]))
        force[at] = force[at] + inertial
        moment[at] = moment[at] + turning_moment + _cross(centre, inertial)
    found: list[Series] = []
    for number in range(len(joints), 0, -1):
        joint, (turn, shift) = joints[number - 1], places[number - 1]
        borne = moment[number] if joint.turns else force[number]
        found.insert(0, borne.times(dot, Series((joint.axis,))))
        outer, parent = _turned(turn, force[number]), joint.place.joint
        force[parent] = force[parent] + outer
        moment[parent] = moment[parent] + _turned(turn, moment[number]) + _cross(shift, outer)
    return found


def _placed(joint: StatedJoint, position: Series) -> tuple[Series, Series]:
    """Return the rotation and the origin of a joint's frame in its parent's."""
    still, of_sine, of_cosine = turning(joint)
    sine, cosine = sine_and_cosine_of(position)
    turn = sine.map(lambda each: each[:, None, None] * of_sine)
    turn = turn + cosine.map(lambda each: each[:, None, None] * of_cosine) + Series((still,))
    return turn, Series((joint.place.translation,)) + _along(slide(joint), position)


def _along(axis: Interval, size: Series) -> Series:
    return size.map(lambda each: each[:, None] * axis)


def _accelerated(spin: Series, swing: Series, arm: Series) -> Series:
    """Return the acceleration of the end of an arm against its begin."""
    return _cross(swing, arm) + _cross(spin, _cross(spin, arm))


def _cross(one: Series, other: Series) -> Series:
    return one.times(cross, other)


def _turned(matrix: Series, vector: Series) -> Series:
    return matrix.times(turned, vector)
