"""The statement of a proof: robot, motion, parts and pairs, limits and requirements."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import reading as take
from intervals import Floats, Interval, exactly, normalised, rotation_of
from reading import Fields, Reader
from shapes import Shape, read_shape

MOST_JOINTS = 1_000
MOST_PARTS = 5_000
MOST_KNOTS = 20_000
LARGEST_EXCESS = 1e-3


def record_of(kind: type[Any]) -> Reader:
    """Return a reader of objects: each field of a dataclass is annotated with its reader."""
    return lambda where, value: kind(*take.record(where, value, _readers(kind)))


def row_of(kind: type[Any]) -> Reader:
    """Return a reader of lists, likewise."""
    return lambda where, value: kind(*take.row(*_readers(kind).values())(where, value))


def _readers(kind: type[Any]) -> Mapping[str, Reader]:
    return {name: each.__metadata__[0] for name, each in kind.__annotations__.items()}


def _point(where: str, value: object) -> Interval:
    return exactly(take.numbers(3)(where, value))


@dataclass(frozen=True, eq=False)
class FixedPlace:
    """A fixed placement in a joint's frame.

    Attributes:
        rotation: Shape (3, 3).
        translation: Shape (3,) [m].
    """

    joint: Annotated[int, take.below(MOST_JOINTS + 1)]
    rotation: Annotated[Interval, take.direction(4, rotation_of)]
    translation: Annotated[Interval, _point]


@dataclass(frozen=True, eq=False)
class StatedJoint:
    """A joint, which turns about or slides along an axis of its own frame.

    Attributes:
        place: Of its frame at position 0, in its parent's.
        axis: Of length 1, shape (3,).
        coordinate: The number of the motion's coordinate that it follows.
        factor: Its position is factor * coordinate + offset.
        offset: Likewise [rad | m].
        lower: Least position [rad | m]; infinite for none, as the others.
        upper: Largest position [rad | m].
    """

    name: Annotated[str, take.text]
    place: Annotated[FixedPlace, record_of(FixedPlace)]
    turns: Annotated[bool, take.flag]
    axis: Annotated[Interval, take.direction(3, normalised)]
    coordinate: Annotated[int, take.below(MOST_JOINTS)]
    factor: Annotated[float, take.number]
    offset: Annotated[float, take.number]
    lower: Annotated[float, take.least]
    upper: Annotated[float, take.most]
    velocity: Annotated[float, take.most]
    acceleration: Annotated[float, take.most]
    jerk: Annotated[float, take.most]

    def followed(self, values: Interval) -> Interval:
        """Return factor * coordinate, or a derivative of its position, from those of all coordinates."""
        return values[:, self.coordinate] * exactly(self.factor)


@dataclass(frozen=True, eq=False)
class HermiteCurve:
    """The coordinates over time: Hermite interpolants between knots, cubic without accelerations.

    Attributes:
        times: Of the k knots, from 0, shape (k,) [s]. Drives may have one twice: before and after a jump.
        values: Positions, velocities and, of quintics, accelerations, each of shape (k, n).
    """

    coordinates: Annotated[list[str], take.every(take.text, MOST_JOINTS)]
    times: Annotated[Floats, take.numbers(None)]
    values: Annotated[list[Floats], take.every(take.numbers(None, None), 3)]


def _curve(where: str, value: object) -> HermiteCurve:
    found = record_of(HermiteCurve)(where, value)
    times, shape = found.times, (len(found.times), len(found.coordinates))
    ordered = 2 <= len(times) <= MOST_KNOTS and times[0] == 0.0 and (np.diff(times) >= 0.0).all()
    take.demand(ordered, f"the times of {where} must increase from 0, and be 2 to {MOST_KNOTS}")
    whole = len(found.values) >= 2 and all(each.shape == shape for each in found.values)
    take.demand(whole, f"{where} needs positions and velocities of each coordinate at each time")
    return found


@dataclass(frozen=True, eq=False)
class Change:
    """An object that is there only from `appears` to `expires` [s], or is only near its place.

    Attributes:
        error: Radius r [m], velocity v [m/s] and acceleration a [m/s^2]: at time t no point of it is farther
            than r + v t + a t^2 / 2 from its place.
    """

    owner: Annotated[str, take.text]
    appears: Annotated[float, take.least]
    expires: Annotated[float, take.most]
    error: Annotated[list[float], take.row(*[take.size] * 3)]


@dataclass(frozen=True, eq=False)
class EndStates:
    """The state in which the motion must start, and how it must end.

    Attributes:
        positions: Of the coordinates at the start, shape (n,), as the others.
        accelerations: Likewise; not checked if all are 0, except for jumps if jerk is limited.
        speed: Of velocities and accelerations, and of the rest at the end.
    """

    positions: Annotated[Floats, take.numbers(None)]
    velocities: Annotated[Floats, take.numbers(None)]
    accelerations: Annotated[Floats, take.numbers(None)]
    tolerance: Annotated[float, take.size]
    speed: Annotated[float, take.size]
    rests: Annotated[bool, take.flag]


@dataclass(frozen=True, eq=False)
class ConvexPart:
    """A convex part of a link or object."""

    owner: Annotated[str, take.text]
    place: Annotated[FixedPlace, record_of(FixedPlace)]
    shape: Annotated[Shape, read_shape]


_part, _owners = take.below(MOST_PARTS), (take.text, take.text)
_window = take.row(*_owners, take.least, take.most)


@dataclass(frozen=True, eq=False)
class Statement:
    """Everything that a proof states.

    Attributes:
        drives: Coordinates that follow time, independent of the robot; numbered after the motion's.
        joints: The joints, each after its parent; joint number i is at i - 1.
        excess: By how much limits and tolerances may be exceeded: of positions absolute or relative to the
            limit, the larger; of rates and torques relative; of requirements absolute.
        pairs: Two parts and the clearance that they keep [m].
        excused: Two owners that need not keep apart, and the reason.
        contacts: Two owners that keep apart only from the first time until the second [s].
        judged: Sentences on facts that were judged, but are not part of the proof.
    """

    title: Annotated[str, take.text]
    motion: Annotated[HermiteCurve, _curve]
    drives: Annotated[list[HermiteCurve], take.every(_curve, MOST_JOINTS)]
    joints: Annotated[list[StatedJoint], take.every(record_of(StatedJoint), MOST_JOINTS)]
    ends: Annotated[EndStates, record_of(EndStates)]
    excess: Annotated[float, take.between(0.0, LARGEST_EXCESS)]
    parts: Annotated[list[ConvexPart], take.every(record_of(ConvexPart), MOST_PARTS)]
    changes: Annotated[list[Change], take.every(row_of(Change))]
    pairs: Annotated[list[tuple[int, int, float]], take.every(take.row(_part, _part, take.size))]
    excused: Annotated[list[tuple[str, str, str]], take.every(take.row(*_owners, take.text))]
    contacts: Annotated[list[tuple[str, str, float, float]], take.every(_window)]
    requirements: Annotated[list[Fields], take.every(take.mapping)]
    judged: Annotated[list[str], take.every(take.text)]


def read_statement(value: Fields) -> Statement:
    """Read a statement, and check that its numbers of joints, coordinates and parts are there."""
    found: Statement = record_of(Statement)("statement", value)
    motion, joints, count = found.motion, found.joints, len(found.motion.coordinates)
    whole = all(each.times[-1] >= motion.times[-1] for each in found.drives) and np.diff(motion.times).all()
    take.demand(whole, "the times of the motion must increase, and drives must last until its end")
    coordinates = count + sum(len(each.coordinates) for each in found.drives)
    for at, joint in enumerate(joints):
        take.demand(joint.place.joint <= at, "a joint must come after its parent")
        take.demand(joint.coordinate < coordinates, "a joint must follow a coordinate that is stated")
        free = joint.coordinate < count or joint.jerk == np.inf
        take.demand(free, "a joint that follows time cannot have a limit of jerk")
    ends = found.ends.positions, found.ends.velocities, found.ends.accelerations
    take.demand(all(len(each) == count for each in ends), "ends must have a number for each coordinate")
    there = all(part.place.joint <= len(joints) for part in found.parts)
    there &= all(max(pair[:2]) < len(found.parts) for pair in found.pairs)
    take.demand(there, "parts must have joints, and pairs must have parts, that are stated")
    sides = {(part.owner, part.place.joint) for part in found.parts}
    take.demand(len(sides) == len(dict(sides)), "the parts of an owner must be on one joint")
    take.demand(len({each.owner for each in found.changes}) == len(found.changes), "an owner has two changes")
    take.demand(all(reason.strip() for *_, reason in found.excused), "an excuse needs a reason")
    return found


def place_in(joints: int) -> Reader:
    """Return a reader of placements in the frame of one of some joints, or of the world."""
    known = take.that(lambda place: place.joint <= joints, f"on one of {joints} joints, or on the world")
    return lambda where, value: known(where, record_of(FixedPlace)(where, value))
