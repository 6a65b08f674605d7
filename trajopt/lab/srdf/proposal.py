"""A complete SRDF for a robot, and its file."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from xml.etree import ElementTree

import numpy as np

from trajopt.geometry import evaluator
from trajopt.lab.srdf.groups import BASE_JOINT, LinkTree, ProposedGroup, doubt, propose_groups
from trajopt.lab.srdf.judged_pairs import (
    DEFAULT_CONFIDENCE,
    Confidence,
    PairEvidence,
    PairVerdict,
    all_joints_free,
    judge_pairs,
)
from trajopt.lab.srdf.urdf_checks import Finding, Severity, check_urdf
from trajopt.optimise.kinematics.sampling import Progress
from trajopt.robot.bodies import CollisionBody
from trajopt.robot.joints import draw_positions
from trajopt.robot.loading.pinocchio_model import link_placement
from trajopt.robot.loading.srdf import EndEffector
from trajopt.robot.robot import Robot
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import listed, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_number
from trajopt.values.shapes.shapes import bounding_sphere

DISABLED = (PairVerdict.ADJACENT, PairVerdict.NEVER, PairVerdict.ALWAYS)
"""Verdicts whose pairs are never checked for collision."""
PRINTED = 20
"""Number of printed pairs of one verdict; a robot with two hands has thousands."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SrdfProposal:
    """A proposed SRDF, with its evidence.

    Attributes:
        confidence: Of "never".
        evidence: Of every pair of links with collision bodies.
        disabled: Reason by the two links of each pair that need not be checked.
        states: Joint -> position [rad | m] by (group, state).
        end_effectors: The parent of each gripper.
        findings: Suspicious parts of the URDF, and certain or possible joints of grippers.
    """

    name: str
    confidence: Confidence
    evidence: tuple[PairEvidence, ...]
    disabled: Mapping[tuple[str, str], str]
    groups: tuple[ProposedGroup, ...]
    states: Mapping[tuple[str, str], Mapping[str, float]]
    end_effectors: tuple[EndEffector, ...]
    findings: tuple[Finding, ...]

    @property
    def xml(self) -> str:
        """The SRDF's text."""
        return srdf_text(
            self.name,
            self.groups,
            states=self.states,
            end_effectors=self.end_effectors,
            disabled=self.disabled,
        )

    @checked
    def with_verdict(self, verdict: PairVerdict) -> tuple[PairEvidence, ...]:
        """Return the pairs of a verdict."""
        return tuple(item for item in self.evidence if item.verdict is verdict)

    def as_dict(self) -> dict[str, object]:
        """Return plain data."""
        return {
            "robot": self.name,
            "confidence": {"share": self.confidence.share, "level": self.confidence.level},
            "pairs": [item.as_dict() for item in self.evidence],
            "disabled": [{"links": list(pair), "reason": why} for pair, why in self.disabled.items()],
            "groups": [vars(group) for group in self.groups],
            "states": [
                {"group": group, "name": name, "positions": dict(values)}
                for (group, name), values in self.states.items()
            ],
            "end_effectors": [vars(effector) for effector in self.end_effectors],
            "findings": [finding.as_dict() for finding in self.findings],
        }

    def __str__(self) -> str:
        lines = [f"groups of {self.name}"]
        for group in self.groups:
            lines.append(f"  {group.name}: {_described(group)}")
        lines += ["", "states", *(f"  {group}: {name}" for group, name in self.states)]
        share, level = 100.0 * self.confidence.share, 100.0 * self.confidence.level
        titles = {
            PairVerdict.NEVER: f"never in collision (with {level:g} % confidence in less than {share:g} % "
            "of the configurations, all of these together)",
            PairVerdict.ALWAYS: "always in collision: a fault of their shapes",
            PairVerdict.DEFAULT: "in collision where all joints are nearest to zero, but not always",
            PairVerdict.SOMETIMES: "sometimes in collision: checked",
        }
        adjacent = len(self.with_verdict(PairVerdict.ADJACENT))
        lines += ["", f"pairs of links: {adjacent} adjacent"]
        for verdict, title in titles.items():
            chosen = self.with_verdict(verdict)
            if chosen:
                lines += [
                    f"{len(chosen)} {title}",
                    *(f"  {item}{self._note(item)}" for item in chosen[:PRINTED]),
                ]
                lines += [f"  and {len(chosen) - PRINTED} more: --json, or as_dict(), has all"] * (
                    len(chosen) > PRINTED
                )
        if self.findings:
            lines += ["", "findings in the URDF", *(f"  {finding}" for finding in self.findings)]
        return "\n".join(lines)

    def _note(self, item: PairEvidence) -> str:
        inside = item.verdict not in DISABLED and (item.first, item.second) in self.disabled
        return "; not checked: inside one gripper" if inside else ""


def _described(group: ProposedGroup) -> str:
    if group.is_base:
        return f"{group.tip} in the plane, if to.load gets base=to.bases.planar_base(...)"
    if group.parts:
        return f"groups {' and '.join(group.parts)}"
    way = f"on {group.parent_link}" if group.is_gripper else f"{group.base} to {group.tip}"
    return f"{way}, {in_number(group.driven, 'driven joint')}: {', '.join(group.driven)}"


@checked
def propose_srdf(
    robot: Robot,
    *,
    rng: np.random.Generator,
    confidence: Confidence = DEFAULT_CONFIDENCE,
    progress: Progress | None = None,
) -> SrdfProposal:
    """Propose an SRDF: sample pairs of links, group joints, find states, check the URDF.

    Adjacent pairs, those that never collide and those that always do are excluded from collision checks, and
    so are pairs inside one gripper, whose fingers meet. A pair that collides with all joints at zero is
    reported, not excluded.
    """
    tree = LinkTree.of(robot)
    groups = propose_groups(tree)
    evidence = judge_pairs(robot, rng=rng, confidence=confidence, progress=progress)
    grippers = [frozenset(group.links) for group in groups if group.is_gripper]
    disabled: dict[tuple[str, str], str] = {}
    for item in evidence:
        if item.verdict in DISABLED:
            disabled[item.first, item.second] = item.verdict.value
        elif any(item.pair <= links for links in grippers):
            disabled[item.first, item.second] = PairVerdict.DEFAULT.value
    states: dict[tuple[str, str], Mapping[str, float]] = {}
    home = home_positions(robot, frozenset(frozenset(pair) for pair in disabled), rng=rng)
    driven = [name for name in robot.joint_names if name not in robot.mimics]
    for group in groups:
        if group.is_gripper:
            for name, values in gripper_states(robot, group).items():
                states[group.name, name] = values
        elif home is not None and group.driven:
            states[group.name, "home"] = {joint: float(home[driven.index(joint)]) for joint in group.driven}
    effectors = tuple(
        EndEffector(f"{group.name}_eef", group.name, group.parent_link, group.parent_group)
        for group in groups
        if group.is_gripper
    )
    return SrdfProposal(
        name=robot.name,
        confidence=confidence,
        evidence=evidence,
        disabled=disabled,
        groups=groups,
        states=states,
        end_effectors=effectors,
        findings=(*check_urdf(robot), *gripper_findings(tree, groups)),
    )


def gripper_findings(tree: LinkTree, groups: Sequence[ProposedGroup]) -> Iterator[Finding]:
    """List the joints assigned to a gripper, and an arm's that may belong to it."""
    carriers = {group.parent_group for group in groups}
    for group in groups:
        if group.is_base or group.parts:
            continue
        if group.is_gripper:
            one = "; name its open and closed states: one finger does not show which end is which"
            yield Finding(
                Severity.NOTE,
                listed(group.driven),
                f"taken for a gripper's: in group {shown(group.name)}, and motions of "
                f"{shown(group.parent_group)} leave the gripper as it is at their start"
                f"{one if len(group.joints) == 1 else ''}",
            )
            continue
        joint, why = ("", "") if group.name in carriers else doubt(tree, group.driven)
        if joint:
            end = next(link.parent for link in tree.links.values() if link.joint == joint)
            yield Finding(
                Severity.NOTE,
                joint,
                f"may be a gripper's ({why}), but is in group {shown(group.name)}, whose motions move it: "
                f"if it is, let the group's chain end at {end}",
            )


TRIED = 2000
"""Number of random configurations if neither zero nor the middle of the limits is valid."""
HOME_MARGIN = 0.01
"""Preferred clearance of a home state [m]."""


def home_positions(
    robot: Robot, disabled: frozenset[frozenset[str]], *, rng: np.random.Generator
) -> Floats | None:
    """Return collision-free positions of all driven joints, shape (n,) [rad | m]; zero is preferred."""
    free = all_joints_free(robot)
    bare = replace(free.scene.robot, disabled_pairs=disabled)
    reduced = reduce_model(Scene(bare, margin=0.0), free.group, free.start)
    limits = reduced.limits
    limited = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    middle = np.zeros(len(limited))
    middle[limited] = 0.5 * (limits.lower[limited] + limits.upper[limited])
    drawn = draw_positions(limits, TRIED, rng=rng)
    nearest = np.argsort(np.abs(drawn - middle).max(axis=1, initial=0.0))
    inside = ((limits.lower <= 0.0) & (limits.upper >= 0.0)).all()
    tried = np.concatenate((np.zeros((int(inside), len(middle))), middle[None], drawn[nearest]))
    for margin in (HOME_MARGIN, 0.0):
        reach = np.full(len(reduced.pairs.margin), max(margin, 1e-12))
        touching = np.zeros(len(tried), dtype=np.bool_)
        touching[evaluator(reduced).close_pairs(tried, reach).sample] = True
        if not touching.all():
            return tried[int(np.argmin(touching))]
    return None


def gripper_states(robot: Robot, group: ProposedGroup) -> Mapping[str, Mapping[str, float]]:
    """Return the states "open" and "close" of a gripper: the ends of its joints' strokes, by driven joint.

    At "open" its fingers' collision bodies are farther apart on average. Empty for one finger, whose shape
    does not determine the ends, and for an unlimited stroke.
    """
    limits = robot.limits.take(robot.index(group.driven))
    if len(group.joints) < 2 or not group.driven or not np.isfinite([limits.lower, limits.upper]).all():
        return {}
    bodies = [body for body in robot.bodies if body.owner in group.links and body.owner != group.tip]
    ends = [dict(zip(group.driven, side.tolist(), strict=True)) for side in (limits.lower, limits.upper)]
    spread = [_spread(robot, bodies, robot.positions(end)) for end in ends]
    wide, narrow = (0, 1) if spread[0] > spread[1] else (1, 0)
    return {"open": ends[wide], "close": ends[narrow]}


def _spread(robot: Robot, bodies: Sequence[CollisionBody], positions: Floats) -> float:
    if not bodies:
        return 0.0
    centres = np.array(
        [
            link_placement(robot.model, body.frame, positions)
            * (body.placement * bounding_sphere(body.shape)[0])
            for body in bodies
        ]
    )
    return float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).mean())


@checked
def srdf_text(
    name: str,
    groups: Sequence[ProposedGroup],
    *,
    states: Mapping[tuple[str, str], Mapping[str, float]],
    end_effectors: Sequence[EndEffector],
    disabled: Mapping[tuple[str, str], str],
) -> str:
    """Write an SRDF; arguments as in `SrdfProposal`."""
    root = ElementTree.Element("robot", name=name)
    for group in groups:
        if group.is_base:
            world = {"name": BASE_JOINT, "type": "planar", "parent_frame": "world", "child_link": group.tip}
            ElementTree.SubElement(root, "virtual_joint", world)
    for group in groups:
        _add_group(root, group)
    for (group_name, state), values in states.items():
        element = ElementTree.SubElement(root, "group_state", name=state, group=group_name)
        for joint, value in values.items():
            ElementTree.SubElement(element, "joint", name=joint, value=f"{value:.10g}")
    for effector in end_effectors:
        facts = {"name": effector.name, "parent_link": effector.parent_link, "group": effector.group}
        if effector.parent_group:
            facts["parent_group"] = effector.parent_group
        ElementTree.SubElement(root, "end_effector", facts)
    for (first, second), reason in disabled.items():
        ElementTree.SubElement(root, "disable_collisions", link1=first, link2=second, reason=reason)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _add_group(root: ElementTree.Element, group: ProposedGroup) -> None:
    element = ElementTree.SubElement(root, "group", name=group.name)
    if group.parts:
        for part in group.parts:
            ElementTree.SubElement(element, "group", name=part)
    elif group.base:
        ElementTree.SubElement(element, "chain", base_link=group.base, tip_link=group.tip)
    else:
        for link in group.links:
            ElementTree.SubElement(element, "link", name=link)
        for joint in group.joints:
            ElementTree.SubElement(element, "joint", name=joint)
