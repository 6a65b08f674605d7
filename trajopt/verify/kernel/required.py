"""The clearance that each pair must keep, read by the judge from what the scene states."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats, Ints, readonly
from trajopt.model.collisions.clearances import PairKind
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import WORLD
from trajopt.model.scene import Scene

ROWS = {
    PairKind.WORLD: "clearance from the world",
    PairKind.CARRIED: "clearance of what is carried",
    PairKind.ROBOT: "clearance of the robot from itself",
}
"""Names of the checks, where the scene states what kinds of pairs keep."""


def required_clearances(reduced: ReducedModel) -> Floats:
    """Return the clearance that each pair must keep, shape (p,) [m], read-only.

    A single pair keeps what is stated of it. Others keep what is stated of their kinds, or else of
    everything; and between a link, with what it carries, and the world no less than the link's padding.
    """
    return reduced.derived(_required)


def rows(reduced: ReducedModel) -> Sequence[tuple[str, Ints]]:
    """Return names of the checks of clearance, and the pairs that each is about.

    There is one for every clearance that is required; where the scene states what kinds of pairs keep, one
    for every kind and clearance.
    """
    required, scene = required_clearances(reduced), reduced.scene
    if not scene.clearances.kinds:
        return [("clearance", np.flatnonzero(required == level)) for level in np.unique(required)]
    kinds = reduced.derived(_kinds)
    found: list[tuple[str, Ints]] = []
    for number, kind in enumerate(PairKind):
        mine = kinds == number
        found += [
            (ROWS[kind], np.flatnonzero(mine & (required == level))) for level in np.unique(required[mine])
        ]
    return found


def _required(reduced: ReducedModel) -> Floats:
    scene, stated = reduced.scene, reduced.scene.clearances
    if not (stated.pairs or stated.links or stated.kinds):
        return readonly(np.full(len(reduced.pairs.first), stated.everywhere))
    known: dict[frozenset[str], float] = {}
    values: list[float] = []
    for pair in _owners(reduced):
        if pair not in known:
            known[pair] = _of(scene, *sorted(pair))
        values.append(known[pair])
    return readonly(np.array(values, dtype=np.float64))


def _of(scene: Scene, one: str, other: str) -> float:
    """Return the clearance that is required of two links or objects [m]."""
    stated = scene.clearances
    single = stated.pairs.get(frozenset((one, other)))
    if single is not None:
        return single
    meant = _meant(scene, one, other)
    value = max([stated.kinds[kind] for kind in meant if kind in stated.kinds] or [stated.everywhere])
    carriers = [scene.holder(name).link for name in (one, other)]
    if WORLD in carriers:
        value = max([value, *(stated.links.get(carrier, 0.0) for carrier in carriers)])
    return value


def _meant(scene: Scene, one: str, other: str) -> tuple[PairKind, ...]:
    """Return the kinds whose clearance two links or objects keep, the one that they are of first."""
    objects = [name for name in (one, other) if name in scene.objects]
    held = [name for name in objects if _moves(scene, name)]
    world = (PairKind.WORLD,) if len(held) < len(objects) else ()
    carried = (PairKind.CARRIED,) if held else ()
    return world + carried or (PairKind.ROBOT,)


def _moves(scene: Scene, name: str) -> bool:
    """Say whether any joint of the robot, of the group or not, moves an object."""
    link = scene.holder(name).link
    if link == WORLD:
        return False
    frames = (frame for frame in scene.robot.model.frames if frame.type == pin.FrameType.BODY)
    return int(next(frame for frame in frames if frame.name == link).parentJoint) > 0


def _kinds(reduced: ReducedModel) -> Ints:
    """Return the number of each pair's kind, shape (p,)."""
    order, scene = tuple(PairKind), reduced.scene
    first = {pair: order.index(_meant(scene, *sorted(pair))[0]) for pair in set(_owners(reduced))}
    return np.array([first[pair] for pair in _owners(reduced)], dtype=np.int64)


def _owners(reduced: ReducedModel) -> list[frozenset[str]]:
    return [frozenset(reduced.owners(pair)) for pair in range(len(reduced.pairs.first))]
