"""What a robot is made of, put together of what its descriptions state."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import pinocchio as pin

from trajopt.robot.bases import MovingBase, RobotBase
from trajopt.robot.bodies import CollisionBody, robot_bodies
from trajopt.robot.frame_attachment import FrameAttachment, tool_frames
from trajopt.robot.limits import JointLimits, read_joint_limits, with_stated
from trajopt.robot.loading.base_joints import with_base
from trajopt.robot.loading.effort_notes import effort_notes
from trajopt.robot.loading.from_pinocchio import check_joints, described, group_elements
from trajopt.robot.loading.groups import Group
from trajopt.robot.loading.inertia_notes import inertia_notes
from trajopt.robot.loading.mimics import resolve_mimics
from trajopt.robot.loading.mjcf import read_mjcf
from trajopt.robot.loading.pinocchio_model import (
    adjacent_links,
    described_limits,
    fixed_joint_names,
    joint_units,
    link_names,
)
from trajopt.robot.loading.semantics import semantics_of
from trajopt.robot.loading.srdf import EndEffector, Srdf, read_srdf
from trajopt.robot.loading.urdf import LinkGeometry, Mimic, Urdf, read_urdf
from trajopt.robot.meshes.mesh_cover import MeshPolicy
from trajopt.values.arrays import Value
from trajopt.values.errors import FileFormatError, listed
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import PlacementLike

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
