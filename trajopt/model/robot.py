"""Robot: kinematics, limits, groups, named states and collision bodies of one arm or several."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats, Ints, Value, floats, mapping, one_of
from trajopt.errors import FileFormatError, FrameNotFound, GroupNotFound, JointNotFound, StateNotFound, shown
from trajopt.model.collisions.bodies import CollisionBody, robot_bodies
from trajopt.model.description.base_joints import with_base
from trajopt.model.description.from_pinocchio import check_joints, described, group_elements
from trajopt.model.description.groups import Group, resolve_groups
from trajopt.model.description.mimics import completed, followed, resolve_mimics
from trajopt.model.description.pinocchio_model import (
    ModelData,
    adjacent_links,
    configuration,
    described_limits,
    fixed_joint_names,
    link_names,
    model_data,
    model_of,
)
from trajopt.model.description.srdf import EndEffector, Srdf, read_srdf
from trajopt.model.description.urdf import LinkGeometry, Mimic, Urdf, read_urdf
from trajopt.model.frame_attachment import FrameAttachment, tool_frames
from trajopt.model.limits import JointLimits, read_joint_limits, with_stated
from trajopt.model.meshes.mesh_cover import MeshPolicy
from trajopt.model.moving_base import MovingBase, RobotBase
from trajopt.model.placement import IDENTITY, PlacementLike
from trajopt.model.printed import in_number, in_short


@dataclass(frozen=True, eq=False)
class Robot(Value):
    """A robot as its description files state it; immutable.

    A joint has one number: its angle [rad] or travel [m]; continuous joints count whole turns.
    Positions of all joints are arrays in the order of `joint_names`.

    Attributes:
        name: The robot's name.
        model: Pinocchio's model of all joints; never changed.
        joint_names: Names of all movable joints, mimicking and passive ones included.
        limits: Limits of all movable joints.
        groups: Planning groups by name.
        states: Named joint positions by (group, state).
        end_effectors: By name.
        passive_joints: Joints that nobody drives.
        disabled_pairs: Link pairs never checked for collision.
        mimics: Joints that follow another, each with the one that leads it in the end.
        frames: Tool frames by name, beside the links.
        bodies: Collision bodies of all links.
        visuals: Visual elements of all links, for viewers.
        mesh_notes: Which link's mesh became what (hull, convex pieces, exact mesh).
        notes: Sentences on what the files say that was left out, or taken differently.
        base: How it stands in the world, and what moves it there.
        urdf_path: The file it came from; an empty path where it came from a Pinocchio model.
        urdf_xml: Its text without collision and visual elements; then only the robot's name.
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
    base: RobotBase
    urdf_path: Path
    urdf_xml: str

    @staticmethod
    def from_urdf(
        urdf: Path | str,
        *,
        srdf: Path | str | None = None,
        limits: Path | str | None = None,
        package_dirs: Sequence[Path | str] = (),
        frames: Mapping[str, FrameAttachment | tuple[str, PlacementLike]] | None = None,
        name: str | None = None,
        meshes: MeshPolicy | None = None,
        base: MovingBase | None = None,
    ) -> "Robot":
        """Load a robot from its files.

        Args:
            urdf: The URDF file.
            srdf: MoveIt's semantic description; without it every joint is in a group named
                "all" and only adjacent links are excused from collision.
            limits: MoveIt's `joint_limits.yaml`, for acceleration and jerk limits.
            package_dirs: Folders to look in for `package://` meshes.
            frames: Further frames fixed to links, such as tool centre points, each a link and a
                placement in it.
            name: A name in place of the URDF's.
            meshes: How collision meshes become convex; the default policy when None.
            base: How its base moves, of `trajopt.model.moving_base`; it stands still when None.

        Raises:
            FileFormatError: If a file does not say what it must.
            MeshFileError: If a collision mesh is missing, empty or unreadable.
            UnsupportedJoint: If a joint is of no type that URDF has.
            MimicCycle: If joints mimic each other in a circle.
            NameNotFound: If the SRDF, the limits, a frame or a mimic joint name what the URDF does not have.
        """
        semantics = Srdf() if srdf is None else read_srdf(Path(srdf))
        based = with_base(read_urdf(Path(urdf), [Path(folder) for folder in package_dirs]), semantics, base)
        try:
            model = pin.buildModelFromXML(based.urdf.xml)
        except ValueError as error:
            reason = f"{error} (what is wrong is told above, on standard error)"
            raise FileFormatError(str(urdf), reason) from error
        stated = based.limits_beside({} if limits is None else read_joint_limits(Path(limits)))
        fixed = fixed_joint_names(model)
        mimics = resolve_mimics(based.urdf.mimics, movable=tuple(model.names[1:]), fixed=fixed)
        return _assembled(
            model,
            replace(based.urdf, name=name or based.urdf.name),
            based.srdf,
            base=based.base,
            limits=with_stated(described_limits(model), stated, mimics=mimics),
            mimics=mimics,
            frames=frames,
            meshes=meshes,
        )

    @staticmethod
    def from_pinocchio(
        model: pin.Model,
        collision_model: pin.GeometryModel | None = None,
        *,
        groups: Mapping[str, Sequence[str]] | None = None,
        srdf: Path | str | None = None,
        limits: Path | str | None = None,
        frames: Mapping[str, FrameAttachment | tuple[str, PlacementLike]] | None = None,
        name: str | None = None,
        meshes: MeshPolicy | None = None,
    ) -> "Robot":
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
            NameNotFound: If a group, the SRDF, the limits or a frame name what the model does not have.
        """
        check_joints(model)
        semantics = Srdf() if srdf is None else read_srdf(Path(srdf))
        stated: Mapping[str, Mapping[str, Any]] = {} if limits is None else read_joint_limits(Path(limits))
        own = model.copy()
        return _assembled(
            own,
            described(own, collision_model, name),
            replace(semantics, groups={**semantics.groups, **group_elements(own, groups)}),
            base=RobotBase(),
            limits=with_stated(described_limits(own), stated, mimics={}),
            mimics={},
            frames=frames,
            meshes=meshes,
        )

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
            raise GroupNotFound("group", name, self.groups)
        return self.groups[name]

    def index(self, joints: Iterable[str]) -> Ints:
        """Return the places of joints in `joint_names`, shape (k,).

        Raises:
            JointNotFound: If one is no movable joint.
        """
        for joint in (names := tuple(joints)):
            if joint not in self.joint_names:
                raise JointNotFound("joint", joint, self.joint_names)
        return np.array([self.joint_names.index(joint) for joint in names], dtype=np.int64)

    def positions(
        self, values: Mapping[str, float] | str | None = None, *, group: str | None = None
    ) -> Floats:
        """Return positions of all joints.

        Args:
            values: Joint -> position [rad | m], or the name of a state; joints not named are at
                the position nearest to zero inside their limits, mimicking ones follow; where only a
                mimicking joint is named, the joint that it follows is placed to suit. What a state says of a
                mimicking joint does not count: it follows, as in MoveIt.
            group: The group whose named state is meant; any group that has it when None.

        Returns:
            Positions, shape (number of joints,), read-only.

        Raises:
            JointNotFound: If a name is no movable joint.
            StateNotFound: If there is no named state of that name.
        """
        result = np.clip(np.zeros(len(self.joint_names)), self.limits.lower, self.limits.upper)
        stated = dict[str, float]() if values is None else values
        named = self.state(stated, group=group) if isinstance(stated, str) else mapping("positions", stated)
        for joint, value in named.items():
            result[self.index([joint])[0]] = float(floats(f"position of {joint}", value, ()))
        return completed(
            self.joint_names, self.mimics, result, given=() if isinstance(values, str) else named
        )

    def followed(self, positions: Floats, *, checked: Iterable[str] = ()) -> Floats:
        """Return positions with each mimic joint where it follows.

        Args:
            positions: Of all joints, shape (number of joints,) [rad | m].
            checked: Mimic joints whose position was given by somebody, and must be where they follow but
                for what a sensor may err.

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
        raise StateNotFound("state", name, {state for owner, state in self.states if group in (None, owner)})

    def configuration(self, positions: Floats) -> Floats:
        """Return pinocchio's configuration vector of positions of all joints.

        Args:
            positions: One number a joint, shape (number of joints,) [rad | m].

        Returns:
            Configuration q, shape (model.nq,): cosine and sine for continuous joints.
        """
        return configuration(self.model, positions)

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


def _assembled(
    model: pin.Model,
    description: Urdf,
    semantics: Srdf,
    *,
    base: RobotBase,
    limits: JointLimits,
    mimics: Mapping[str, Mimic],
    frames: Mapping[str, FrameAttachment | tuple[str, PlacementLike]] | None,
    meshes: MeshPolicy | None,
) -> Robot:
    """Make a robot of what its descriptions state, whose names are checked against each other."""
    links = link_names(model)
    bodies, notes = robot_bodies(description.collisions, meshes or MeshPolicy())
    return Robot(
        name=description.name,
        model=model,
        joint_names=tuple(model.names[1:]),
        limits=limits,
        groups=resolve_groups(model, semantics, frozenset(mimics)),
        states=semantics.states,
        end_effectors=semantics.end_effectors,
        passive_joints=semantics.passive_joints,
        disabled_pairs=semantics.disabled_pairs | adjacent_links(model, links),
        mimics=mimics,
        frames=tool_frames(frames or {}, links),
        bodies=bodies,
        visuals=description.visuals,
        mesh_notes=notes,
        notes=description.notes,
        base=base,
        urdf_path=description.path,
        urdf_xml=description.xml,
    )
