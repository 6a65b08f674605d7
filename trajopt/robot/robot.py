"""Kinematics, limits, groups, named states and collision bodies of one arm or several."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np
import pinocchio as pin

from trajopt.robot.bases import MovingBase, RobotBase
from trajopt.robot.bodies import FINE, CollisionBody, MeshPolicy, robot_bodies
from trajopt.robot.joints import JointLimits, LimitKind, configuration, joint_unit, joint_units
from trajopt.robot.loading.base_joints import with_base
from trajopt.robot.loading.calibration import calibrated
from trajopt.robot.loading.groups import Group
from trajopt.robot.loading.mimics import completed, followed, resolve_mimics
from trajopt.robot.loading.mjcf import read_mjcf
from trajopt.robot.loading.pinocchio_model import (
    ModelData,
    adjacent_links,
    chain_lengths,
    check_joints,
    described,
    described_limits,
    effort_notes,
    fixed_joint_names,
    group_elements,
    inertia_notes,
    link_names,
    model_data,
    model_of,
)
from trajopt.robot.loading.semantics import semantics_of
from trajopt.robot.loading.srdf import EndEffector, Srdf, read_srdf
from trajopt.robot.loading.stated_limits import not_stated, read_joint_limits, with_stated
from trajopt.robot.loading.urdf import LinkGeometry, Mimic, Urdf, read_urdf
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
    """A frame fixed to a link, such as the tool centre point."""

    link: str
    placement: Placement

    def __post_init__(self) -> None:
        object.__setattr__(self, "placement", as_placement("placement", self.placement))


def frame_attachment(name: str, value: FrameAttachment | tuple[str, PlacementLike]) -> FrameAttachment:
    if isinstance(value, FrameAttachment):
        return value
    if not isinstance(value, tuple) or len(value) != 2:  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ShapeError(name, f"is a link and a placement in it, is {shown(value)}")
    return FrameAttachment(one_of(name, value[0], str), as_placement(name, value[1]))


def tool_frames(
    frames: Mapping[str, FrameAttachment | tuple[str, PlacementLike]], links: Sequence[str]
) -> Mapping[str, FrameAttachment]:
    """Return the tool frames of a robot, checked against its links."""
    tools = {tool: frame_attachment(f"frame {shown(tool)}", at) for tool, at in frames.items()}
    for tool, frame in tools.items():
        if frame.link not in links:
            raise FrameNotFound("link", frame.link, links)
        if tool in links or tool == WORLD:
            raise ModelError(f"tool frame {shown(tool)} has the name of a link or of the world: rename it")
    return tools


FileName: TypeAlias = Path | str | None
Frames: TypeAlias = Mapping[str, FrameAttachment | tuple[str, PlacementLike]] | None


@checked
@dataclass(frozen=True, eq=False)
class LoadOptions:
    """Options of loading a robot; `Robot.from_urdf` documents them."""

    srdf: FileName
    limits: FileName
    frames: Frames
    name: str | None
    meshes: MeshPolicy | None

    def semantics(self) -> Srdf:
        return Srdf() if self.srdf is None else read_srdf(Path(self.srdf))

    def stated_limits(self) -> Mapping[str, Mapping[str, Any]]:
        return {} if self.limits is None else read_joint_limits(Path(self.limits))


@dataclass(frozen=True, eq=False)
class Robot(Value):
    """A robot as described by its files; immutable.

    A joint has one number: its angle [rad] or travel [m]; continuous joints count whole turns. Positions of
    all joints are arrays in the order of `joint_names`.

    Attributes:
        model: Pinocchio's model of all joints; never changed.
        joint_names: All movable joints, mimic and passive joints included.
        limits: Of all movable joints.
        states: Named joint positions by (group, state).
        passive_joints: Joints without a drive.
        disabled_pairs: Link pairs never checked for collision.
        frames: Tool frames by name, beyond the links.
        notes: Sentences on skipped or reinterpreted parts of the files.
        left_out: The reason for each skipped group or named state, by its name.
        base: The connection of the robot to the world.
        urdf_path: Its file; an empty path for a robot from a Pinocchio model.
        urdf_xml: The file's text without collision and visual elements; only the robot's name without a file.
    """

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
            urdf: The URDF file, or a xacro file (suffix ".xacro").
            srdf: MoveIt's semantic description; without it every joint is in a group named
                "all" and only adjacent links are excluded from collision checks.
            limits: MoveIt's `joint_limits.yaml`, for acceleration and jerk limits.
            package_dirs: Folders with the packages of `package://` meshes, searched before those near the
                file and those that ROS knows (`ROS_PACKAGE_PATH`, `AMENT_PREFIX_PATH`).
            xacro: Arguments of a xacro file by name.
            frames: Further frames fixed to links, such as tool centre points, each a link and a
                placement in it.
            meshes: How collision meshes become convex; if None within a centimetre, or for large meshes of
                robots that reach more than two metres within a two-hundredth of the reach.
            base: A moving base, made by `trajopt.bases`; a fixed base if None.

        Raises:
            FileFormatError: If a file has invalid content.
            MissingExtra: If the file is xacro, and its expander is not installed.
            MeshFileError: If a collision mesh is missing, empty or unreadable.
            UnsupportedJoint: If a joint has an unknown type.
            MimicCycle: If joints mimic each other in a cycle.
            NameNotFound: If the limits or a frame use a name that the URDF does not have.
        """
        options = LoadOptions(srdf, limits, frames, name, meshes)
        return _from_urdf(urdf, package_dirs, xacro, base, options)

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
        """Make a robot from Pinocchio's model, which is copied, and its collision geometry.

        Further arguments are as for `from_urdf`. No joint mimics another: Pinocchio's model does not contain
        mimics. Collision pairs of the geometry model are ignored; allow contacts in an SRDF.

        Args:
            model: Revolute, continuous and prismatic joints on a fixed base.
            groups: Name -> joint names, or a pair (base link, tip link), beyond those of the SRDF; without
                either every joint is in a group named "all".

        Raises:
            UnsupportedJoint: If a joint is a free-flyer or has more than one degree of freedom.
            ModelError: If limits or a collision geometry are invalid.
            NameNotFound: If a group, the limits or a frame use a name that the model does not have.
        """
        options = LoadOptions(srdf, limits, frames, name, meshes)
        return _from_pinocchio(model, collision_model, groups, options)

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
        """Load a robot from MuJoCo's file format (MJCF).

        Bodies become links, colliding geoms their collision shapes, and geoms of the world links part of the
        robot. A joint coupled by an equality constraint becomes a mimic joint, force ranges of actuators
        become torque limits, and joints without an actuator are in no group if others have one. Named key
        frames become states of the group "all". `notes` lists the skipped parts. Further arguments are as for
        `from_urdf`.

        Args:
            limits: MoveIt's `joint_limits.yaml`: MJCF has no velocity limits.

        Raises:
            FileFormatError: If MuJoCo cannot read the file, or it has no joint.
            UnsupportedJoint: If a joint is a ball.
            ModelError: If a geom is a height field or a signed distance field.
            NameNotFound: If the limits or a frame use a name that the model does not have.
        """
        return _from_mjcf(file, base, LoadOptions(srdf, limits, frames, name, meshes))

    @cached_property
    def links(self) -> tuple[str, ...]:
        """Names of all links, root first."""
        return link_names(self.model)

    @cached_property
    def fixed_joints(self) -> frozenset[str]:
        """Names of the fixed joints, which are not in `joint_names`."""
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
            JointNotFound: If one is not a movable joint.
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
        others: Floats | None = None,
    ) -> Floats:
        """Return positions of all joints.

        Args:
            values: Joint -> position [rad | m], or the name of a state. Joints not named are at the position
                nearest to zero inside their limits, or at `others`; mimic joints follow. If only a mimic
                joint is named, the joint that it follows is adjusted. Positions of mimic joints in a named
                state are ignored, as in MoveIt.
            group: The group of the named state; any group that has it if None.
            degrees: Whether positions of revolute joints are in degrees; named states are always in radians.
            others: Positions of all joints, shape (number of joints,) [rad | m].

        Returns:
            Positions, shape (number of joints,), read-only.

        Raises:
            JointNotFound: If a name is not a movable joint.
            StateNotFound: Without a named state of that name.
        """
        if others is None:
            result = np.clip(np.zeros(len(self.joint_names)), self.limits.lower, self.limits.upper)
        else:
            result = np.array(floats("others", others, (len(self.joint_names),)))
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
        """Return positions (number of joints,), read-only, with mimic joints at their implied positions.

        Args:
            checked: Mimic joints whose given position must equal the implied one, up to the error of a
                sensor.

        Raises:
            MimicContradiction: If one of those differs.
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
        return configuration(self.model, floats("positions", positions, (len(self.joint_names),)))

    def with_torque_scaling(self, scaling: float, *, joints: Iterable[str] | None = None) -> Robot:
        """Return the robot with scaled torque limits, or without; `notes` has a sentence about it.

        Args:
            scaling: Factor on the effort limits [Nm | N] of the description; inf turns them off.
            joints: The affected joints; all if None.

        Raises:
            ShapeError: If the factor is not positive.
            JointNotFound: If one is not a movable joint.
        """
        limits, said = torque_scaled(self.limits, scaling, joints)
        return replace(self, limits=limits, notes=(*self.notes, said))

    def with_jerk_limits(self, *, rise: float | None = None, joints: Iterable[str] | None = None) -> Robot:
        """Return the robot with jerk limits; `notes` has a sentence about them.

        Args:
            rise: Least time in which an acceleration reaches its limit [s]. If None, 0.1 s for
                joints without a jerk limit; the others keep theirs.
            joints: The affected joints; all if None.

        Raises:
            ShapeError: If the time is not positive.
            JointNotFound: If one is not a movable joint.
        """
        limits, said = jerk_limited(self.limits, rise, joints, units=joint_units(self.model))
        return replace(self, limits=limits, notes=(*self.notes, said)) if said else self

    def with_calibration(self, file: Path | str, *, prefix: str = "") -> Robot:
        """Return the robot with the factory calibration of an arm of Universal Robots.

        The flange is then at the controller's pose; shapes move with their links. `notes` has a sentence
        about it. The result has no `urdf_path`.

        Sources: deltas are added to the nominal parameters
        (https://forum.universal-robots.com/t/ur10-calibration-conf-dh-model-generation/1638); the YAML is
        written by `Calibration::toYaml` of Universal_Robots_ROS2_Driver, whose roll, pitch and yaw are angles
        of Rx Ry Rz.

        Args:
            file: The controller's `calibration.conf`, or the YAML of `ur_calibration` (a mapping `kinematics`
                with x, y, z [m], roll, pitch, yaw [rad] of six links).
            prefix: Start of the names of the arm's joints, and of its flange `tool0`.

        Raises:
            FileFormatError: If the file is not a calibration, or shifts a joint by more than 5 cm, so that it
                belongs to another type of arm.
            NameNotFound: If the robot does not have the joints or the flange.
            ModelError: If the joints do not have the axes of an arm of Universal Robots.
        """
        return _calibrated(self, file, prefix)

    def __getstate__(self) -> dict[str, object]:
        return {**super().__getstate__(), "model": model_data(self.model)}

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state, model=model_of(cast(ModelData, state["model"])))

    def __repr__(self) -> str:
        names = ", ".join(f"{g.name} ({len(g.joints)})" for g in self.groups.values()) or "none"
        return in_short(f"Robot({shown(self.name)}, {in_number(self.joint_names, 'joint')}; groups: {names})")


@checked
def _calibrated(robot: Robot, file: Path | str, prefix: str) -> Robot:
    model, xml, said = calibrated(robot.model, robot.urdf_xml, Path(file), prefix)
    return replace(robot, model=model, urdf_xml=xml, urdf_path=Path(), notes=(*robot.notes, said))


@checked
def _from_urdf(
    urdf: Path | str,
    package_dirs: Sequence[Path | str],
    xacro: Mapping[str, str] | None,
    base: MovingBase | None,
    options: LoadOptions,
) -> Robot:
    written = read_urdf(Path(urdf), [Path(folder) for folder in package_dirs], xacro)
    return _from_description(written, options.semantics(), base, options)


@checked
def _from_mjcf(file: Path | str, base: MovingBase | None, options: LoadOptions) -> Robot:
    written, stated = read_mjcf(Path(file))
    semantics = options.semantics()
    semantics = replace(
        semantics,
        states={**semantics.states, **({} if semantics.groups else stated.states)},
        disabled_pairs=semantics.disabled_pairs | stated.disabled_pairs,
        passive_joints=semantics.passive_joints | stated.passive_joints,
    )
    return _from_description(written, semantics, base, options)


def _from_description(written: Urdf, semantics: Srdf, base: MovingBase | None, options: LoadOptions) -> Robot:
    based = with_base(written, semantics, base)
    try:
        model = pin.buildModelFromXML(based.urdf.xml)
    except ValueError as error:
        reason = f"{error} (the parser's message is above, on standard error)"
        raise FileFormatError(str(written.path), reason) from error
    fixed = fixed_joint_names(model)
    mimics, said = resolve_mimics(based.urdf.mimics, movable=tuple(model.names[1:]), fixed=fixed)
    description = replace(based.urdf, mimics=mimics, notes=(*based.urdf.notes, *said))
    stated = based.limits_beside(options.stated_limits())
    limits = with_stated(described_limits(model), stated, units=joint_units(model), mimics=mimics)
    return _assembled(model, description, based.srdf, limits, based.base, options)


@checked
def _from_pinocchio(
    model: pin.Model,
    collision_model: pin.GeometryModel | None,
    groups: Mapping[str, Sequence[str]] | None,
    options: LoadOptions,
) -> Robot:
    check_joints(model)
    semantics = options.semantics()
    own = model.copy()
    semantics = replace(semantics, groups={**semantics.groups, **group_elements(own, groups)})
    limits = with_stated(described_limits(own), options.stated_limits(), units=joint_units(own))
    description = described(own, collision_model, options.name)
    return _assembled(own, description, semantics, limits, RobotBase(), options)


def _assembled(
    model: pin.Model,
    description: Urdf,
    semantics: Srdf,
    limits: JointLimits,
    base: RobotBase,
    options: LoadOptions,
) -> Robot:
    links = link_names(model)
    named = semantics_of(model, semantics, description.mimics)
    motorless = frozenset((*description.mimics, *semantics.passive_joints, *base.joints))
    solid = robot_bodies(
        description.collisions, options.meshes or MeshPolicy(large=FINE * chain_lengths(model, {}).max())
    )
    return Robot(
        name=options.name or description.name,
        model=model,
        joint_names=tuple(model.names[1:]),
        limits=limits,
        groups=named.groups,
        states=named.states,
        end_effectors=named.end_effectors,
        passive_joints=semantics.passive_joints,
        disabled_pairs=named.disabled_pairs | adjacent_links(model, links),
        mimics=description.mimics,
        frames=tool_frames(options.frames or {}, links),
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
    solid = {item.link for item in description.collisions}
    ghosts = list(dict.fromkeys(item.link for item in description.visuals if item.link not in solid))
    if not ghosts:
        return ()
    return (
        f"links are visible and have no collision shape, so nothing keeps clear of them: {listed(ghosts)}",
    )


DEFAULT_RISE = 0.1
"""Rise time of accelerations that determines a chosen jerk limit [s]: one period of a 10 Hz oscillation,
as arms have.
"""


def torque_scaled(
    limits: JointLimits, scaling: float, joints: Iterable[str] | None
) -> tuple[JointLimits, str]:
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
    """Return limits with jerk limits, and a sentence about them; empty if nothing changes.

    Args:
        rise: Least time in which an acceleration reaches its limit [s]. If None, `DEFAULT_RISE` for
            joints without a jerk limit; the others keep theirs.
        joints: All if None. Joints without an acceleration limit get no jerk limit.
        units: "rad" or "m" of each joint.
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
