"""The statement of a proof, from a problem and a motion."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.files.proof.parts import ConvexPart, Document, convex_part, placed
from trajopt.files.proof.requirements import Shown, stated, stated_speed
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, readonly
from trajopt.values.placement import Placement
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.pair_distances import required_clearances


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of convex parts that a proof is about.

    Attributes:
        pairs: Two of them in each row, shape (p, 2).
        required: Clearance of each pair, shape (p,) [m].
        excused: Two owners, and the reason why they need not keep apart.
    """

    parts: tuple[ConvexPart, ...]
    pairs: Ints
    required: Floats
    excused: tuple[tuple[str, str, str], ...]

    def excusing(self, lost: Collection[int], reason: str) -> "Pairs":
        gone = {_owners(self.parts, *self.pairs[pair].tolist()) for pair in lost}
        kept = [_owners(self.parts, one, other) not in gone for one, other in self.pairs.tolist()]
        excused = tuple((min(owners), max(owners), reason) for owners in gone)
        return Pairs(self.parts, self.pairs[kept], self.required[kept], self.excused + excused)


def proven_pairs(reduced: ReducedModel) -> Pairs:
    """Return the convex parts of a model and their pairs, and the pairs of owners that are excused."""
    found = [convex_part(body) for body in reduced.bodies]
    place = np.cumsum([part is not None for part in found]) - 1
    parts = tuple(part for part in found if part is not None)
    windows = {pair for pair, _ in reduced.pairs.allowances}
    required = required_clearances(reduced)
    rows: list[tuple[int, int]] = []
    levels: list[float] = []
    excused: dict[frozenset[str], str] = {}
    listed: set[frozenset[str]] = set()
    for pair, (one, other) in enumerate(zip(reduced.pairs.first, reduced.pairs.second, strict=True)):
        bodies = found[int(one)], found[int(other)]
        owners = frozenset(reduced.owners(pair))
        listed.add(owners)
        if pair in windows:
            excused[owners] = "contact is accepted for a time, which was judged and is not part of this proof"
        elif any(part is not None and part.is_half_space and part.body.joint for part in bodies):
            excused[owners] = "a half-space moves, which was judged and is not part of this proof"
        elif None not in bodies:
            rows.append((int(place[one]), int(place[other])))
            levels.append(float(required[pair]))
    for one, first in enumerate(parts):
        for second in parts[one + 1 :]:
            owners = frozenset((first.body.owner, second.body.owner))
            if first.body.joint != second.body.joint and len(owners) == 2 and owners not in listed:
                excused[owners] = "the scene accepts their contact"
    kept = [row for row, (one, other) in enumerate(rows) if _owners(parts, one, other) not in excused]
    return Pairs(
        parts,
        np.array(rows, dtype=np.int64).reshape(-1, 2)[kept],
        np.array(levels, dtype=np.float64)[kept],
        tuple((min(owners), max(owners), reason) for owners, reason in excused.items()),
    )


def _owners(parts: Sequence[ConvexPart], one: int, other: int) -> frozenset[str]:
    return frozenset((parts[one].body.owner, parts[other].body.owner))


@dataclass(frozen=True, eq=False)
class Asked:
    """The requirements of a proof.

    Attributes:
        documents: The requirements that are part of the proof.
        shown: Intervals in which requirements of all times can be shown.
        judged: Sentences on facts that are not part of the proof.
    """

    documents: tuple[Document, ...]
    shown: tuple[Shown, ...]
    judged: tuple[str, ...]


def asked(problem: Problem, motion: JudgedMotion) -> Asked:
    """Return the requirements of a problem, and the facts that are judged but not part of a proof."""
    found, judged = list[Document](), list[str]()
    shown: list[Shown] = []
    stages: tuple[tuple[str, bool, Sequence[Requirement]], ...] = (
        ("goal", False, problem.goals),
        ("at all times", True, problem.requirements),
    )
    for label, always, requirements in stages:
        for item in requirements:
            part = stated(item, motion, always=always)
            if part is None:
                judged.append(f"{label}: {item}")
                continue
            found.append(part.document)
            shown += [part.shown] if part.shown is not None else []
    for tool in problem.tool_speeds:
        part = stated_speed(tool, motion)
        if part is None or part.shown is None:
            judged.append(f"tool speed: {tool}")
            continue
        found.append(part.document)
        shown.append(part.shown)
    return Asked(tuple(found), tuple(shown), (*judged, *_only_judged(problem, motion)))


def _only_judged(problem: Problem, motion: JudgedMotion) -> list[str]:
    reduced, scene = motion.reduced, problem.scene
    found = [f"waypoint {name}" for name in problem.waypoint_names]
    found += [f"between waypoints: {item.required}" for item in problem.partial]
    found += [f"user code: {item.residual.name}" for item in problem.residual_constraints]
    if problem.finish_by is not None:
        found.append(f"the motion ends by {problem.finish_by:g} s")
    if problem.dwell > 0.0:
        found.append(f"it stays clear for {problem.dwell:g} s after the end")
    clouds = {body.owner for body in reduced.bodies if convex_part(body) is None}
    found += [f"clearance from {name}, a cloud" for name in sorted(clouds)]
    found += [f"clearance from {name}, which changes with time" for name in sorted(scene.changing)]
    if scene.robot.base.rolls and set(scene.robot.base.joints) <= set(reduced.joint_names):
        found.append("the wheels of the base roll")
    return found


def statement(problem: Problem, motion: JudgedMotion, pairs: Pairs, requirements: Asked) -> Document:
    """Return the statement as plain data, in the order and with the names of `proof/1`."""
    trajectory, reduced, options = motion.trajectory, motion.reduced, motion.options
    rows = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    start = (reduced.start_positions, problem.start_velocities, problem.start_accelerations)
    return {
        "title": problem.name,
        "motion": {
            "coordinates": list(reduced.joint_names),
            "times": trajectory.times.tolist(),
            "values": [row.tolist() for row in rows if row is not None],
        },
        "joints": _joints(motion, problem.moving_limits),
        "ends": {
            **dict(zip(("positions", "velocities", "accelerations"), np.array(start).tolist(), strict=True)),
            "tolerance": options.start_error,
            "speed": options.rest_speed,
            "rests": motion.rests_after,
        },
        "excess": options.excess,
        "parts": [part.document() for part in pairs.parts],
        "pairs": [
            [*row, level] for row, level in zip(pairs.pairs.tolist(), pairs.required.tolist(), strict=True)
        ],
        "excused": [list(row) for row in pairs.excused],
        "requirements": list(requirements.documents),
        "judged": [_printable(each) for each in requirements.judged],
    }


def _printable(text: str) -> str:
    return "".join(sign if sign.isprintable() else " " for sign in text)[:1000]


def _joints(motion: JudgedMotion, limits: JointLimits) -> list[Document]:
    reduced, arm = motion.reduced, motion.kinematics
    matrix, offset = reduced.mimic_matrix, reduced.mimic_offset
    found: list[Document] = []
    for row, (name, at) in enumerate(
        zip(reduced.moving_joints, list(reduced.model.jointPlacements)[1:], strict=True)
    ):
        coordinate = int(np.abs(matrix[row]).argmax())
        where = Placement(readonly(np.array(at.rotation)), readonly(np.array(at.translation)))
        bounds = (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk)
        names = ("lower", "upper", "velocity", "acceleration", "jerk")
        found.append(
            {
                "name": name,
                "place": placed(arm.parents[row + 1], where),
                "turns": bool(arm.revolute[row + 1]),
                "axis": arm.axes[row + 1].tolist(),
                "coordinate": coordinate,
                "factor": float(matrix[row, coordinate]),
                "offset": float(offset[row]),
                **dict(zip(names, (_finite(float(bound[row])) for bound in bounds), strict=True)),
            }
        )
    return found


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
