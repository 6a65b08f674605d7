"""The statement of a proof, from a problem and a motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.files.proof.pairs import Document, Pairs, placed
from trajopt.files.proof.requirements import RequirementRecord, stated, stated_speeds
from trajopt.problem.problem import Problem
from trajopt.problem.requirement import During
from trajopt.problem.requirements import Requirement
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import payloads
from trajopt.scene.track import Timing
from trajopt.values.arrays import Bools, Floats, readonly
from trajopt.values.placement import Placement
from trajopt.values.trajectory import refined
from trajopt.verify.checks.required import passages
from trajopt.verify.kernel.motion import JudgedMotion, Polynomials, TimedMotion

SETTLING = 9
"""Times of the grid while accelerations fall to zero after the end of a motion."""


@dataclass(frozen=True, eq=False)
class Asked:
    """The requirements of a proof.

    Attributes:
        records: Requirements to state; at all times only if they can be shown.
        judged: Sentences on facts not part of the proof.
        times: Moments that the grid must have [s].
    """

    records: tuple[RequirementRecord, ...]
    judged: tuple[str, ...]
    times: tuple[float, ...] = ()


def asked(problem: Problem, motion: JudgedMotion) -> Asked:
    """Return the requirements of a problem, and the facts that are judged but not part of a proof."""
    followed = followed_goals(problem)
    begin, end = motion.duration - (problem.dwell if followed else motion.staying), motion.duration
    found: list[tuple[str, RequirementRecord | None]] = []
    for item in problem.goals:
        if item in followed and problem.dwell > 0.0:
            found.append((f"goal: {item}", _in_part(stated(item, motion, always=True), begin, end)))
        else:
            found.append((f"goal: {item}", stated(item, motion, always=False)))
    found += [(f"at all times: {item}", stated(item, motion, always=True)) for item in problem.requirements]
    found += [
        (f"tool speed: {item}", record)
        for item in problem.tool_speeds
        for record in stated_speeds(item, motion)
    ]
    if not followed and (problem.finish_by is not None or problem.dwell > 0.0):
        rest: Document = {"kind": "rest", "since": begin, "by": problem.finish_by}
        found.append(("rest", RequirementRecord(rest)))
    judged = [words for words, record in found if record is None]
    records = [replace(record, words=words) for words, record in found if record is not None]
    times, passed, missed = _on_the_way(problem, motion)
    times += tuple(time for record in records for time in record.times)
    if motion.staying > 0.0:  # accelerations that end there are within their limits in parts of these cells
        settling: Floats = np.linspace(begin, float(motion.trajectory.times[-2]), SETTLING)
        times += tuple(settling.tolist())
    moments = (*times, begin, end) if problem.dwell > 0.0 else times
    return Asked((*records, *passed), (*judged, *missed, *_only_judged(problem, motion)), moments)


def _in_part(record: RequirementRecord | None, since: float, until: float) -> RequirementRecord | None:
    if record is None or record.shown is None:
        return None
    whole = record.shown

    def shown(begin: Floats, end: Floats) -> Bools:
        return whole(begin, end) | (end <= since) | (begin >= until)

    stated: Document = {"kind": "part", "since": since, "until": until, "requirement": record.document}
    return replace(record, document=stated, shown=shown)


def _on_the_way(
    problem: Problem, motion: JudgedMotion
) -> tuple[tuple[float, ...], list[RequirementRecord], list[str]]:
    """Return moments and requirements of waypoints and between them, and names of those that have no rule."""
    wanted = dict(zip(problem.waypoint_names, problem.waypoint_requirements, strict=True))
    parts = [
        During(item.required, item.after, item.until)
        for item in problem.partial
        if isinstance(item.required, Requirement)
    ]
    passed = dict(passages(motion, wanted, parts))
    times, found, missed = set[float](), list[RequirementRecord](), list[str]()
    for name, passage in passed.items():
        records = [stated(item, motion, always=False) for item in wanted[name]]
        documents = [record.document for record in records if record is not None]
        if len(documents) < len(records):
            missed.append(f"waypoint {name}")
            continue
        times.add(passage.time)
        at: Document = {"kind": "waypoint", "name": printable(name), "time": passage.time}
        found += [RequirementRecord({**at, "requirement": each}) for each in documents]
    for part in parts:
        since = 0.0 if part.after is None else passed[part.after].time
        until = motion.duration if part.until is None else passed[part.until].time
        record = _in_part(stated(part.required, motion, always=True), since, until)
        if record is None or until <= since:
            missed.append(f"between waypoints: {part}")
            continue
        times.update((since, until))
        found.append(replace(record, words=f"between waypoints: {part}"))
    return tuple(times), found, missed


def followed_goals(problem: Problem) -> tuple[Requirement, ...]:
    reduced, timed = problem.reduced, problem.reduced.timed
    moving = set[str]() if timed is None else timed.reduced.anchors.keys() - reduced.anchors.keys()
    return tuple(goal for goal in problem.goals if moving.intersection(goal.frames))


def _only_judged(problem: Problem, motion: JudgedMotion) -> list[str]:
    reduced, robot = motion.reduced, problem.scene.robot
    found = [
        f"between waypoints: {item}" for item in problem.partial if not isinstance(item.required, Requirement)
    ]
    found += [f"user code: {item.residual.name}" for item in problem.residual_constraints]
    found += [
        f"contact of {item.a} and {item.b}: at most {1000.0 * item.depth:g} mm deep"
        for item in problem.scene.allowances
    ]
    if followed_goals(problem):
        found.append("the motion is at rest relative to its goal")
        found += [] if problem.finish_by is None else [f"it is at its goal by {problem.finish_by:g} s"]
    error = problem.scene.model_error.payload
    if error > 0.0 and payloads(reduced):
        found.append(f"torque for a payload that is {100.0 * error:g} % lighter or heavier")
    if robot.base.rolls and set(robot.base.joints) <= set(reduced.joint_names):
        found.append("the wheels of the base roll")
    return found


def statement(
    problem: Problem,
    motion: JudgedMotion,
    pairs: Pairs,
    requirements: Sequence[Document] = (),
    judged: Sequence[str] = (),
) -> Document:
    """Return the statement as plain data, in the order and with the names of `proof/1`."""
    reduced, options = motion.reduced, motion.options
    start = (reduced.start_positions, problem.start_velocities, problem.start_accelerations)
    return {
        "title": printable(problem.name),
        "motion": stated_motion(motion),
        "drives": _drives(motion, pairs.knots),
        "joints": stated_joints(motion.among, problem.moving_limits),
        "ends": {
            **dict(zip(("positions", "velocities", "accelerations"), np.array(start).tolist(), strict=True)),
            "tolerance": options.start_error,
            "speed": options.rest_speed,
            "rests": motion.rests_after,
        },
        "excess": options.excess,
        "parts": [part.document() for part in pairs.parts],
        "changes": [_change(name, timing) for name, timing in pairs.changes.items()],
        "pairs": [
            [*row, level] for row, level in zip(pairs.pairs.tolist(), pairs.required.tolist(), strict=True)
        ],
        "excused": [list(row) for row in pairs.excused],
        "contacts": [[*sorted(owners), *map(_finite, span)] for owners, span in pairs.contacts.items()],
        "requirements": list(requirements),
        "judged": [printable(each) for each in judged],
    }


def stated_motion(motion: JudgedMotion) -> Document:
    trajectory = motion.trajectory
    rows = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    return {
        "coordinates": list(motion.reduced.joint_names),
        "times": trajectory.times.tolist(),
        "values": [row.tolist() for row in rows if row is not None],
    }


def printable(text: str) -> str:
    return "".join(sign if sign.isprintable() else " " for sign in text)[:1000]


def _drives(motion: JudgedMotion, knots: Floats) -> list[Document]:
    if not isinstance(motion.among, TimedMotion) or not motion.among.timed.driven.names:
        return []
    driven, degree = motion.among.timed.driven, len(motion.among.timed.driven.coefficients)
    times = np.concatenate(((0.0,), knots, (motion.duration,)))
    orders = [Polynomials(times, refined(times, driven.times, driven.coefficients, degree))]
    while len(orders) < (2 if degree <= 4 else 3):
        orders.append(orders[-1].derivative())
    pieces = np.repeat(np.arange(len(times) - 1), 2)
    since = np.stack((np.zeros(len(times) - 1), np.diff(times)), axis=1).ravel()
    return [
        {
            "coordinates": list(driven.names),
            "times": np.repeat(times, 2)[1:-1].tolist(),
            "values": [order.at(pieces, since).tolist() for order in orders],
        }
    ]


def _change(name: str, timing: Timing) -> list[object]:
    error = (0.0, 0.0, 0.0) if timing.motion is None else timing.motion.error
    return [name, _finite(timing.appears), _finite(timing.expires), list(error)]


def stated_joints(motion: JudgedMotion, limits: JointLimits) -> list[Document]:
    """Return the joints as a proof states them."""
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
                **{
                    kind: _finite(float(bound[row])) if row < len(bound) else None
                    for kind, bound in zip(names, bounds, strict=True)
                },
            }
        )
    return found


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
