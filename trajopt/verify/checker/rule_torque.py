"""Rules: torques of coordinates, or of gravity at rest, stay below limits at all times.

At ends at rest the torques at rest count too. In each cell of the grid a torque is within its second
derivative times h^2/8 of its chord.
"""

from functools import partial

import numpy as np
from intervals import Interval, down, exactly, up
from inverse_dynamics import Load, Masses, Series, State, over_cells, torques
from kinematics import GridKinematics
from reading import Fields, below, every, numbers, record, row, size, text
from requirement import Bools, StatedRequirement, off_chord
from statement import MOST_JOINTS, Statement


def _read(value: Fields, statement: Statement, *, still: bool) -> StatedRequirement:
    joints, names = statement.joints, statement.curve.coordinates
    load = row(below(len(joints) + 1), size, numbers(3), numbers(6))
    heavy = {"gravity": numbers(3), "loads": every(load, MOST_JOINTS), "rotors": numbers(len(joints))}
    limit = row(below(len(names)), size)
    _, gravity, loads, rotors, limits = record(
        "torque", value, {"kind": text, **heavy, "limits": every(limit)}
    )
    masses, rows = Masses(gravity, [Load(*each) for each in loads], rotors), list[tuple[int, float]](limits)

    def holds(arm: GridKinematics) -> Bools:
        bounds = arm.motion.bounds
        wide = over_cells(*bounds[:3]), over_cells(*bounds[1:4]), over_cells(*bounds[2:])
        states = [_at_rest(state) if still else state for state in (wide, *_states(arm))]
        over, begin, end, at_rest = (torques(statement, masses, state) for state in states)
        kept = np.ones(len(arm.grid) - 1, dtype=np.bool_)
        for coordinate, stated in rows:
            most = down(down(1.0 + statement.excess) * stated)
            sides = np.maximum(*(each[coordinate].terms[0].size for each in (begin, end)))
            kept &= up(sides + off_chord(arm, 2.0 * over[coordinate].terms[2].size)) <= most
            held = at_rest[coordinate].terms[0].size <= most
            kept[0] &= held[0] or statement.ends.velocities.any()
            kept[-1] &= held[1] or not statement.ends.rests
        return kept

    words = ", ".join(f"{names[coordinate]} {stated:g}" for coordinate, stated in rows)
    of_gravity = " of gravity" * still
    return StatedRequirement(f"at all times torques{of_gravity} (Nm or N) are at most: {words}", holds)


read, read_gravity = partial(_read, still=False), partial(_read, still=True)


def _at_rest(state: State) -> State:
    none = Series((exactly(np.zeros_like(state[0].terms[0].low)),))
    return state[0], none, none


def _states(arm: GridKinematics) -> list[State]:
    """Return the states at the begin and the end of each cell, and at rest at the start and the end."""
    motion = arm.motion
    still = exactly(np.zeros((2, motion.positions.low.shape[1])))
    return [
        _at_times(motion.positions[:-1], motion.velocities[:-1], motion.accelerations[0]),
        _at_times(motion.positions[1:], motion.velocities[1:], motion.accelerations[1]),
        _at_times(motion.positions[[0, -1]], still, still),
    ]


def _at_times(position: Interval, velocity: Interval, acceleration: Interval) -> State:
    return Series((position,)), Series((velocity,)), Series((acceleration,))
