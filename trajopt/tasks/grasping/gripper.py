"""Gripper: two fingers that close on an object."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from trajopt.geometry import evaluator
from trajopt.robot.joints import LimitKind
from trajopt.robot.loading.pinocchio_model import link_joint
from trajopt.robot.loading.srdf import EndEffector
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model, tool_frame
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, direction_of, floats, number, one_of, positive
from trajopt.values.errors import GripperError, NameNotFound, ShapeError, shown
from trajopt.values.errors.arguments import checked_class
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import placed_box


@checked_class
@dataclass(frozen=True, eq=False, kw_only=True)
class Gripper(Value):
    """A gripper with two fingers whose pads stay parallel.

    Attributes:
        tool: Link or tool frame between the pads, fixed to the hand.
        links: Links of hand and fingers, which may touch a held object.
        fingers: The links that press on the object.
        joint_names: The joints that drive the fingers.
        openings: Distances between the pads, increasing, shape (k,) [m].
        positions: Of those joints at each opening, shape (k, m) [rad | m].
        force: Largest force of each finger [N].
        approach: Direction from the hand to the pads in the tool frame, shape (3,), a unit vector.
        closing: Direction from one pad to the other in the tool frame, shape (3,), a unit vector.
        reach: Overlap of the pads' centres with an object before the hand would touch it [m].
        tips: Distance from the pads' centres to the ends of the fingers [m].
    """

    group: str
    tool: str
    links: tuple[str, ...]
    fingers: tuple[str, str]
    joint_names: tuple[str, ...]
    openings: Floats
    positions: Floats
    force: float
    approach: Floats
    closing: Floats
    reach: float = 0.03
    tips: float = 0.0

    def __post_init__(self) -> None:
        openings = floats("openings", self.openings, (None,))
        if len(openings) < 2 or (np.diff(openings) <= 0.0).any() or openings[0] < 0.0:
            raise ShapeError("openings", "need two or more, not negative and increasing")
        positions = floats("positions", self.positions, (len(openings), len(self.joint_names)))
        approach, closing = (direction_of(name, getattr(self, name)) for name in ("approach", "closing"))
        if abs(float(approach @ closing)) > 1e-3:
            raise ShapeError("closing", "is not at a right angle to the approach direction")
        positive("force", self.force)
        positive("reach", self.reach)
        if number("tips", self.tips) < 0.0:
            raise ShapeError("tips", f"is negative: {self.tips:g} m")
        for name, value in (
            ("openings", openings),
            ("positions", positions),
            ("approach", approach),
            ("closing", closing),
        ):
            object.__setattr__(self, name, value)

    @property
    def narrowest(self) -> float:
        """Smallest distance between the pads [m]."""
        return float(self.openings[0])

    @property
    def widest(self) -> float:
        """Largest distance between the pads [m]."""
        return float(self.openings[-1])

    @property
    def axes(self) -> Placement:
        """Placement in the tool frame of a frame whose z axis is the approach and whose y the closing."""
        x = np.cross(self.closing, self.approach)
        return Placement(floats("axes", np.stack((x, self.closing, self.approach), axis=1), (3, 3)))

    def joints_at(self, opening: float) -> Mapping[str, float]:
        """Return the positions of the driven joints at an opening [m], joint -> position [rad | m].

        Raises:
            ShapeError: If the opening is out of range.
        """
        if not self.narrowest <= opening <= self.widest:
            raise ShapeError(
                "opening",
                f"{opening:g} m is not between {self.narrowest:g} and {self.widest:g} m, "
                "which is how far the fingers open",
            )
        columns = zip(self.joint_names, self.positions.T, strict=True)
        return {
            name: float(np.interp(opening, self.openings, np.asarray(column))) for name, column in columns
        }

    def opening_at(self, robot: Robot, positions: Floats) -> float:
        """Return the opening at positions of all joints, by the first driven joint [m]."""
        joint = float(positions[robot.index(self.joint_names[:1])][0])
        column = self.positions[:, 0]
        order = np.argsort(column)
        return float(np.interp(joint, column[order], self.openings[order]))

    def pressing(self, width: float, force: float) -> Mapping[str, float]:
        """Return the effort of the driven joints for a force of each finger [N], by joint [N | Nm].

        By virtual work, with equal contributions of the m joints to the opening: tau_i = -F d(opening)/dq_i,
        with d(opening)/dq_i = 1 / (m dq_i/d(opening)).

        Args:
            width: Between the pads [m].
        """
        return dict(zip(self.joint_names, (-force / self._yield(width)).tolist(), strict=True))

    def driven_together(self, robot: Robot, positions: Floats) -> Mapping[str, tuple[str, float, float]]:
        """Return the driven joints that follow the first in proportion, with factor and offset.

        The fingers have one drive, even if each is a joint of its own: independent fingers would not hold an
        object in place.

        Args:
            positions: Of all its joints; joints that are not in proportion are left out [rad | m].
        """
        first, lead = self.joint_names[0], self.positions[:, 0]
        stroke = float(lead[-1] - lead[0])
        found: dict[str, tuple[str, float, float]] = {}
        for joint, follows in zip(self.joint_names[1:], self.positions.T[1:], strict=True):
            factor = float(follows[-1] - follows[0]) / stroke if stroke else 0.0
            offset = float(follows[0] - factor * lead[0])
            here, there = positions[robot.index([first, joint])].tolist()
            strays = max(np.abs(factor * lead + offset - follows).max(), abs(factor * here + offset - there))
            if strays < IN_PROPORTION:
                found[joint] = first, factor, offset
        return found

    def _yield(self, width: float) -> Floats:
        place = int(np.clip(np.searchsorted(self.openings, width), 1, len(self.openings) - 1))
        rise = self.positions[place] - self.positions[place - 1]
        return len(self.joint_names) * rise / (self.openings[place] - self.openings[place - 1])

    def opened(self, robot: Robot, positions: Floats, opening: float) -> Floats:
        """Return positions of all joints with the fingers at an opening [rad | m].

        Args:
            positions: Of all joints, shape (number of joints,) [rad | m].
            opening: Distance between the pads [m].
        """
        moved = np.array(positions)
        for joint, value in self.joints_at(opening).items():
            moved[robot.index([joint])] = value
        return robot.followed(moved)


IN_PROPORTION = 1e-6
"""Largest deviation from proportion of joints with a common drive [rad | m]."""
PAST_PADS = 0.85
"""Share of the way from the pads' centres to the hand that an object may take."""
SAMPLES = 17
"""Number of measured openings."""
FAR = 10.0
"""Largest measured distance of the pads [m]."""
EQUAL = 0.95
"""Share of the distance of two fingers from the hand from which another moving link is a third finger."""


def gripper_of(
    robot: Robot | Scene, *, end_effector: str | None = None, tool: str | None = None, group: str = ""
) -> Gripper:
    """Return the gripper that a robot's SRDF describes, measured on its collision bodies.

    The group of the end effector must move two links towards each other: of a linkage the two farthest from
    the hand. Their distance is measured over the range of their joints; the approach direction leads from the
    link of the end effector to the tool frame.

    Args:
        robot: The robot; or a scene with it, whose tools count too.
        end_effector: Its name; optional if there is only one.
        tool: The frame between the pads; the last frame of the arm if None.
        group: Planning group; of several the one counts that most of its joints move.

    Raises:
        GripperError: If there is no end effector, or it is not a gripper with two fingers.
        NameNotFound: Without an end effector of that name.
        FrameNotFound: If there is no such tool frame.
    """
    for label, given in (("end_effector", end_effector), ("tool", tool)):
        if given is not None:
            one_of(label, given, str)
    given = robot if isinstance(robot, Scene) else Scene(one_of("robot", robot, Robot))
    robot, scene = given.robot, Scene(given.robot, tools=given.tools_on_links)
    effector, standing = _effector(robot, end_effector, one_of("group", group, str)), robot.positions()
    reduced = reduce_model(scene, effector.group, standing)
    limits = reduced.limits
    if not (np.isfinite(limits.lower).all() and np.isfinite(limits.upper).all()):
        raise GripperError(robot.name, f"the joints of group {shown(effector.group)} turn without end")
    if not np.isfinite(limits.effort).any():
        raise GripperError(robot.name, f"the joints of group {shown(effector.group)} have no effort limit")
    for joint, low, high in zip(limits.joint_names, limits.lower, limits.upper, strict=True):
        if low >= high:
            why = limits.because(joint, LimitKind.LOWER, LimitKind.UPPER)
            raise GripperError(robot.name, f"joint {joint} cannot move: its range is empty{why}")
    frame = tool_frame(reduce_model(scene, _arm(robot, effector), standing)) if tool is None else tool
    at, base = (scene.placement_of(name, standing) for name in (frame, effector.parent_link))
    ahead = at.translation - base.translation
    between = "name a frame between the pads (tool=; `Scene.with_tool` adds one)"
    aimless = (
        f"its tool frame {shown(frame)} is at {shown(effector.parent_link)}, the end effector's link, so "
        f"the approach has no direction; {between}, or a link behind it"
    )
    if np.linalg.norm(ahead) < 1e-6:
        raise GripperError(robot.name, aimless)
    if tool is None and reduced.attachment(frame)[0] > 0:
        reason = f"the last frame of its arm, {shown(frame)}, is a finger; {between}"
        raise GripperError(robot.name, reason)
    fingers, parted = _opposite(reduced, base.translation, ahead)
    closing = at.rotation.T @ parted.direction
    reach = at.rotation.T @ ahead
    approach = reach - (reach @ closing) * closing
    if np.linalg.norm(approach) < 1e-6:
        raise GripperError(robot.name, aimless)
    known = Gripper(
        group=effector.group,
        tool=frame,
        links=robot.group(effector.group).links,
        fingers=fingers,
        joint_names=reduced.joint_names,
        openings=parted.openings,
        positions=parted.positions,
        force=1.0,
        approach=approach,
        closing=closing,
    )
    return _sized(known, reduced, at)


def _sized(known: Gripper, reduced: ReducedModel, at: Placement) -> Gripper:
    """Return a gripper with its reach, tips and force; its tool is at a placement in the world."""
    axes = at * known.axes
    fronts = [
        float(placed_box(body.shape, axes.inverse() * body.placement)[1, 2])
        for body in reduced.bodies
        if body.joint == 0 and body.owner in known.links
    ]
    free = -max(fronts, default=-np.inf)
    if np.isfinite(free) and free > 0.0:
        known = replace(known, reach=PAST_PADS * free)
    ends = [
        placed_box(
            body.shape, axes.inverse() * reduced.scene.placement_of(body.frame, opened) * body.placement
        )
        for opened in (reduced.all_positions(row) for row in known.positions)
        for body in reduced.scene.robot.bodies
        if body.owner in known.fingers
    ]
    known = replace(known, tips=max(0.0, *(float(box[1, 2]) for box in ends)))
    # With a newton at each pad, the motor nearest to its limit decides how many there can be.
    each = np.abs(np.array(list(known.pressing((known.narrowest + known.widest) / 2.0, 1.0).values())))
    # Rounded to a micronewton, since the openings, of which it is a derivative, are.
    return replace(known, force=round(float((reduced.limits.effort / each).min()), 6))


def arm_of(robot: Robot, gripper: Gripper) -> str:
    """Return the group of the arm that carries a gripper."""
    for effector in robot.end_effectors.values():
        if effector.group == gripper.group:
            return _arm(robot, effector)
    raise GripperError(robot.name, f"its SRDF does not say what group {shown(gripper.group)} is mounted on")


@dataclass(frozen=True, eq=False)
class _Parted:
    """Two fingers: openings (k,) [m], positions (k, m) [rad | m], and the world direction between."""

    openings: Floats
    positions: Floats
    direction: Floats


def _opposite(reduced: ReducedModel, hand: Floats, ahead: Floats) -> tuple[tuple[str, str], _Parted]:
    """Return the moving links that press on an object: of those that part steadily the farthest ahead.

    Args:
        hand: Position in the world, shape (3,) [m].
        ahead: Direction from there to the pads, shape (3,).
    """
    far = {body.owner: 0.0 for body in reduced.bodies if body.joint > 0}
    for body in reduced.scene.robot.bodies:
        if body.owner in far:
            place = reduced.scene.placement_of(body.frame, reduced.start) * body.placement
            centre = placed_box(body.shape, place).mean(axis=0)
            far[body.owner] = max(far[body.owner], float((centre - hand) @ ahead))
    for pair in sorted(combinations(far, 2), key=lambda pair: -min(far[name] for name in pair)):
        parted = _parted(reduced, pair)
        if parted is None:
            continue
        enough = EQUAL * min(far[name] for name in pair)
        if all(far[name] < enough for name in far.keys() - pair):
            return pair, parted
        break
    reason = (
        f"group {shown(reduced.group)} should move two fingers with a shape that open steadily, moves "
        f"{', '.join(far) or 'none'}"
    )
    raise GripperError(reduced.scene.robot.name, reason)


def _parted(reduced: ReducedModel, fingers: tuple[str, str]) -> _Parted | None:
    limits = reduced.limits
    apart = reduce_model(reduced.scene.allow(*fingers, allowed=False), reduced.group, reduced.start)
    positions = limits.lower + np.linspace(0.0, 1.0, SAMPLES)[:, None] * (limits.upper - limits.lower)
    contacts = evaluator(apart).close_pairs(positions, np.full(len(apart.pairs.margin), FAR))
    between = [set(apart.owners(int(pair))) == set(fingers) for pair in contacts.pair]
    sample, distance = contacts.sample[between], contacts.distance[between]
    gaps = np.full(SAMPLES, np.inf)
    np.minimum.at(gaps, sample, distance)
    if not np.isfinite(gaps).all():
        return None
    widest = int(np.argmin(np.where(sample == int(np.argmax(gaps)), distance, np.inf)))
    if gaps[0] > gaps[-1]:
        gaps, positions = gaps[::-1], positions[::-1]
    # Fingers that overlap count as closed up to the last such position.
    first = max(int(np.argmax(gaps > 0.0)) - 1, 0)
    openings = np.maximum(gaps[first:], 0.0)
    if openings[-1] == 0.0 or (np.diff(openings) <= 0.0).any():
        return None
    return _Parted(openings, positions[first:], contacts.normal[between][widest])


def _effector(robot: Robot, name: str | None, group: str) -> EndEffector:
    known = {
        key: item
        for key, item in robot.end_effectors.items()
        if item.group in robot.groups and robot.group(item.group).joints
    }
    if name is not None:
        if name not in robot.end_effectors:
            raise NameNotFound("end effector", name, robot.end_effectors)
        if name not in known:
            raise GripperError(robot.name, f"end effector {shown(name)} has no joint to close")
        return known[name]
    if len(known) > 1 and group:
        joints = set(robot.group(group).joints)
        moved = {key: len(joints & joints_moving(robot, item.parent_link)) for key, item in known.items()}
        known = {key: known[key] for key, count in moved.items() if count == max(moved.values())}
    if len(known) != 1:
        reason = (
            "its SRDF names no <end_effector> with joints (`trajopt srdf` proposes one)"
            if not known
            else (f"it has several, {', '.join(known)}: pass gripper=gripper_of(robot, end_effector=...)")
        )
        raise GripperError(robot.name, reason)
    return next(iter(known.values()))


def joints_moving(robot: Robot, link: str) -> set[str]:
    model = robot.model
    return {str(model.names[each]) for each in model.supports[link_joint(model, link)]}


def _arm(robot: Robot, effector: EndEffector) -> str:
    if effector.parent_group:
        return effector.parent_group
    for group in robot.groups.values():
        if group.tip == effector.parent_link:
            return group.name
    raise GripperError(robot.name, f"no group ends at {shown(effector.parent_link)}; state its parent_group")
