"""Rules: torques of coordinates, or of gravity at rest, stay below limits at all times.

At ends at rest the torques at rest count too. In each cell of the grid a torque is within its second
derivative times h^2/8 of its chord.
"""

from functools import partial
from operator import mul, neg
from typing import TypeAlias

import numpy as np
from intervals import Floats, cross, dot, down, exactly, turned, up
from kinematics import GridKinematics, frames
from reading import Fields, below, every, numbers, record, row, size, text
from requirement import Bools, StatedRequirement, off_chord
from series import Series, constant, taylor
from statement import MOST_JOINTS, StatedJoint, Statement

Masses: TypeAlias = tuple[Floats, list[tuple[int, float, Floats, Floats]], Floats]
"""Acceleration of free fall [m/s^2]; joint, mass [kg], centre of mass [m] and moments of inertia about it
[kg m^2] of loads, along the axes of the joint; inertia of each joint's motor, as seen from it [kg m^2 | kg].
"""
SYMMETRIC = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
"""Places of xx, xy, xz, yy, yz, zz in a symmetric matrix."""


def _read(value: Fields, statement: Statement, *, still: bool) -> StatedRequirement:
    joints, names = len(statement.joints), statement.motion.coordinates
    load, limit = row(below(joints + 1), size, numbers(3), numbers(6)), row(below(len(names)), size)
    heavy = {"gravity": numbers(3), "loads": every(load, MOST_JOINTS), "rotors": numbers(joints)}
    readers = {"kind": text, **heavy, "limits": every(limit)}
    _, gravity, loads, rotors, rows = record("torque", value, readers)
    masses, limits = (gravity, loads, rotors), list[tuple[int, float]](rows)

    def holds(arm: GridKinematics) -> Bools:
        at, speed, (after, before) = arm.motion.positions, arm.motion.velocities, arm.motion.accelerations
        ends, zero = at[[0, -1]], exactly(np.zeros_like(at.low[:2]))
        first, last = (at[:-1], speed[:-1], after), (at[1:], speed[1:], before)
        over, begin, end, at_rest = (
            torques(statement.joints, taylor(*orders), masses, still=still)
            for orders in (arm.motion.bounds, first, last, (ends, zero, zero))
        )
        kept = np.ones(len(arm.grid) - 1, dtype=np.bool_)
        for coordinate, stated in limits:
            most = down(down(1.0 + statement.excess) * stated)
            sides = np.maximum(*(each[coordinate].terms[0].size for each in (begin, end)))
            kept &= up(sides + off_chord(arm, 2.0 * over[coordinate].terms[2].size)) <= most
            held = at_rest[coordinate].terms[0].size <= most
            kept[0] &= held[0] or statement.ends.velocities.any()
            kept[-1] &= held[1] or not statement.ends.rests
        return kept

    words = f"at all times torques{' of gravity' * still} (Nm or N) of {len(loads)} loads,"
    words += f" {sum(each[1] for each in loads):g} kg in all, are at most: "
    named = ", ".join(f"{names[coordinate]} {stated:g}" for coordinate, stated in limits)
    return StatedRequirement(words + named, holds)


read, read_gravity = partial(_read, still=False), partial(_read, still=True)


def torques(joints: list[StatedJoint], positions: Series, masses: Masses, *, still: bool) -> list[Series]:
    """Return the torques or forces of coordinates, following joints included, (m,) each.

    Source: Luh, Walker and Paul, On-line computational scheme for mechanical manipulators, 1980; here all
    vectors are along the axes of the world.

    Args:
        positions: Of the coordinates, (m, n) each.
        still: Whether the arm rests at each position.
    """
    (gravity, loads, rotors), terms, places = masses, len(positions.terms), frames(joints, positions)
    none = constant(exactly(np.zeros(3)), terms)
    force, moment, axes, spins = [none] * len(places), [none] * len(places), [none], [none]
    for joint in joints:
        turn, spin = places[joint.place.joint][0], spins[joint.place.joint]
        axes.append(turn.map(partial(turned, vector=turned(joint.place.rotation, joint.axis))))
        turning = axes[-1].times(lambda axis, rate: axis * rate[:, None], positions.map(joint.followed).rate)
        spins.append(spin + turning if joint.turns else spin)
    for at, mass, centre, moments in loads:
        (turn, origin), inertia = places[at], exactly(moments[SYMMETRIC])
        lever = turn.map(partial(turned, vector=exactly(centre)))
        push, spun = constant(exactly(-gravity) * exactly(mass), terms), none
        if not still:
            push = push + (origin + lever).rate.rate.map(partial(mul, exactly(mass)))
            inward = turn.map(lambda each: each.transposed).times(turned, spins[at])
            spun = turn.times(turned, inward.map(partial(turned, inertia))).rate
        force[at], moment[at] = force[at] + push, moment[at] + spun + lever.times(cross, push)
    needed = [constant(exactly(0.0), terms)] * positions.terms[0].low.shape[1]
    for number in range(len(joints), 0, -1):
        joint, parent = joints[number - 1], joints[number - 1].place.joint
        own = axes[number].times(dot, (moment if joint.turns else force)[number])
        if not still:
            own = own + positions.map(joint.followed).rate.rate.map(partial(mul, exactly(rotors[number - 1])))
        needed[joint.coordinate] = needed[joint.coordinate] + own.map(partial(mul, exactly(joint.factor)))
        lever = places[number][1] + places[parent][1].map(neg)
        force[parent] = force[parent] + force[number]
        moment[parent] = moment[parent] + moment[number] + lever.times(cross, force[number])
    return needed
