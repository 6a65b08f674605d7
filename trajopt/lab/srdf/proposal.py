"""A whole SRDF for a robot, with the evidence for each pair and findings about its URDF."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trajopt.lab.srdf.evidence import DEFAULT_CONFIDENCE, Confidence, PairEvidence, Verdict
from trajopt.lab.srdf.gripper_findings import gripper_findings
from trajopt.lab.srdf.groups import ProposedGroup, propose_groups
from trajopt.lab.srdf.judged_pairs import judge_pairs
from trajopt.lab.srdf.link_tree import LinkTree
from trajopt.lab.srdf.states import gripper_states, home_positions
from trajopt.lab.srdf.urdf_checks import Finding, check_urdf
from trajopt.lab.srdf.writer import srdf_text
from trajopt.optimise.kinematics.sampling import Progress
from trajopt.robot.loading.srdf import EndEffector
from trajopt.robot.robot import Robot
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_number

DISABLED = (Verdict.ADJACENT, Verdict.NEVER, Verdict.ALWAYS)
"""Verdicts whose pairs are never checked for collision."""
PRINTED = 20
"""Pairs of one verdict that are printed: a page; a robot with two hands has thousands."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SrdfProposal:
    """What an SRDF of a robot may say, and why.

    Attributes:
        name: Name of the robot.
        confidence: With what confidence pairs are known never to collide.
        evidence: Of every pair of links with collision bodies.
        disabled: Reason by the two links of each pair that need not be checked.
        groups: Chains and grippers.
        states: Joint -> position [rad | m] by (group, state).
        end_effectors: Which gripper is fixed where.
        findings: What is odd about the URDF, and which joints are taken for a gripper's or may be one's.
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
    def with_verdict(self, verdict: Verdict) -> tuple[PairEvidence, ...]:
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
        """Say what was found, what is checked and what is not."""
        lines = [f"groups of {self.name}"]
        for group in self.groups:
            way = f"on {group.parent_link}" if group.is_gripper else f"{group.base} to {group.tip}"
            joints = in_number(group.driven, "driven joint")
            lines.append(f"  {group.name}: {way}, {joints}: {', '.join(group.driven)}")
        lines += ["", "states", *(f"  {group}: {name}" for group, name in self.states)]
        share, level = 100.0 * self.confidence.share, 100.0 * self.confidence.level
        titles = {
            Verdict.NEVER: f"never in collision (with {level:g} % confidence in less than {share:g} % of the "
            "configurations, all of these together)",
            Verdict.ALWAYS: "always in collision: a fault of their shapes",
            Verdict.DEFAULT: "in collision where all joints are nearest to zero, but not always",
            Verdict.SOMETIMES: "sometimes in collision: checked",
        }
        adjacent = len(self.with_verdict(Verdict.ADJACENT))
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


@checked
def propose_srdf(
    robot: Robot,
    *,
    rng: np.random.Generator,
    confidence: Confidence = DEFAULT_CONFIDENCE,
    progress: Progress | None = None,
) -> SrdfProposal:
    """Propose an SRDF: sample its pairs of links, group its joints, find states, check its URDF.

    Adjacent pairs, those that never collide and those that always do are left out of collision checks, and so
    are pairs inside one gripper, whose fingers are made to meet. All others are checked: a pair that collides
    where all joints are zero is reported, not left out.

    Args:
        robot: The robot, loaded from its URDF alone.
        rng: Draws configurations.
        confidence: With what confidence "never" must be known; gives the number of samples.
        progress: Called with the number of samples done.
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
            disabled[item.first, item.second] = Verdict.DEFAULT.value
    states: dict[tuple[str, str], Mapping[str, float]] = {}
    home = home_positions(robot, frozenset(frozenset(pair) for pair in disabled), rng=rng)
    driven = [name for name in robot.joint_names if name not in robot.mimics]
    for group in groups:
        if group.is_gripper:
            for name, values in gripper_states(robot, group).items():
                states[group.name, name] = values
        elif home is not None:
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
