"""Reasons why there is no plan, as data and in words."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from math import inf

import numpy as np

from trajopt.geometry.geometry import supports
from trajopt.optimise.kinematics.inverse import GoalCandidates
from trajopt.optimise.kinematics.validity import missed_at
from trajopt.optimise.nlp import ConstraintRows
from trajopt.optimise.solvers import SolveResult
from trajopt.optimise.terms import Clearance
from trajopt.optimise.terms.gravity_torque import HoldingTorque
from trajopt.optimise.terms.joint_positions import without_followers
from trajopt.planning.infeasibility import ClosedCut
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FollowsCurve, FramePlacement, JointPositions, Requirement
from trajopt.robot.joints import EXCESS, LimitKind, effort_unit, joint_unit
from trajopt.scene.clearances import how_near
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats
from trajopt.values.errors import shown
from trajopt.values.likely_units import meant_at_depth, meant_in_joint
from trajopt.values.placement import WORLD
from trajopt.values.printed import in_joint_position, in_range, in_unit
from trajopt.verify import Certificate, Examination, Overload

NAMED = 3
"""Colliding pairs that a sentence names."""


class ObstructionKind(Enum):
    """Kind of an obstruction."""

    CONTACT = "two bodies"
    JOINT_LIMIT = "a joint limit"
    REQUIREMENT = "a requirement"
    EFFORT = "an effort limit"


@dataclass(frozen=True, kw_only=True)
class Obstruction:
    """One obstruction of a motion.

    Attributes:
        amount: Size of the violation: depth or missing clearance [m], excess over a limit [rad, m, Nm,
            N], or violation in the requirement's unit.
        place: Place on the way, from 0 (start) to 1 (goal); None if it is not on the way.
        residual: Class of the violated residual; None if no program was solved.
        begin: Of a changing object: start of the obstruction [s].
        end: Its end [s]; infinite if it stays.
    """

    kind: ObstructionKind
    subjects: tuple[str, ...]
    amount: float
    place: float | None
    words: str
    residual: type[object] | None = None
    begin: float | None = None
    end: float | None = None

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {
            "kind": self.kind.name,
            "subjects": list(self.subjects),
            "amount": self.amount,
            "place": self.place,
            "words": self.words,
            "begin": self.begin,
            "end": None if self.end == inf else self.end,
        }


def blocks_of(seen: Examination) -> tuple[Obstruction, ...]:
    """Return the faults of an examined configuration: joints beyond limits, then contacts."""
    beyond = (
        Obstruction(
            kind=ObstructionKind.JOINT_LIMIT,
            subjects=(item.joint,),
            amount=item.excess,
            place=None,
            words=item.words,
        )
        for item in seen.out_of_limits
    )
    touching = (
        Obstruction(
            kind=ObstructionKind.CONTACT,
            subjects=(item.first, item.second),
            amount=item.required - item.distance,
            place=None,
            words=item.words,
        )
        for item in seen.collisions
    )
    return (*beyond, *touching)


def blocks_of_overloads(overloads: Sequence[Overload], where: str = "") -> tuple[Obstruction, ...]:
    """Return the joints that cannot hold still as obstructions.

    Args:
        where: Place as a phrase: "at the goal".
    """
    return tuple(
        Obstruction(
            kind=ObstructionKind.EFFORT,
            subjects=(item.joint,),
            amount=item.excess,
            place=None,
            words=item.words(where),
        )
        for item in overloads
    )


def blocks_on_the_way(problem: Problem, solved: SolveResult) -> tuple[Obstruction, ...]:
    """Return the violated constraints of a solver's result, each at its worst, worst first."""
    return tuple(_obstruction(problem, block, row) for block, row in _violated(problem, solved))


def worst_on_the_way(problem: Problem, solved: SolveResult) -> Obstruction | None:
    return next((_obstruction(problem, block, row) for block, row in _violated(problem, solved)), None)


def _violated(problem: Problem, solved: SolveResult) -> list[tuple[ConstraintRows, int]]:
    found: dict[tuple[object, ...], tuple[float, ConstraintRows, int]] = {}
    for block in solved.at.constraints:
        violation = block.violation
        for row in np.flatnonzero(violation > block.tolerance).tolist():
            share, key = (
                float(violation[row]) / block.tolerance,
                (block.kind, *_subjects(problem, block, row)),
            )
            if key not in found or found[key][0] < share:
                found[key] = (share, block, row)
    return [(block, row) for _, block, row in sorted(found.values(), key=lambda entry: -entry[0])]


def _subjects(problem: Problem, block: ConstraintRows, row: int) -> tuple[str, ...]:
    if block.kind is Clearance:
        return problem.reduced.owners(int(block.rows.component[row]))
    if block.kind is HoldingTorque:
        return (problem.reduced.joint_names[int(block.rows.component[row])],)
    return (block.name,)


def _obstruction(problem: Problem, block: ConstraintRows, row: int) -> Obstruction:
    amount, kind = float(block.violation[row]), ObstructionKind.REQUIREMENT
    subjects, place = _subjects(problem, block, row), float(block.rows.place[row]) / (problem.knots - 1)
    what = f"{block.name} by {in_unit(amount, block.unit_of(row))}"
    if block.kind is Clearance:
        pairs, pair = problem.reduced.pairs, int(block.rows.component[row])
        kind, required = ObstructionKind.CONTACT, float(pairs.required[pair] - pairs.error[pair])
        bound = f" ({1000 * required:g} mm required)" if required > 0.0 else ""
        what = f"clearance of {subjects[0]} from {subjects[1]}{bound} by {1000 * amount:.1f} mm"
    elif block.kind is HoldingTorque:
        overload = _overload(problem, block, row)
        kind, amount, what = ObstructionKind.EFFORT, overload.excess, overload.words()
    return Obstruction(
        kind=kind,
        subjects=subjects,
        amount=amount,
        place=place,
        words=f"{what} at {place:.0%} of the way",
        residual=block.kind,
    )


def _overload(problem: Problem, block: ConstraintRows, row: int) -> Overload:
    joint = int(block.rows.component[row])
    name, limit = problem.reduced.joint_names[joint], float(problem.limits.effort[joint])
    need = abs(float(block.rows.value[row])) * limit
    return Overload(joint=name, torque=need, limit=limit, unit=effort_unit(problem.scene.robot.model, name))


def overloaded(overloads: Sequence[Overload], where: str) -> str:
    return "; ".join(item.words(where) for item in overloads[:NAMED])


def out_of_limits(seen: Examination) -> str:
    words = "; ".join(item.words for item in blocks_of(seen) if item.kind is ObstructionKind.JOINT_LIMIT)
    sizes = ((item.joint, item.position, item.lower, item.upper, item.unit) for item in seen.out_of_limits)
    return words + next(filter(None, (meant_in_joint(*item) for item in sizes)), "")


def collisions(seen: Examination) -> str:
    touching = (item.words for item in blocks_of(seen) if item.kind is ObstructionKind.CONTACT)
    depths = (item.distance for item in seen.collisions)
    return "; ".join(list(touching)[:NAMED]) + meant_at_depth(-min(depths, default=0.0))


def joint_goal_beyond_limits(problem: Problem) -> tuple[Obstruction, ...]:
    """Return the joints whose goal, with its tolerance, is outside their limits."""
    limits = problem.reduced.limits
    blocks: list[Obstruction] = []
    meant: list[str] = []
    for goal in without_followers(problem.goals, problem.reduced):
        if not isinstance(goal, JointPositions):
            continue
        for joint, wanted in goal.positions.items():
            if joint not in limits.joint_names:
                continue
            place = limits.joint_names.index(joint)
            lower, upper = float(limits.lower[place]), float(limits.upper[place])
            excess = max(wanted - goal.below[joint] - upper, lower - wanted - goal.above[joint])
            if excess > EXCESS * max(1.0, abs(upper if wanted > upper else lower)):
                unit = joint_unit(problem.scene.robot.model, joint)
                words = f"{joint} at {in_joint_position(wanted, unit)} is {in_unit(excess, unit)} outside "
                words += in_range(lower, upper, unit)
                words += limits.because(joint, LimitKind.UPPER if wanted > upper else LimitKind.LOWER)
                kind = ObstructionKind.JOINT_LIMIT
                blocks.append(
                    Obstruction(kind=kind, subjects=(joint,), amount=excess, place=None, words=words)
                )
                meant.append(meant_in_joint(joint, wanted, lower, upper, unit))
    if any(meant):
        blocks[-1] = replace(blocks[-1], words=blocks[-1].words + next(filter(None, meant)))
    return tuple(blocks)


def unreachable(
    reduced: ReducedModel, clash: tuple[Requirement, ...], nearest: Floats, goals: Sequence[Requirement]
) -> str:
    if len(clash) > 1:
        each = " and ".join(str(item) for item in clash)
        return f"no configuration was found that holds {each} together, though any one fewer can be held"
    missed = missed_at(reduced, goals, nearest) + _at_limits(reduced, nearest, goals)
    cause = _of_unmoved_frames(reduced, goals) or _of_too_few_joints(reduced, goals)
    return f"the nearest of the configurations tried misses the goal by {missed}{cause}"


def _at_limits(reduced: ReducedModel, positions: Floats, goals: Sequence[Requirement]) -> str:
    limits, found = reduced.limits, list[str]()
    for joint, at, lower, upper, matters in zip(
        limits.joint_names, positions, limits.lower, limits.upper, _moving(reduced, goals), strict=True
    ):
        limit = lower if at - lower < upper - at else upper
        if matters and abs(at - limit) < AT_LIMIT:
            unit = joint_unit(reduced.scene.robot.model, joint)
            found.append(f"{joint} at its limit of {in_unit(limit, unit)}")
    return f", with {' and '.join(found)}" if found else ""


def _moving(reduced: ReducedModel, goals: Sequence[Requirement]) -> Bools:
    """Return which of the group's joints move a frame of the goals; all if one is not about frames."""
    if not all(goal.frames for goal in goals):
        return np.ones(len(reduced.joint_names), dtype=np.bool_)
    model, carrying = reduced.model, {reduced.anchors[name].joint for goal in goals for name in goal.frames}
    rows = [model.joints[number].idx_v for joint in carrying for number in list(model.supports[joint])[1:]]
    carried: Bools = (reduced.mimic_matrix[rows] != 0.0).any(axis=0)
    return carried


AT_LIMIT = 1e-4
"""Distance from a limit up to which a joint counts as at it [rad | m]."""


def _of_unmoved_frames(reduced: ReducedModel, goals: Sequence[Requirement]) -> str:
    for goal in goals:
        if isinstance(goal, FramePlacement):
            moved, reference = reduced.anchors[goal.frame], reduced.anchors[goal.reference]
            if moved.joint == reference.joint:
                against = "" if goal.reference == WORLD else f" relative to {goal.reference}"
                return f"; no joint of group {reduced.group} moves {goal.frame}{against}"
    return ""


def _of_too_few_joints(reduced: ReducedModel, goals: Sequence[Requirement]) -> str:
    count = len(reduced.joint_names)
    for goal in goals:
        if isinstance(goal, FramePlacement):
            held = np.isfinite(goal.position_tolerance).sum() + (goal.rotation_tolerance < np.pi).sum()
            if held > count:
                free = "one" if held == count + 1 else f"{held - count}"
                tolerances = {1: "(0.01, 0.01, inf)", 2: "inf", 3: "inf"}
                turns = (goal.rotation_tolerance < np.pi).all() and held - count in tolerances
                example = f", such as rotation_tolerance={tolerances[held - count]}" if turns else ""
                joints = "1 joint moves" if count == 1 else f"{count} joints move"
                return (
                    f"; {joints} in group {reduced.group}, and the goal fixes {held} axes of {goal.frame}: "
                    f"leave {free} of them free{example}"
                )
    return ""


def no_goal_configuration(reduced: ReducedModel, found: GoalCandidates, goals: Sequence[Requirement]) -> str:
    if found.blocking is None:
        return unreachable(reduced, (), found.nearest, goals)
    nearest = how_near(*found.blocking, found.required) + meant_at_depth(-found.blocking[2])
    if found.colliding == 1:
        how = "collides" if found.required == 0.0 else "collides or comes too near to something"
        return f"the one configuration found that reaches the goal {how}: {nearest}"
    how = "collide" if found.required == 0.0 else "collide or come too near to something"
    return f"all {found.colliding} configurations found that reach the goal {how}; in the nearest, {nearest}"


def none_can_be_held(count: int, least: Sequence[Overload]) -> str:
    """Return the reason that no configuration at a goal can be held.

    Args:
        least: The overloaded joints at the configuration that needs least.
    """
    if count == 1:
        found = "the one configuration found that reaches the goal and keeps clear cannot be held"
        return f"{found}: {overloaded(least, 'at the goal')}"
    found = f"none of the {count} configurations found that reach the goal and keep clear can be held"
    return f"{found}; in the one that needs least, {overloaded(least, 'at the goal')}"


def nowhere_within(message: str) -> str:
    return f"{message}; that is in the middle, and nothing better was found within the goal's tolerance"


def stuck(problem: Problem, solved: SolveResult) -> str:
    along = any(isinstance(item, FollowsCurve) for item in problem.requirements)
    hint = "; trajopt.tasks.cartesian.follow is made for curves: it takes as many knots as they need" * along
    worst = worst_on_the_way(problem, solved)
    assert worst is not None, "a result that is stuck violates a constraint"
    return f"{solved.status.value}; worst is {worst.words}{hint}"


def enclosed(problem: Problem, cut: ClosedCut) -> str:
    between = " or ".join(f"{first} and {second}" for first, second in cut.pairs[:NAMED])
    required = max(problem.scene.clearance_of(*pair) for pair in cut.pairs[:NAMED])
    how = "collide" if required == 0.0 else f"come nearer than the required {1000 * required:g} mm or collide"
    at = in_joint_position(cut.position, joint_unit(problem.scene.robot.model, cut.joint))
    return f"{cut.joint} has to pass {at} on the way, and there {between} {how}, whatever the other joints do"


def margin_out_of_reach(problem: Problem, cut: ClosedCut) -> str:
    first, second = cut.pairs[0]
    margin = 1000 * problem.scene.margin_of(first, second)
    at = in_joint_position(cut.position, joint_unit(problem.scene.robot.model, cut.joint))
    return (
        f"no motion keeps the margin of {margin:g} mm between {first} and {second}: {cut.joint} has to pass "
        f"{at} on the way, and there something is nearer than its margin, whatever the other joints do"
    )


def not_verified(certificate: Certificate) -> str:
    return "; ".join(f"{check.name}: {check.detail}" for check in certificate.failed)


def resting_hint(problem: Problem) -> str:
    """Return a hint for a payload that touches something at the start; empty if it touches nothing."""
    scene = problem.scene
    start = problem.reduced.all_positions(problem.reduced.start_positions)
    excused = {allowance.pair for allowance in scene.allowances if allowance.first > 0.0}
    found = [
        (name, support)
        for name in scene.objects
        if scene.holder(name).link != WORLD
        for support in supports(scene, name, scene.placement_of(name, start))
        if not scene.may_touch(name, support) and frozenset((name, support)) not in excused
    ]
    if not found:
        return ""
    name, support = found[0]
    return (
        f"; {shown(name)} touches {shown(support)} at the start: if it rests there until it is lifted, "
        f"attach it with `resting_on={support!r}`"
    )
