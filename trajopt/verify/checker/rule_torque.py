"""Rules: torques of coordinates, or of gravity at rest, stay below limits at all times.

At ends at rest the torques at rest count too. In each cell of the grid a torque is within its second
derivative times h^2/8 of its chord.
"""

from functools import partial
from operator import mul, neg
from typing import TypeAlias

import numpy as np
from intervals import Floats, Interval, cross, dot, down, exactly, product, turned, up
from kinematics import GridKinematics, frames
from reading import Fields, below, every, numbers, record, row, size, text
from requirement import Bools, StatedRequirement, off_chord
from series import Series, constant, taylor
from statement import MOST_JOINTS, StatedJoint, Statement

Masses: TypeAlias = tuple[Floats, list[tuple[int, float, Floats, Floats]], Floats]
"""Acceleration of free fall [m/s^2]; joint, mass [kg], centre of mass [m] and moments of inertia about it
xx, xy, xz, yy, yz, zz [kg m^2] of loads, along the axes of the joint; inertia of each joint's motor, as seen
from it [kg m^2 | kg].
"""


def _read(value: Fields, statement: Statement, *, inert: float) -> StatedRequirement:
    joints, names = len(statement.joints), statement.motion.coordinates
    load, limit = row(below(joints + 1), size, numbers(3), numbers(6)), row(below(len(names)), size)
    heavy = {"gravity": numbers(3), "loads": every(load, MOST_JOINTS), "rotors": numbers(joints)}
    _, *masses, limits = record("torque", value, {"kind": text, **heavy, "limits": every(limit)})

    def holds(arm: GridKinematics) -> Bools:
        at, speed, (after, before) = arm.motion.positions, arm.motion.velocities, arm.motion.accelerations
        first, last = (at[:-1], speed[:-1], after), (at[1:], speed[1:], before)
        still = at[[0, -1]], *[exactly(np.zeros_like(at.low[:2]))] * 2
        series = (taylor(*orders) for orders in (arm.motion.bounds, first, last, still))
        over, *sides, at_rest = (torques(statement.joints, each, tuple(masses), inert) for each in series)
        kept = np.ones(len(arm.grid) - 1, dtype=np.bool_)
        for coordinate, stated in list[tuple[int, float]](limits):
            most = down(down(1.0 + statement.excess) * stated)
            at_ends = np.maximum(*(each[coordinate].terms[0].size for each in sides))
            kept &= up(at_ends + off_chord(arm, 2.0 * over[coordinate].terms[2].size)) <= most
            held = at_rest[coordinate].terms[0].size <= most
            kept[0] &= held[0] or statement.ends.velocities.any()
            kept[-1] &= held[1] or not statement.ends.rests
        return kept

    named = ", ".join(f"{names[at]} {most:g}" for at, most in limits)
    words = f"at all times torques{' of gravity' * (not inert)} of {sum(load[1] for load in masses[1]):g} kg"
    return StatedRequirement(f"{words} are at most (Nm or N): {named}", holds)


read, read_gravity = partial(_read, inert=1.0), partial(_read, inert=0.0)


def torques(joints: list[StatedJoint], positions: Series, masses: Masses, inert: float) -> list[Series]:
    """Return the torques or forces of coordinates, following joints included, (m,) each.

    Source: Luh, Walker and Paul, On-line computational scheme for mechanical manipulators, 1980; here all
    vectors are along the axes of the world. With the rotation R of a load and its second moments of mass J
    the moment of its inertia is the sum of the cross products of the columns of R J and R''.

    Args:
        positions: Of the coordinates, (m, n) each.
        inert: 1, or 0 for an arm that rests at each position.
    """
    (gravity, loads, rotors), terms, places = masses, len(positions.terms), frames(joints, positions)
    none = constant(exactly(np.zeros(3)), terms)
    force, moment = [none] * len(places), [none] * len(places)
    for at, mass, centre, moments in loads:
        (turn, origin), inertia = places[at], exactly(inert * moments[[[0, 1, 2], [1, 3, 4], [2, 4, 5]]])
        lever = turn.map(partial(turned, vector=exactly(centre)))
        moved = (origin + lever).rate.rate.map(partial(mul, exactly(inert * mass)))
        push = moved.plus(exactly(-gravity) * exactly(mass))
        second = exactly(np.eye(3) / 2.0) * inertia[[0, 1, 2], [0, 1, 2]].sum() - inertia
        spun = turn.map(partial(product, other=second)).times(_crossed_columns, turn.rate.rate)
        force[at], moment[at] = force[at] + push, moment[at] + spun + lever.times(cross, push)
    needed = [constant(exactly(0.0), terms)] * positions.terms[0].low.shape[1]
    for number in range(len(joints), 0, -1):
        joint, parent = joints[number - 1], joints[number - 1].place.joint
        axis = places[parent][0].map(partial(turned, vector=turned(joint.place.rotation, joint.axis)))
        motor = positions.map(joint.followed).rate.rate.map(partial(mul, exactly(inert * rotors[number - 1])))
        own = axis.times(dot, (moment if joint.turns else force)[number]) + motor
        needed[joint.coordinate] += own.map(partial(mul, exactly(joint.factor)))
        lever = places[number][1] + places[parent][1].map(neg)
        force[parent] += force[number]
        moment[parent] += moment[number] + lever.times(cross, force[number])
    return needed


def _crossed_columns(one: Interval, other: Interval) -> Interval:
    return cross(one.transposed, other.transposed).transposed.sum()
