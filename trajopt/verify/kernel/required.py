"""The clearance that each pair must keep, read by the judge from what the scene states."""

from collections.abc import Mapping, Sequence, Set

import numpy as np
import pinocchio as pin

from trajopt.scene.clearances import PairKind
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Ints, readonly
from trajopt.values.placement import WORLD

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
        return [("clearance", np.flatnonzero(required == level)) for level in sorted(set(required.tolist()))]
    kinds = reduced.derived(_kinds)
    found: list[tuple[str, Ints]] = []
    for number, kind in enumerate(PairKind):
        mine = kinds == number
        levels = sorted(set(required[mine].tolist()))
        found += [(ROWS[kind], np.flatnonzero(mine & (required == level))) for level in levels]
    return found


def _required(reduced: ReducedModel) -> Floats:
    scene, stated = reduced.scene, reduced.scene.clearances
    if not (stated.pairs or stated.links or stated.kinds):
        return readonly(np.full(len(reduced.pairs.first), stated.everywhere))
    world = _of_the_world(scene)
    pairs = _owners(reduced)
    known = {pair: _of(scene, world, *sorted(pair)) for pair in set(pairs)}
    return readonly(np.array([known[pair] for pair in pairs], dtype=np.float64))


def _of(scene: Scene, world: Set[str], one: str, other: str) -> float:
    """Return the clearance that is required of two links or objects [m]."""
    stated = scene.clearances
    single = stated.pairs.get(frozenset((one, other)))
    if single is not None:
        return single
    meant = _meant(scene, world, one, other)
    value = max([stated.kinds[kind] for kind in meant if kind in stated.kinds] or [stated.everywhere])
    carriers = [scene.holder(name).link for name in (one, other)]
    if WORLD in carriers:
        value = max([value, *(stated.links.get(carrier, 0.0) for carrier in carriers)])
    return value


def _meant(scene: Scene, world: Set[str], one: str, other: str) -> tuple[PairKind, ...]:
    """Return the kinds whose clearance two links or objects keep, the one that they are of first."""
    among = (PairKind.WORLD,) if world & {one, other} else ()
    held = [name for name in (one, other) if name in scene.objects and name not in world]
    return among + ((PairKind.CARRIED,) if held else ()) or (PairKind.ROBOT,)


def _of_the_world(scene: Scene) -> frozenset[str]:
    """Return the links and objects that stand in the world.

    An object does unless a joint of the robot, of the group or not, moves it; a link if it carries no joint
    and nothing that has a shape is between it and the root, which has none.
    """
    parents, moving = _tree(scene)
    above = {link: _above(parents, link) for link in scene.robot.links}
    carrying = {name for link in moving for name in above[link]}
    between = {*moving, *(body.owner for body in scene.robot.bodies)}
    found = {
        link
        for link in scene.robot.links
        if above[link] and link not in moving | carrying and not between.intersection(above[link])
    }
    for name in scene.objects:
        holder = scene.holder(name).link
        if holder == WORLD or not moving.intersection((holder, *above[holder])):
            found.add(name)
    return frozenset(found)


def _tree(scene: Scene) -> tuple[dict[str, str], set[str]]:
    """Return the link that each link hangs on, and the links that hang there by a joint that moves."""
    frames, parents, moving = scene.robot.model.frames, dict[str, str](), set[str]()
    for frame in frames:
        if frame.type != pin.FrameType.BODY or frame.parentFrame == 0:
            continue
        joint = frames[frame.parentFrame]
        if joint.parentFrame > 0:
            parents[frame.name] = frames[joint.parentFrame].name
        if joint.type == pin.FrameType.JOINT:
            moving.add(frame.name)
    return parents, moving


def _above(parents: Mapping[str, str], link: str) -> list[str]:
    """Return the links between a link and the root, with the root."""
    found: list[str] = []
    while link in parents:
        link = parents[link]
        found.append(link)
    return found


def _kinds(reduced: ReducedModel) -> Ints:
    """Return the number of each pair's kind, shape (p,)."""
    order, scene, pairs = tuple(PairKind), reduced.scene, _owners(reduced)
    world = _of_the_world(scene)
    first = {pair: order.index(_meant(scene, world, *sorted(pair))[0]) for pair in set(pairs)}
    return np.array([first[pair] for pair in pairs], dtype=np.int64)


def _owners(reduced: ReducedModel) -> list[frozenset[str]]:
    return [frozenset(reduced.owners(pair)) for pair in range(len(reduced.pairs.first))]
