"""Robot: kinematics, limits, groups, named states and collision bodies of one arm or several."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np
import pinocchio as pin

from trajopt.robot.bases import MovingBase, RobotBase
from trajopt.robot.bodies import CollisionBody, robot_bodies
from trajopt.robot.limits import JointLimits, LimitKind, not_stated, read_joint_limits, with_stated
from trajopt.robot.loading.base_joints import with_base
from trajopt.robot.loading.from_pinocchio import check_joints, described, group_elements
from trajopt.robot.loading.groups import Group
from trajopt.robot.loading.mimics import completed, followed, resolve_mimics
from trajopt.robot.loading.mjcf import read_mjcf
from trajopt.robot.loading.physics_notes import effort_notes, inertia_notes
from trajopt.robot.loading.pinocchio_model import (
    ModelData,
    adjacent_links,
    configuration,
    described_limits,
    fixed_joint_names,
    joint_unit,
    joint_units,
    link_names,
    model_data,
    model_of,
)
from trajopt.robot.loading.semantics import semantics_of
from trajopt.robot.loading.srdf import EndEffector, Srdf, read_srdf
from trajopt.robot.loading.urdf import LinkGeometry, Mimic, Urdf, read_urdf
from trajopt.robot.mesh_cover import MeshPolicy
from trajopt.values.arrays import (
    Floats,
    Ints,
    Value,
    floats,
    mapping,
    number,
    one_of,
    readonly,
    sequence,
    several,
    unless_none,
)
from trajopt.values.errors import (
    FileFormatError,
    FrameNotFound,
    GroupNotFound,
    JointNotFound,
    ModelError,
    ShapeError,
    StateNotFound,
    listed,
    shown,
)
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle
from trajopt.values.placement import IDENTITY, WORLD, Placement, PlacementLike, as_placement
from trajopt.values.printed import in_number, in_short


@dataclass(frozen=True)
class FrameAttachment:
    """A frame fixed to a link, such as the tool centre point.

    Attributes:
        link: Name of the link.
        placement: Of the frame in the link's frame.
    """

    link: str
    placement: Placement

    def __post_init__(self) -> None:
        """Take the placement in any of its forms."""
        object.__setattr__(self, "placement", as_placement("placement", self.placement))


def frame_attachment(name: str, value: FrameAttachment | tuple[str, PlacementLike]) -> FrameAttachment:
    """Return a frame fixed to a link, from a pair (link, placement) too.

    Raises:
        ShapeError: If it is neither.
    """
    if isinstance(value, FrameAttachment):
        return value
    if not isinstance(value, tuple) or len(value) != 2:  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ShapeError(name, f"is a link and a placement in it, is {shown(value)}")
    return FrameAttachment(one_of(name, value[0], str), as_placement(name, value[1]))


def tool_frames(
    frames: Mapping[str, FrameAttachment | tuple[str, PlacementLike]], links: Sequence[str]
) -> Mapping[str, FrameAttachment]:
    """Return the tool frames of a robot, checked against its links.

    Raises:
        ShapeError: If one is no link with a placement in it.
        FrameNotFound: If its link is unknown.
        ModelError: If it has the name of a link or of the world.
    """
    tools = {tool: frame_attachment(f"frame {shown(tool)}", at) for tool, at in frames.items()}
    for tool, frame in tools.items():
        if frame.link not in links:
            raise FrameNotFound("link", frame.link, links)
        if tool in links or tool == WORLD:
            raise ModelError(f"tool frame {shown(tool)} has the name of a link or of the world: rename it")
    return tools


FileName: TypeAlias = Path | str | None
Frames: TypeAlias = Mapping[str, FrameAttachment | tuple[str, PlacementLike]] | None


@dataclass(frozen=True, eq=False)
class RobotParts(Value):
    """The fields of a robot; `Robot` says what each is."""

    name: str
    model: pin.Model
    joint_names: tuple[str, ...]
    limits: JointLimits
    groups: Mapping[str, Group]
    states: Mapping[tuple[str, str], Mapping[str, float]]
    end_effectors: Mapping[str, EndEffector]
    passive_joints: frozenset[str]
    disabled_pairs: frozenset[frozenset[str]]
    mimics: Mapping[str, Mimic]
    frames: Mapping[str, FrameAttachment]
    bodies: tuple[CollisionBody, ...]
    visuals: tuple[LinkGeometry, ...]
    mesh_notes: tuple[str, ...]
    notes: tuple[str, ...]
    left_out: Mapping[str, str]
    base: RobotBase
    urdf_path: Path
    urdf_xml: str


@checked
@dataclass(frozen=True, eq=False)
class Beside:
    """What is asked of a robot beside its kinematics, as `Robot.from_urdf` says of each."""

    srdf: FileName
    limits: FileName
    frames: Frames
    name: str | None
    meshes: MeshPolicy | None

    def semantics(self) -> Srdf:
        """Return what the SRDF says; nothing where there is none."""
        return Srdf() if self.srdf is None else read_srdf(Path(self.srdf))

    def stated_limits(self) -> Mapping[str, Mapping[str, Any]]:
        """Return what the `joint_limits.yaml` says; nothing where there is none."""
        return {} if self.limits is None else read_joint_limits(Path(self.limits))


@checked
def parts_of_urdf(
    urdf: Path | str,
    package_dirs: Sequence[Path | str],
    xacro: Mapping[str, str] | None,
    base: MovingBase | None,
    beside: Beside,
) -> RobotParts:
    """Return the parts of a robot that files describe; as `Robot.from_urdf`."""
    written = read_urdf(Path(urdf), [Path(folder) for folder in package_dirs], xacro)
    return _parts_of_description(written, beside.semantics(), base, beside)


@checked
def parts_of_mjcf(file: Path | str, base: MovingBase | None, beside: Beside) -> RobotParts:
    """Return the parts of a robot of MuJoCo's; as `Robot.from_mjcf`."""
    written, stated = read_mjcf(Path(file))
    semantics = beside.semantics()
    semantics = replace(
        semantics,
        states={**semantics.states, **({} if semantics.groups else stated.states)},
        disabled_pairs=semantics.disabled_pairs | stated.disabled_pairs,
        passive_joints=semantics.passive_joints | stated.passive_joints,
    )
    return _parts_of_description(written, semantics, base, beside)


def _parts_of_description(
    written: Urdf, semantics: Srdf, base: MovingBase | None, beside: Beside
) -> RobotParts:
    """Return the parts of a robot that a URDF and an SRDF describe, files or not."""
    based = with_base(written, semantics, base)
    try:
        model = pin.buildModelFromXML(based.urdf.xml)
    except ValueError as error:
        reason = f"{error} (what is wrong is told above, on standard error)"
        raise FileFormatError(str(written.path), reason) from error
    fixed = fixed_joint_names(model)
    mimics, said = resolve_mimics(based.urdf.mimics, movable=tuple(model.names[1:]), fixed=fixed)
    description = replace(based.urdf, mimics=mimics, notes=(*based.urdf.notes, *said))
    stated = based.limits_beside(beside.stated_limits())
    limits = with_stated(described_limits(model), stated, units=joint_units(model), mimics=mimics)
    return _assembled(model, description, based.srdf, limits, based.base, beside)


@checked
def parts_of_pinocchio(
    model: pin.Model,
    collision_model: pin.GeometryModel | None,
    groups: Mapping[str, Sequence[str]] | None,
    beside: Beside,
) -> RobotParts:
    """Return the parts of a robot of Pinocchio's models; as `Robot.from_pinocchio`."""
    check_joints(model)
    semantics = beside.semantics()
    own = model.copy()
    semantics = replace(semantics, groups={**semantics.groups, **group_elements(own, groups)})
    limits = with_stated(described_limits(own), beside.stated_limits(), units=joint_units(own))
    description = described(own, collision_model, beside.name)
    return _assembled(own, description, semantics, limits, RobotBase(), beside)


def _assembled(
    model: pin.Model,
    description: Urdf,
    semantics: Srdf,
    limits: JointLimits,
    base: RobotBase,
    beside: Beside,
) -> RobotParts:
    """Put a robot together of what its descriptions state, whose names are checked against each other."""
    links = link_names(model)
    named = semantics_of(model, semantics, description.mimics)
    motorless = frozenset((*description.mimics, *semantics.passive_joints, *base.joints))
    solid = robot_bodies(description.collisions, beside.meshes or MeshPolicy())
    return RobotParts(
        name=beside.name or description.name,
        model=model,
        joint_names=tuple(model.names[1:]),
        limits=limits,
        groups=named.groups,
        states=named.states,
        end_effectors=named.end_effectors,
        passive_joints=semantics.passive_joints,
        disabled_pairs=named.disabled_pairs | adjacent_links(model, links),
        mimics=description.mimics,
        frames=tool_frames(beside.frames or {}, links),
        bodies=solid.bodies,
        visuals=description.visuals,
        mesh_notes=solid.mesh_notes,
        notes=(
            *description.notes,
            *named.notes,
            *effort_notes(model, limits, motorless),
            *inertia_notes(model),
            *solid.notes,
            *_ghost_notes(description),
        ),
        left_out=named.left_out,
        base=base,
        urdf_path=description.path,
        urdf_xml=description.xml,
    )


def _ghost_notes(description: Urdf) -> tuple[str, ...]:
    """Return what there is to say of links that are seen and not solid."""
    solid = {item.link for item in description.collisions}
    ghosts = list(dict.fromkeys(item.link for item in description.visuals if item.link not in solid))
    if not ghosts:
        return ()
    return (
        f"links are visible and have no collision shape, so nothing keeps clear of them: {listed(ghosts)}",
    )


@dataclass(frozen=True, eq=False)
class Robot(RobotParts):
    """A robot as its description files state it; immutable.

    A joint has one number: its angle [rad] or travel [m]; continuous joints count whole turns.
    Positions of all joints are arrays in the order of `joint_names`.

    Attributes:
        name: The robot's name.
        model: Pinocchio's model of all joints; never changed.
        joint_names: Names of all movable joints, mimic and passive joints included.
        limits: Limits of all movable joints.
        groups: Planning groups by name.
        states: Named joint positions by (group, state).
        end_effectors: By name.
        passive_joints: Joints without a drive.
        disabled_pairs: Link pairs never checked for collision.
        mimics: Joints that follow another, each with the joint at the head of its chain.
        frames: Tool frames by name, beside the links.
        bodies: Collision bodies of all links.
        visuals: Visual elements of all links, for viewers.
        mesh_notes: What the mesh of each link became (hull, convex pieces, exact mesh).
        notes: Sentences on what of the files was left out or read differently.
        left_out: Why a group or a named state of the files was left out, by its name.
        base: How its base stands or moves in the world.
        urdf_path: The file it came from; an empty path where it came from a Pinocchio model.
        urdf_xml: Its text without collision and visual elements; then only the robot's name.
    """

    @staticmethod
    def from_urdf(
        urdf: Path | str,
        *,
        srdf: FileName = None,
        limits: FileName = None,
        package_dirs: Sequence[Path | str] = (),
        xacro: Mapping[str, str] | None = None,
        frames: Frames = None,
        name: str | None = None,
        meshes: MeshPolicy | None = None,
        base: MovingBase | None = None,
    ) -> Robot:
        """Load a robot from its files.

        Args:
            urdf: The URDF file, or a xacro file (its name ends in ".xacro").
            srdf: MoveIt's semantic description; without it every joint is in a group named
                "all" and only adjacent links are excused from collision.
            limits: MoveIt's `joint_limits.yaml`, for acceleration and jerk limits.
            package_dirs: Folders to look in for `package://` meshes, before those near the file and those
                that ROS knows (`ROS_PACKAGE_PATH`, `AMENT_PREFIX_PATH`).
            xacro: Arguments of a xacro file by name.
            frames: Further frames fixed to links, such as tool centre points, each a link and a
                placement in it.
            name: A name in place of the URDF's.
            meshes: How collision meshes become convex; the default policy when None.
            base: How its base moves, made by `trajopt.bases`; it stands still when None.

        Raises:
            FileFormatError: If a file does not say what it must.
            MissingExtra: If the file is xacro, and the package that expands it is not installed.
            MeshFileError: If a collision mesh is missing, empty or unreadable.
            UnsupportedJoint: If a joint is of no type that URDF has.
            MimicCycle: If joints mimic each other in a circle.
            NameNotFound: If the limits or a frame name what the URDF does not have.
        """
        beside = Beside(srdf, limits, frames, name, meshes)
        return Robot(**vars(parts_of_urdf(urdf, package_dirs, xacro, base, beside)))

    @staticmethod
    def from_pinocchio(
        model: pin.Model,
        collision_model: pin.GeometryModel | None = None,
        *,
        groups: Mapping[str, Sequence[str]] | None = None,
        srdf: FileName = None,
        limits: FileName = None,
        frames: Frames = None,
        name: str | None = None,
        meshes: MeshPolicy | None = None,
    ) -> Robot:
        """Make a robot of Pinocchio's model, which is copied, and its collision geometry.

        No joint mimics another: Pinocchio's model of a URDF does not say so. Collision pairs of the
        geometry model do not count; name in an SRDF the links that may touch.

        Args:
            model: Revolute, continuous and prismatic joints on a fixed base.
            collision_model: Shapes of the links; no link has one when None.
            groups: Name -> joint names, or a pair (base link, tip link), beside those of the SRDF;
                without either every joint is in a group named "all".
            srdf: As for `from_urdf`.
            limits: As for `from_urdf`.
            frames: As for `from_urdf`.
            name: A name in place of the model's.
            meshes: As for `from_urdf`.

        Raises:
            UnsupportedJoint: If a joint is a free-flyer or has more than one degree of freedom.
            ModelError: If limits or a collision geometry are not what they must be.
            NameNotFound: If a group, the limits or a frame name what the model does not have.
        """
        beside = Beside(srdf, limits, frames, name, meshes)
        return Robot(**vars(parts_of_pinocchio(model, collision_model, groups, beside)))

    @staticmethod
    def from_mjcf(
        file: Path | str,
        *,
        srdf: FileName = None,
        limits: FileName = None,
        frames: Frames = None,
        name: str | None = None,
        meshes: MeshPolicy | None = None,
        base: MovingBase | None = None,
    ) -> Robot:
        """Load a robot from MuJoCo's own file (MJCF).

        Bodies are links, geoms that collide are their collision shapes, and what is fixed to the world is
        part of the robot: each geom of the world is a link of its own. Pairs that MuJoCo does not check
        are not checked. A joint that an equality constraint has follow another mimics it, force ranges of
        actuators are limits of torque, and joints without an actuator are in no group, where others have
        one. Named key frames are states of the group "all". Free joints are fixed where they stand.
        `notes` says what is left out.

        Args:
            file: The file; its name may end in ".xml".
            srdf: As for `from_urdf`, beside what the file says.
            limits: As for `from_urdf`; MJCF itself states no limits of velocity.
            frames: As for `from_urdf`.
            name: A name in place of the model's.
            meshes: As for `from_urdf`.
            base: As for `from_urdf`.

        Raises:
            FileFormatError: If MuJoCo cannot read the file, or nothing in it moves.
            UnsupportedJoint: If a joint is a ball.
            ModelError: If a geom is a height field or a signed distance field.
            NameNotFound: If the limits or a frame name what the model does not have.
        """
        return Robot(**vars(parts_of_mjcf(file, base, Beside(srdf, limits, frames, name, meshes))))

    @cached_property
    def links(self) -> tuple[str, ...]:
        """Names of all links, root first."""
        return link_names(self.model)

    @cached_property
    def fixed_joints(self) -> frozenset[str]:
        """Names of the joints that cannot move, which are not in `joint_names`."""
        return fixed_joint_names(self.model)

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Names of all links and tool frames."""
        return (*self.links, *self.frames)

    def frame(self, name: str) -> FrameAttachment:
        """Return a link or tool frame as a placement in a link.

        Raises:
            FrameNotFound: If there is none of that name.
        """
        if one_of("frame", name, str) in self.frames:
            return self.frames[name]
        if name not in self.links:
            raise FrameNotFound("frame", name, self.frame_names)
        return FrameAttachment(name, IDENTITY)

    def group(self, name: str) -> Group:
        """Return a planning group.

        Raises:
            GroupNotFound: If there is none of that name.
        """
        if one_of("group", name, str) not in self.groups:
            raise GroupNotFound("group", name, self.groups, left_out=self.left_out.get(name, ""))
        return self.groups[name]

    def index(self, joints: Iterable[str]) -> Ints:
        """Return the indices of joints in `joint_names`, shape (k,).

        Raises:
            JointNotFound: If one is no movable joint.
        """
        for joint in (names := several("joints", joints, str)):
            if joint not in self.joint_names:
                raise JointNotFound("joint", joint, self.joint_names)
        return np.array([self.joint_names.index(joint) for joint in names], dtype=np.int64)

    def positions(
        self,
        values: Mapping[str, float] | str | None = None,
        *,
        group: str | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Return positions of all joints.

        Args:
            values: Joint -> position [rad | m], or the name of a state; joints not named are at
                the position nearest to zero inside their limits, mimic joints follow; where only a
                mimic joint is named, the joint that it follows is placed to suit. Positions of mimic
                joints in a named state do not count: they follow, as in MoveIt.
            group: The group whose named state is meant; any group that has it when None.
            degrees: Whether positions of joints that turn are in degrees; a named state is as it is.

        Returns:
            Positions, shape (number of joints,), read-only.

        Raises:
            JointNotFound: If a name is no movable joint.
            StateNotFound: If there is no named state of that name.
        """
        result = np.clip(np.zeros(len(self.joint_names)), self.limits.lower, self.limits.upper)
        _ = unless_none("group", group, str), one_of("degrees", degrees, bool)
        stated = dict[str, float]() if values is None else values
        named = self.state(stated, group=group) if isinstance(stated, str) else mapping("values", stated)
        for joint, value in named.items():
            place = self.index([joint])[0]  # the name is checked before it is asked how the joint moves
            turns = degrees and joint_unit(self.model, joint) == "rad"
            in_degrees = turns and not isinstance(values, str)
            result[place] = stated_angle(f"position of {joint}", value, degrees=in_degrees)
        return completed(
            self.joint_names, self.mimics, result, given=() if isinstance(values, str) else named
        )

    def followed(self, positions: Floats, *, checked: Iterable[str] = ()) -> Floats:
        """Return positions with each mimic joint where it follows.

        Args:
            positions: Of all joints, shape (number of joints,) [rad | m].
            checked: Mimic joints whose given position must be where they follow, up to the error of a
                sensor.

        Returns:
            Positions, shape (number of joints,), read-only.

        Raises:
            MimicContradiction: If one of those is not.
        """
        return followed(self.joint_names, self.mimics, positions, checked=checked)

    def state(self, name: str, *, group: str | None = None) -> Mapping[str, float]:
        """Return a named state of a group, as joint -> position [rad | m].

        Raises:
            StateNotFound: If there is none of that name.
        """
        _ = one_of("state", name, str), None if group is None else one_of("group", group, str)
        for (owner, state), values in self.states.items():
            if state == name and group in (None, owner):
                return {joint: v for joint, v in values.items() if joint in self.joint_names}
        known = {state for owner, state in self.states if group in (None, owner)}
        raise StateNotFound("state", name, known, left_out=self.left_out.get(name, ""))

    def configuration(self, positions: Floats) -> Floats:
        """Return pinocchio's configuration of all joints' positions [rad | m], shape (model.nq,)."""
        return configuration(self.model, floats("positions", positions, (len(self.joint_names),)))

    def with_torque_scaling(self, scaling: float, *, joints: Iterable[str] | None = None) -> Robot:
        """Return the robot with other limits of torque, or none; `notes` says so.

        Args:
            scaling: Factor on the effort limits [Nm | N] of the description; inf turns them off.
            joints: The joints that it is for; all when None.

        Raises:
            ShapeError: If the factor is not positive.
            JointNotFound: If one is no movable joint.
        """
        limits, said = torque_scaled(self.limits, scaling, joints)
        return replace(self, limits=limits, notes=(*self.notes, said))

    def with_jerk_limits(self, *, rise: float | None = None, joints: Iterable[str] | None = None) -> Robot:
        """Return the robot with its jerk limited too; `notes` says so.

        Args:
            rise: Time that each acceleration takes at least to reach its limit [s]. When None, 0.1 s for
                joints that state no limit of their jerk; others keep theirs.
            joints: The joints that it is for; all when None.

        Raises:
            ShapeError: If the time is not positive.
            JointNotFound: If one is no movable joint.
        """
        limits, said = jerk_limited(self.limits, rise, joints, units=joint_units(self.model))
        return replace(self, limits=limits, notes=(*self.notes, said)) if said else self

    def __getstate__(self) -> dict[str, object]:
        """Return the fields by name, the model as plain data."""
        return {**super().__getstate__(), "model": model_data(self.model)}

    def __setstate__(self, state: dict[str, object]) -> None:
        """Take the fields."""
        self.__dict__.update(state, model=model_of(cast(ModelData, state["model"])))

    def __repr__(self) -> str:
        """Say name, joints and groups."""
        names = ", ".join(f"{g.name} ({len(g.joints)})" for g in self.groups.values()) or "none"
        return in_short(f"Robot({shown(self.name)}, {in_number(self.joint_names, 'joint')}; groups: {names})")


DEFAULT_RISE = 0.1
"""The jerk limit that is chosen for a joint that states none lets its acceleration rise to its limit in this
time [s]: one period of a swing at 10 Hz. Arms swing at some 5 to 20 Hz, and an acceleration that rises over a
whole period of a swing leaves nothing of it behind."""


def torque_scaled(
    limits: JointLimits, scaling: float, joints: Iterable[str] | None
) -> tuple[JointLimits, str]:
    """Return limits with those of torque multiplied, and a sentence that says so.

    Args:
        limits: Of all joints.
        scaling: The factor; inf turns limits off.
        joints: The joints that it is for; all when None.

    Raises:
        ShapeError: If the factor is not positive.
        JointNotFound: If one is no movable joint.
    """
    factor = number("scaling", scaling, infinite=True)
    if factor <= 0.0:
        raise ShapeError("scaling", f"is a positive factor, or inf for no limit; is {factor:g}")
    names, whose = _named(limits, joints)
    said = "turned off" if factor == np.inf else f"multiplied by {factor:g}"
    effort = np.array(limits.effort)
    effort[[limits.joint_names.index(name) for name in names]] *= factor
    return replace(limits, effort=readonly(effort)), f"torque limits of {whose} are {said}"


def jerk_limited(
    limits: JointLimits, rise: float | None, joints: Iterable[str] | None, *, units: Mapping[str, str]
) -> tuple[JointLimits, str]:
    """Return limits with the jerk limited too, and a sentence that says so; none where nothing changes.

    Args:
        limits: Of all joints.
        rise: Time that an acceleration takes at least to reach its limit [s]. When None, `DEFAULT_RISE` for
            joints that have no limit of their jerk, and others keep theirs.
        joints: The joints that it is for; all when None. Joints without a limit of acceleration, which follow
            others, have none of jerk either.
        units: "rad" or "m" of each joint.

    Raises:
        ShapeError: If the time is not positive.
        JointNotFound: If one is no movable joint.
    """
    if rise is not None and number("rise", rise) <= 0.0:
        raise ShapeError("rise", f"is a positive time [s], is {rise:g}")
    names, _ = _named(limits, joints)
    jerk, chosen = np.array(limits.jerk), list(limits.defaulted)
    changed: list[str] = []
    for name in names:
        place = limits.joint_names.index(name)
        slow = float(limits.acceleration[place]) / (DEFAULT_RISE if rise is None else rise)
        stated = bool(np.isfinite(jerk[place]))
        if not np.isfinite(slow) or (stated and (rise is None or jerk[place] <= slow)):
            continue
        jerk[place] = slow
        changed.append(name)
        if not stated:
            chosen.append(not_stated(name, LimitKind.JERK, slow, units[name]))
    if not changed:
        return limits, ""
    how = f"the acceleration limit is reached in {DEFAULT_RISE if rise is None else rise:g} s"
    said = f"jerk limits of {listed(changed)} are chosen: {how}"
    return replace(limits, jerk=readonly(jerk), defaulted=tuple(chosen)), said


def _named(limits: JointLimits, joints: Iterable[str] | None) -> tuple[tuple[str, ...], str]:
    if joints is None:
        return limits.joint_names, "all joints"
    names = tuple(sequence("joints", joints))
    for name in names:
        if name not in limits.joint_names:
            raise JointNotFound("joint", name, limits.joint_names)
    return names, listed(names)
